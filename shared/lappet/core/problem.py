"""What is wrong, as a value: one `Problem` each, and the error that carries them to whoever shows them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

from lappet.core import problem_text
from lappet.core.printable import printable
from lappet.core.problem_code import ProblemCode
from lappet.core.problem_text import Severity as Severity


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

    @staticmethod
    def at(*points: Iterable[float]) -> Place:
        """Make the place of points.

        Parameters
        ----------
        *points
            Points in mm.

        Returns
        -------
        Place
            The place.
        """
        return Place(points=tuple((float(x), float(y), float(z)) for x, y, z in points))


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
        "error", refused before solving; "warning", solved nevertheless, but probably not what is meant; or "note",
        what the program does besides or otherwise than it is told.
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

    def __post_init__(self) -> None:
        object.__setattr__(self, "code", ProblemCode(self.code))  # a message from another process holds its text

    def __str__(self) -> str:
        said = f"{self.message} {self.remedy}".strip()
        named = not self.prim or problem_text.text_of(self.code).names_prim
        return said if named else f"{printable(self.prim)}: {said}"


class ProblemsError(Exception):
    """An error that carries what is wrong as values; its text is made from them.

    Parameters
    ----------
    problems
        Every reason.
    """

    def __init__(self, problems: Sequence[Problem]) -> None:
        super().__init__(tuple(problems))

    @classmethod
    def of(
        cls, code: ProblemCode, prim: object = "", value: object = "", *, place: Place | None = None, **fields: object
    ) -> Self:
        """Make the error that carries the one problem of a code.

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
        Self
            The error.
        """
        return cls((problem(code, prim, value, place=place, **fields),))

    @property
    def problems(self) -> tuple[Problem, ...]:
        """Every reason, in order."""
        return self.args[0]

    def __str__(self) -> str:
        return "\n".join(str(each) for each in self.problems)


class SentenceError(ProblemsError):
    """An error about the form of a message; all of a class have its code, and a sentence for developers.

    Parameters
    ----------
    problems
        The sentence, or the problems of another such error.
    """

    code: ClassVar[ProblemCode]

    def __init__(self, problems: Sequence[Problem] | str) -> None:
        super().__init__((problem(self.code, "", problems),) if isinstance(problems, str) else problems)


class RefusedError(ProblemsError, ValueError):
    """Work that is refused.

    Parameters
    ----------
    problems
        Every reason, or the sentence of the one reason.
    """


def problem(
    code: ProblemCode, prim: object = "", value: object = "", *, place: Place | None = None, **fields: object
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
    place
        Where on a mesh it is, or None.
    **fields
        What else the texts name.

    Returns
    -------
    Problem
        The problem.
    """
    text = problem_text.text_of(code)
    known = {"prim": prim, "value": value, **fields}
    message, remedy = (printable(each.format(**known)) for each in (text.message, text.remedy))
    return Problem(code, str(prim), str(value), message, remedy, text.severity, place)


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
    return RefusedError.of(code, prim, value, place=place, **fields)


def file_problem(error: OSError, path: object = "") -> Problem:
    """Make the problem of an error of the file system.

    Parameters
    ----------
    error
        The error.
    path
        The file, where the error does not name it.

    Returns
    -------
    Problem
        The problem.
    """
    return problem(ProblemCode.FILE_ERROR, error.filename or path, (error.strerror or str(error)).rstrip("."))
