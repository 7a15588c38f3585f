"""A closed triangle surface with labels: what its faces are, which of them are held, gripped or attached."""

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

    @property
    def resting(self) -> NDArray[np.bool_]:
        """Underside faces that are not attached: they lie on the bed, may lift off and slide, but do not sink."""
        return (self.origin == FaceOrigin.UNDERSIDE) & ~self.bed & ~self.fixed
