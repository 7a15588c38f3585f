"""Where rays meet a triangle surface that moves (numpy only).

Triangles are sorted once along the places of their centers into blocks; each set of positions gives the blocks' boxes,
and a ray is tried on the triangles of those blocks that it enters.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

_BLOCK = 48


class SurfaceBlocks:
    """The order of a surface's triangles (m, 3), m >= 1, found from the places (n, 3) of its vertices at rest."""

    def __init__(self, points: NDArray[np.float64], triangles: NDArray[np.int32]) -> None:
        centers = points[triangles].mean(axis=1)
        extent = float(np.ptp(centers, axis=0).max())
        cells = ((centers - centers.min(axis=0)) * (1023.0 / max(extent, 1e-30))).astype(np.int64)
        code = np.zeros(len(cells), np.int64)
        for bit in range(10):
            for axis in range(3):
                code |= ((cells[:, axis] >> bit) & 1) << (3 * bit + axis)
        self.order = np.argsort(code, kind="stable")
        self.sorted = triangles[self.order]
        self.starts = np.arange(0, len(triangles), _BLOCK)


class SurfaceRay:
    """Answer rays against one set of positions (n, 3) of a surface."""

    def __init__(self, blocks: SurfaceBlocks, positions: NDArray[np.float64]) -> None:
        self._blocks = blocks
        self._corners = positions[blocks.sorted]
        self._low = np.minimum.reduceat(self._corners.min(axis=1), blocks.starts, axis=0)
        self._high = np.maximum.reduceat(self._corners.max(axis=1), blocks.starts, axis=0)

    def first(
        self, origin: Sequence[float], direction: Sequence[float]
    ) -> tuple[int, NDArray[np.float64], float] | None:
        """The triangle that a ray meets first, the barycentric weights (3,) there and the distance; None for none.

        The distance is in lengths of the direction. Triangles are met from both sides (Möller and Trumbore 1997).
        """
        start, way = np.asarray(origin, np.float64), np.asarray(direction, np.float64)
        with np.errstate(divide="ignore", invalid="ignore"):
            slopes = 1.0 / np.where(np.abs(way) > 1e-300, way, 1e-300)
        slack = 1e-9 * float(np.abs(self._high - self._low).max())
        a, b = (self._low - slack - start) * slopes, (self._high + slack - start) * slopes
        enter, leave = np.minimum(a, b).max(axis=1), np.maximum(a, b).min(axis=1)
        entered = np.flatnonzero((enter <= leave) & (leave >= 0.0))
        if len(entered) == 0:
            return None
        rows = (self._blocks.starts[entered, None] + np.arange(_BLOCK)).ravel()
        rows = rows[rows < len(self._corners)]
        p = self._corners[rows]
        u, v = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
        across = np.cross(way, v)
        det = np.einsum("ij,ij->i", u, across)
        with np.errstate(divide="ignore", invalid="ignore"):
            away = start - p[:, 0]
            second = np.einsum("ij,ij->i", away, across) / det
            turned = np.cross(away, u)
            third = turned @ way / det
            distance = np.einsum("ij,ij->i", v, turned) / det
            tolerance = 1e-9  # a ray through an edge meets one of its two triangles
            hit = (second >= -tolerance) & (third >= -tolerance) & (second + third <= 1.0 + tolerance)
            hit &= (distance >= 0.0) & (det != 0.0)
        if not hit.any():
            return None
        k = int(np.where(hit, distance, np.inf).argmin())
        weights = np.clip([1.0 - second[k] - third[k], second[k], third[k]], 0.0, 1.0)
        return int(self._blocks.order[rows[k]]), weights / weights.sum(), float(distance[k])
