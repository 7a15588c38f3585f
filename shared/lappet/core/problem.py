"""What is wrong, as a value: one `Problem` each, and the error that carries them to whoever shows them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from lappet.core import problem_text
from lappet.core.problem_code import ProblemCode

Severity = Literal["error", "warning"]


@dataclass(frozen=True)
class Place:
    """Where on a mesh a problem is.

    Parameters
    ----------
    faces
        Indices of faces.
    points
        Points in mm, in the coordinates of the mesh.
    """

    faces: tuple[int, ...] = ()
    points: tuple[tuple[float, float, float], ...] = ()


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong.

    Parameters
    ----------
    code
        What kind of problem it is.
    prim
        Path of the prim ("/Procedure/Timeline/hook_1"), or of the file where there is no prim.
    value
        What was found, as text.
    message
        What is wrong, naming the thing and the value, for people.
    remedy
        What to do about it, for people.
    severity
        "error", refused before solving, or "warning", solved nevertheless.
    place
        Where on a mesh it is, or None.
    """

    code: ProblemCode
    prim: str
    value: str
    message: str
    remedy: str
    severity: Severity = "error"
    place: Place | None = None

    def __str__(self) -> str:
        said = f"{self.message} {self.remedy}".strip()
        return f"{self.prim}: {said}" if self.prim else said


class RefusedError(ValueError):
    """Work that is refused; its text is made from its problems.

    Parameters
    ----------
    problems
        Every reason.
    """

    def __init__(self, problems: Sequence[Problem] | str) -> None:
        if isinstance(problems, str):
            problems = (problem(ProblemCode.UNSORTED, said=problems),)
        super().__init__(tuple(problems))

    @property
    def problems(self) -> tuple[Problem, ...]:
        """Every reason, in order."""
        return self.args[0]

    def __str__(self) -> str:
        return "\n".join(str(each) for each in self.problems)


def problem(
    code: ProblemCode,
    prim: object = "",
    value: object = "",
    *,
    severity: Severity = "error",
    place: Place | None = None,
    **fields: object,
) -> Problem:
    """Make the problem of a code, with the texts of the catalogue.

    Parameters
    ----------
    code
        What kind of problem it is.
    prim
        Path of the prim or the file.
    value
        What was found.
    severity
        "error" or "warning".
    place
        Where on a mesh it is, or None.
    **fields
        What else the texts name.

    Returns
    -------
    Problem
        The problem.
    """
    message, remedy = problem_text.texts(code, {"prim": prim, "value": value, **fields})
    return Problem(code, str(prim), str(value), message, remedy, severity, place)


def refused(
    code: ProblemCode, prim: object = "", value: object = "", *, place: Place | None = None, **fields: object
) -> RefusedError:
    """Make the error that carries the one problem of a code: `raise refused(ProblemCode.X, prim, value, …)`.

    Parameters
    ----------
    code
        What kind of problem it is.
    prim
        Path of the prim or the file.
    value
        What was found.
    place
        Where on a mesh it is, or None.
    **fields
        What else the texts name.

    Returns
    -------
    RefusedError
        The error.
    """
    return RefusedError((problem(code, prim, value, severity="error", place=place, **fields),))
