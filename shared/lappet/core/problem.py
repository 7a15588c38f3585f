"""What is wrong with a procedure: one `Problem` each, and the error that carries all of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from lappet.core.refused import RefusedError

Severity = Literal["error", "warning"]


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong.

    Parameters
    ----------
    path
        Path of the prim ("/Procedure/Timeline/hook_1"), or of the file where there is no prim.
    value
        What was found, as text.
    sentence
        What is wrong, naming the thing and the value.
    remedy
        What to do about it, a sentence.
    severity
        "error", refused before solving, or "warning", solved nevertheless.
    """

    path: str
    value: str
    sentence: str
    remedy: str
    severity: Severity = "error"

    def __str__(self) -> str:
        return f"{self.path}: {self.sentence} {self.remedy}"


class ProcedureError(RefusedError):
    """A procedure that cannot be read, written, edited or solved.

    Parameters
    ----------
    problems
        Every reason; the error has them as `problems`.
    """

    def __init__(self, problems: Sequence[Problem]) -> None:
        super().__init__("\n".join(str(problem) for problem in problems))
        self.problems = tuple(problems)
