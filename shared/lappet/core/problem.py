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
    """Where on a mesh a problem is. faces: indices of faces. points: in mm, in the coordinates of the mesh."""

    faces: tuple[int, ...] = ()
    points: tuple[tuple[float, float, float], ...] = ()


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong.

    code: which kind of problem. prim: the prim's path ("/Procedure/Timeline/hook_1"), or the file or object where
    there is no prim, or "". value: what was found, as text. message: what is wrong, one or more sentences. remedy:
    what to do about it. An "error" is refused before solving; a "warning" is solved nevertheless. place: where on
    the mesh. Code compares code, prim and severity; message and remedy are for people only.
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
    """Work that is refused; `problems` holds every reason. Its text is made from them."""

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
    """Return the problem of this code, with the texts of the catalogue filled with prim, value and the fields."""
    message, remedy = problem_text.texts(code, {"prim": prim, "value": value, **fields})
    return Problem(code, str(prim), str(value), message, remedy, severity, place)


def refused(
    code: ProblemCode, prim: object = "", value: object = "", *, place: Place | None = None, **fields: object
) -> RefusedError:
    """Return the error that carries the one problem of this code: `raise refused(ProblemCode.X, prim, value, …)`."""
    return RefusedError((problem(code, prim, value, severity="error", place=place, **fields),))
