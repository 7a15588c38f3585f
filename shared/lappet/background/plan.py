"""What a background solve tells its owner: the plan of a procedure, its frames as they come, and how it ended."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Problem


@dataclass(frozen=True)
class SolveSettings:
    """How to solve: as the options of `lappet solve`.

    Parameters
    ----------
    spacing
        Lattice spacing in mm; None for the tissue's.
    tolerance
        Relative residual at which a frame has converged.
    quadrature
        Quadrature points of a cell.
    precision
        Arithmetic of the solver.
    threads
        Number of threads; 0 for all.
    """

    spacing: float | None = None
    tolerance: float = 1e-3
    quadrature: Literal[1, 4, 8] = 1
    precision: Literal["float", "double"] = "float"
    threads: int = 0


@dataclass(frozen=True, eq=False)
class EpochShape:
    """The surface of an epoch, as far as it is shown.

    Parameters
    ----------
    key
        The same for the same surface, 64 hexadecimal digits.
    start_time
        Time code at which the epoch begins.
    rest
        Vertices at rest in mm, shape (n, 3), float32.
    triangles
        Vertex indices, shape (m, 3), int32.
    origin
        `FaceOrigin` of each triangle, shape (m,), uint8: 0 skin, 1 wound wall, 2 underside, 3 rim.
    grid
        Texture coordinates per corner in mm along the skin, shape (m, 3, 2), float32.
    depth
        Depth below the skin's edge at walls and rims in mm, shape (n,), float32.
    face
        Face of the tissue's mesh that each triangle lies on, -1 for wound walls, shape (m,), int32.
    """

    key: str
    start_time: float
    rest: NDArray[np.float32]
    triangles: NDArray[np.int32]
    origin: NDArray[np.uint8]
    grid: NDArray[np.float32]
    depth: NDArray[np.float32]
    face: NDArray[np.int32]


@dataclass(frozen=True)
class PlannedFrame:
    """A frame of a plan.

    Parameters
    ----------
    time
        Time code.
    epoch
        Index of its epoch in `Plan.epochs`.
    key
        Its key in the store.
    hooks
        Indices in `Plan.hooks` of those that pull, in the order of the frame's hook arrays.
    sutures
        Indices in `Plan.sutures` of those placed by now, in the order of the frame's suture arrays.
    """

    time: int
    epoch: int
    key: str
    hooks: tuple[int, ...] = ()
    sutures: tuple[int, ...] = ()


@dataclass(frozen=True, eq=False)
class Plan:
    """A compiled procedure without what only the solver needs: which frames there are and under which keys they lie.

    Parameters
    ----------
    key
        Key of the procedure and the settings (`plan_key`).
    epochs
        Surfaces of the epochs.
    frames
        The frames.
    hooks
        Names of the hooks.
    sutures
        Names of the sutures.
    landmarks
        A label per point.
    landmarks_at
        For each epoch the indices in `landmarks` of those that its tissue still holds.
    notes
        Sentences for the user.
    """

    key: str
    epochs: tuple[EpochShape, ...]
    frames: tuple[PlannedFrame, ...]
    hooks: tuple[str, ...] = ()
    sutures: tuple[str, ...] = ()
    landmarks: tuple[str, ...] = ()
    landmarks_at: tuple[tuple[int, ...], ...] = ()
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class ShownFrame:
    """What is shown of a solved frame: the arrays of the message `frame` (PROTOCOL.md) without the state.

    Parameters
    ----------
    points
        Vertices in mm, shape (n, 3), float32.
    header
        Fields of the message (`newton`, `residual`, `largest_gap`, `minimum_j`, `seconds`, …).
    arrays
        Arrays `strain`, `stress`, `tension` (n,), float32; `landmarks` (k, 3); `suture_points` (A, 2, 3), `suture_gaps`
        (A,), `suture_forces` (A,); `hook_points`, `hook_forces` (H, 3).
    """

    points: NDArray[np.float32]
    header: dict[str, Any] = field(default_factory=dict)
    arrays: dict[str, NDArray[Any]] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Planned:
    """The procedure of a job is compiled.

    Parameters
    ----------
    job
        Number of the job.
    plan
        The plan.
    known
        For each frame, whether the store holds it.
    """

    job: int
    plan: Plan
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
    frame: ShownFrame | None


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
    """A sentence for the user: the daemon died and was started again, the store cannot be written, ….

    Parameters
    ----------
    job
        Number of the job.
    sentence
        The sentence.
    """

    job: int
    sentence: str


@dataclass(frozen=True, eq=False)
class LiveFrame:
    """The skin in live mode for the hook's latest target.

    Parameters
    ----------
    job
        Number of the job.
    time
        Time code of the frame that is pulled at.
    target
        Target in mm.
    frame
        The frame.
    converged
        Whether the equilibrium was found.
    seconds
        Time that the solver took.
    """

    job: int
    time: int
    target: tuple[float, float, float]
    frame: ShownFrame
    converged: bool
    seconds: float


Happening = Planned | Refused | IterationDone | FrameReady | FrameFailed | Finished | Note | LiveFrame
