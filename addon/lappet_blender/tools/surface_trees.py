"""The nearest place of a triangle surface, by Blender's trees over parts of it.

One tree of a large surface keeps Blender's main thread for a second, whichever thread makes it; trees of a few thousand
triangles let it go on in between.
"""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np
from mathutils.bvhtree import BVHTree
from numpy.typing import NDArray

_PART = 16_000  # triangles
_BREATH = 0.002  # seconds


class SurfaceTrees:
    """The trees of triangles (m, 3), m >= 1, with points (n, 3). order: (m,), in which neighbors follow one another."""

    def __init__(
        self, points: NDArray[np.float64], triangles: NDArray[np.int32], order: NDArray[np.int64] | None = None
    ) -> None:
        every = np.arange(len(triangles)) if order is None else order
        self._parts: list[tuple[BVHTree, list[int]]] = []
        for part in np.array_split(every, -(-len(every) // _PART)):
            used, corners = np.unique(triangles[part], return_inverse=True)
            faces = corners.reshape(-1, 3).tolist()
            self._parts.append((BVHTree.FromPolygons(points[used].tolist(), faces, all_triangles=True), part.tolist()))
            if order is not None:
                time.sleep(_BREATH)  # whoever waits for the interpreter has it now

    def nearest(self, points: Sequence[Sequence[float]]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """The triangle (k,) and the place (k, 3) nearest to each point; triangle 0 and the origin for none."""
        triangle, place = np.zeros(len(points), np.int64), np.zeros((len(points), 3))
        for row, point in enumerate(points):
            least = np.inf
            for tree, part in self._parts:
                found, _, index, away = tree.find_nearest(point, min(least, _FAR))
                if found is not None and away < least:
                    least, triangle[row], place[row] = away, part[index], found
        return triangle, place


_FAR = 1e30
