"""A case of the stability matrix, what it solves and what became of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem_code import ProblemCode
from lappet.daemon.solved_frame import SolvedFrame
from lappet.program.program import Program

Check = Callable[["Solved"], str]
Start = Callable[[NDArray[np.float64]], NDArray[np.float64]]


@dataclass(frozen=True, eq=False)
class Solved:
    """The frames of a case that converged.

    Parameters
    ----------
    program
        What was solved.
    frames
        The frames.
    twin
        Last frame of its twin, or None.
    """

    program: Program
    frames: tuple[SolvedFrame, ...]
    twin: SolvedFrame | None = None


@dataclass(frozen=True, eq=False)
class Scene:
    """What is solved.

    Parameters
    ----------
    program
        The program.
    start
        Where the first frame starts from: positions in mm, shape (N, 3), for nodes at rest in mm, shape (N, 3).
    check
        Says what is wrong with the result, a sentence or an empty text.
    twin
        What the result is compared with, solved before and from rest; the program itself where there is a start.
    """

    program: Program
    start: Start | None = None
    check: Check | None = None
    twin: Program | None = None


@dataclass(frozen=True)
class Case:
    """A case of the matrix.

    Parameters
    ----------
    name
        Name of the case.
    group
        Name of its group.
    scene
        Makes what is solved; may refuse.
    converges
        Whether an equilibrium is a right outcome.
    refuses
        Codes of the refusals that are a right outcome too.
    budget
        Seconds that it may take.
    slow
        Whether it is left out of the quick report.
    """

    name: str
    group: str
    scene: Callable[..., Scene | Program]
    converges: bool = True
    refuses: tuple[ProblemCode, ...] = ()
    budget: float = 60.0
    slow: bool = False

    @property
    def expected(self) -> str:
        """The outcomes that are right, for people."""
        refuses = "refuses: " + " | ".join(self.refuses) if self.refuses else ""
        return " or ".join(part for part in ("converges" if self.converges else "", refuses) if part)


@dataclass(frozen=True)
class Row:
    """What became of a case.

    Parameters
    ----------
    case
        Name of the case.
    group
        Name of its group.
    expected
        The outcomes that are right.
    outcome
        Converges, refuses, wrong (a claim that does not hold), crashes or hangs.
    reason
        Why, a sentence; empty where it converged.
    residual
        Greatest residual of all frames as the daemon says.
    verified_residual
        Residual of the last frame in double precision.
    gap_mm
        Greatest gap of all frames.
    frames
        Number of frames.
    cells
        Number of cells.
    seconds
        Time that it took.
    budget
        Seconds that it may take.
    ok
        Whether the outcome is expected, within the budget.
    code
        Code of the problem, or None where it converged.
    """

    case: str
    group: str
    expected: str
    outcome: str
    reason: str
    residual: float | None
    verified_residual: float | None
    gap_mm: float | None
    frames: int
    cells: int
    seconds: float
    budget: float
    ok: bool
    code: ProblemCode | None = None


def totals(rows: Sequence[Row]) -> dict[str, dict[str, int]]:
    """Count the cases by group and in all.

    Parameters
    ----------
    rows
        What became of the cases.

    Returns
    -------
    dict[str, dict[str, int]]
        How many there are, as expected, converged and refused.
    """
    groups = {group: [row for row in rows if row.group == group] for group in dict.fromkeys(row.group for row in rows)}
    return {
        group: {
            "cases": len(of),
            "ok": sum(row.ok for row in of),
            "converged": sum(row.outcome == "converges" for row in of),
            "refused": sum(row.outcome == "refuses" for row in of),
        }
        for group, of in {**groups, "all": list(rows)}.items()
    }
