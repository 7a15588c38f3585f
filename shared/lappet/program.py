"""The program: what the daemon is told. Epochs of constant topology and, per frame, the constraints."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray


class FaceOrigin(IntEnum):
    """Where a surface triangle comes from."""

    SKIN = 0
    WOUND_WALL = 1
    UNDERSIDE = 2
    RIM = 3


@dataclass(frozen=True, eq=False)
class Surface:
    """A closed, manifold triangle surface at rest, with labels.

    points: (n, 3) float64, mm. triangles: (m, 3) int32, outward orientation. uv: (m, 3, 2) float32.
    origin: (m,) uint8 of `FaceOrigin`. fixed, bed: (m,) bool. grips: (m,) bool by subset name.
    """

    points: NDArray[np.float64]
    triangles: NDArray[np.int32]
    uv: NDArray[np.float32]
    origin: NDArray[np.uint8]
    fixed: NDArray[np.bool_]
    bed: NDArray[np.bool_]
    grips: dict[str, NDArray[np.bool_]] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Epoch:
    """A stretch of the timeline with constant topology and attachments, from `start_time` on."""

    index: int
    start_time: float
    surface: Surface
    fragments: int
