"""What the worker tells its owner: the plan of a procedure, its frames as they come, and how it ended."""

from __future__ import annotations

from dataclasses import dataclass

from lappet.background.plan import Plan
from lappet.core.problem import Problem
from lappet.daemon.solved_frame import SolvedFrame


@dataclass(frozen=True, eq=False)
class Planned:
    """The procedure of a job is compiled. known: per frame, whether the store holds it."""

    job: int
    plan: Plan
    known: tuple[bool, ...]


@dataclass(frozen=True)
class Refused:
    """The procedure of a job cannot be solved; nothing was done."""

    job: int
    problems: tuple[Problem, ...]


@dataclass(frozen=True)
class IterationDone:
    """A Newton iteration is done: time code, its number, residual over force scale, largest gap in mm."""

    job: int
    time: float
    newton: int
    residual: float
    gap: float


@dataclass(frozen=True, eq=False)
class FrameReady:
    """A frame is there. looked_up: it came from the store. frame: as shown; None where it was looked up (read it
    from there)."""

    job: int
    time: int
    key: str
    looked_up: bool
    frame: SolvedFrame | None


@dataclass(frozen=True)
class FrameFailed:
    """A frame did not converge or was refused; the job ends there."""

    job: int
    time: int
    problem: Problem


@dataclass(frozen=True)
class Finished:
    """A job has ended. frames: how many are there. seconds: wall clock. cancelled: by its owner."""

    job: int
    frames: int
    seconds: float
    cancelled: bool = False


@dataclass(frozen=True)
class Note:
    """A sentence for the user: the daemon died and was started again, the store cannot be written ..."""

    job: int
    sentence: str


@dataclass(frozen=True, eq=False)
class LiveFrame:
    """Live mode: the skin for the hook's latest target. seconds: that the solver took. time: of the frame pulled at."""

    job: int
    time: int
    target: tuple[float, float, float]
    frame: SolvedFrame
    converged: bool
    seconds: float


WorkerEvent = Planned | Refused | IterationDone | FrameReady | FrameFailed | Finished | Note | LiveFrame
