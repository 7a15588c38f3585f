"""What a background solve tells its owner: the plan of a procedure, its frames as they come, and how it ended."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Problem


@dataclass(frozen=True, eq=False)
class EpochShape:
    """The surface of an epoch, as far as it is shown.

    key: the same for the same surface, 64 hexadecimal digits. start_time: time code. rest: (n, 3) float32, mm.
    triangles: (m, 3) int32. origin: (m,) uint8, `FaceOrigin`: 0 skin, 1 wound wall, 2 underside, 3 rim. grid: (m, 3, 2)
    float32, texture coordinates per corner in mm along the skin. depth: (n,) float32, mm below the skin's edge at walls
    and rims. face: (m,) int32, the face of the tissue's mesh that each triangle lies on, -1 for wound walls.
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
    """A frame: time code, the index of its epoch in `Plan.epochs`, its key in the store.

    hooks: indices into `Plan.hooks` of those that pull, in the order of the frame's hook arrays. sutures: likewise, of
    those placed by now.
    """

    time: int
    epoch: int
    key: str
    hooks: tuple[int, ...] = ()
    sutures: tuple[int, ...] = ()


@dataclass(frozen=True, eq=False)
class Plan:
    """A compiled procedure without what only the solver needs: which frames there are and under which keys they lie.

    key: of the procedure and the settings (`plan_key`). hooks, sutures: names of events. landmarks: a label per point.
    landmarks_at: per epoch, the indices into `landmarks` of those that its tissue still holds. notes: sentences.
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

    points: (n, 3) float32, mm. header: the message's fields (newton, residual, largest_gap, minimum_j, seconds ...).
    arrays: strain, stress, tension (n,) float32; landmarks (k, 3); suture_points (A, 2, 3), suture_gaps (A,),
    suture_forces (A,); hook_points, hook_forces (H, 3).
    """

    points: NDArray[np.float32]
    header: dict[str, Any] = field(default_factory=dict)
    arrays: dict[str, NDArray[Any]] = field(default_factory=dict)


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
    """A frame is there. looked_up: it came from the store. frame: None where it was looked up (read it from there)."""

    job: int
    time: int
    key: str
    looked_up: bool
    frame: ShownFrame | None


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
    frame: ShownFrame
    converged: bool
    seconds: float


Happening = Planned | Refused | IterationDone | FrameReady | FrameFailed | Finished | Note | LiveFrame
