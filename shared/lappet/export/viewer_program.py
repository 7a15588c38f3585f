"""Find the program of lessons, built from `viewer/`: the package's own, or that of a checkout's build folder."""

from __future__ import annotations

from pathlib import Path

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode

NAME = "lesson.js"


def viewer_program() -> str:
    """Read the program that a lesson carries.

    Returns
    -------
    str
        JavaScript, with its libraries and their notices.

    Raises
    ------
    RefusedError
        If it was not built.
    """
    package = Path(__file__).resolve().parent.parent
    checkout = package.parent.parent
    places = [package / "viewer" / NAME]
    if (checkout / "viewer" / "package.json").is_file():
        places.append(checkout / "build" / "viewer" / NAME)
    for path in places:
        if path.is_file():
            return path.read_text(encoding="utf-8")
    raise refused(ProblemCode.EXPORT_VIEWER, NAME, " and ".join(map(str, places)))
