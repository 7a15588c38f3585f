"""What the worker tells its owner: the manifest of a procedure, its frames as they come, and how it ended."""

from __future__ import annotations

from dataclasses import dataclass

from lappet.background.assessment import Assessment
from lappet.background.manifest import Manifest
from lappet.core.problem import Problem
from lappet.daemon.solved_frame import SolvedFrame
from lappet.procedure import Pose


@dataclass(frozen=True, eq=False)
class Listed:
    """The procedure of a job is compiled.

    Parameters
    ----------
    job
        Number of the job.
    manifest
        The manifest.
    known
        For each frame, whether the store holds it.
    """

    job: int
    manifest: Manifest
    known: tuple[bool, ...]


@dataclass(frozen=True)
class Refused:
    """The procedure of a job cannot be solved; nothing was done.

    Parameters
    ----------
    job
        Number of the job.
    problems
        Why.
    """

    job: int
    problems: tuple[Problem, ...]


@dataclass(frozen=True)
class IterationDone:
    """A Newton iteration is done.

    Parameters
    ----------
    job
        Number of the job.
    time
        Time code.
    newton
        Number of the iteration.
    residual
        Residual over force scale.
    gap
        Largest gap in mm.
    """

    job: int
    time: float
    newton: int
    residual: float
    gap: float


@dataclass(frozen=True, eq=False)
class FrameReady:
    """A frame is there.

    Parameters
    ----------
    job
        Number of the job.
    time
        Time code.
    key
        Its key in the store.
    looked_up
        Whether it came from the store.
    frame
        The frame; None where it was looked up (read it from there).
    """

    job: int
    time: int
    key: str
    looked_up: bool
    frame: SolvedFrame | None


@dataclass(frozen=True)
class FrameFailed:
    """A frame did not converge or was refused; the job ends there.

    Parameters
    ----------
    job
        Number of the job.
    time
        Time code.
    problem
        Why.
    """

    job: int
    time: int
    problem: Problem


@dataclass(frozen=True)
class Finished:
    """A job has ended.

    Parameters
    ----------
    job
        Number of the job.
    frames
        How many frames are there.
    seconds
        Run time in seconds.
    cancelled
        Whether its owner ended it.
    """

    job: int
    frames: int
    seconds: float
    cancelled: bool = False


@dataclass(frozen=True)
class Note:
    """A note or warning for the user: the daemon died and was started again, the store cannot be written, ….

    Parameters
    ----------
    job
        Number of the job.
    problem
        What the user should know.
    """

    job: int
    problem: Problem


@dataclass(frozen=True)
class Assessed:
    """What is to be known of the frames of a job, after the last one.

    Parameters
    ----------
    job
        Number of the job.
    assessment
        What it is.
    """

    job: int
    assessment: Assessment


@dataclass(frozen=True, eq=False)
class LiveFrame:
    """The skin in live mode for the latest target of the hook or retractor.

    Parameters
    ----------
    job
        Number of the job.
    time
        Time code of the frame that is pulled at.
    target
        Where it is, mm, and how it is turned.
    frame
        The frame.
    problem
        Why the tissue stayed where it was, or None where it follows the target.
    seconds
        Time that the solver took.
    """

    job: int
    time: int
    target: Pose
    frame: SolvedFrame
    problem: Problem | None
    seconds: float

    @property
    def converged(self) -> bool:
        """Whether the equilibrium was found."""
        return self.problem is None


WorkerEvent = Listed | Refused | IterationDone | FrameReady | FrameFailed | Finished | Note | Assessed | LiveFrame
