"""Problems as sentences for people who work in Blender."""

from __future__ import annotations

from lappet.core import problem_text
from lappet.core.problem import Problem
from lappet.procedure.prim_paths import ROOT, TIMELINE


def problem_sentence(found: Problem) -> str:
    """Return the message and the remedy of a problem.

    The name of its prim, object or file comes first where the message leaves it out; a stitch of a suture run is named
    with its run.
    """
    name = found.prim.rpartition("/")[2] if found.prim.startswith(f"{ROOT}/") else found.prim
    name = found.prim.removeprefix(f"{TIMELINE}/") if found.prim.startswith(f"{TIMELINE}/") else name
    named = not name or "{prim" in problem_text.text_of(found.code).message
    return f"{'' if named else f'{name}: '}{found.message} {found.remedy}".rstrip()
