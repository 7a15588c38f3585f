"""Problems as sentences for people who work in Blender."""

from __future__ import annotations

from lappet.core.problem import Problem


def problem_sentence(found: Problem) -> str:
    """Return the message and the remedy of a problem; of a prim with its name before them."""
    name = f"{found.prim.rpartition('/')[2]}: " if found.prim.startswith("/") else ""
    return f"{name}{found.message} {found.remedy}".rstrip()
