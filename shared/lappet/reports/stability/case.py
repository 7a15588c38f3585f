"""A case of the stability matrix, what it solves and what became of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem_code import ProblemCode
from lappet.daemon.solved_frame import SolvedFrame
from lappet.program.program import Program


class Demand(StrEnum):
    """What a case must do that is not refused."""

    CONVERGES = "converges"
    BUCKLES = "buckles"
    IS_SENSITIVE = "is sensitive"


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
    demands
        The one outcome that is right: that it converges to a stable equilibrium, that this is a buckled one by the
        check of its scene, that it is close to buckling, or that it is refused with this code.
    budget
        Seconds that it may take.
    slow
        Whether it is left out of the quick report.
    """

    name: str
    group: str
    scene: Callable[..., Scene | Program]
    demands: Demand | ProblemCode = Demand.CONVERGES
    budget: float = 60.0
    slow: bool = False

    @property
    def expected(self) -> str:
        """The outcome that is right, for people."""
        return f"refuses: {self.demands}" if isinstance(self.demands, ProblemCode) else str(self.demands)


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
        The outcome that is right.
    outcome
        Converges, buckles, is sensitive, refuses, wrong (a claim that does not hold), crashes or hangs.
    reason
        Why, a sentence; empty where it converged.
    residual
        Greatest residual of all frames as the daemon says.
    lowest_stiffness
        Share of its stiffness that compression leaves the softest displacement of the last frame.
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
    lowest_stiffness: float | None
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
        How many there are, as expected, converged (buckled and sensitive ones too), buckled and refused.
    """
    groups = {group: [row for row in rows if row.group == group] for group in dict.fromkeys(row.group for row in rows)}
    return {
        group: {
            "cases": len(of),
            "ok": sum(row.ok for row in of),
            "converged": sum(row.outcome in set(Demand) for row in of),
            "buckled": sum(row.outcome == Demand.BUCKLES for row in of),
            "refused": sum(row.outcome == "refuses" for row in of),
        }
        for group, of in {**groups, "all": list(rows)}.items()
    }
