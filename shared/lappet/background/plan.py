"""The plan of a procedure: which frames it has, what their surfaces look like and under which keys they lie."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


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
