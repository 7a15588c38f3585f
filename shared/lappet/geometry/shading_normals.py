"""Normals for shading a deforming surface: smooth over the skin, sharp at wound edges and rims.

The corners of faces at a vertex fall into groups across whose edges the surface is smooth: both faces have the same
origin, and at rest they meet at less than the crease angle. Every group has one normal per frame: the mean of its
faces' normals weighted by the angle of the face at the vertex (Thürmer and Wüthrich, Computing vertex normals from
polygonal facets, 1998).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.geometry.labeled_surface import Surface
from lappet.geometry.vectors import cross, dot, length, triangle_corners, unit

CREASE_DEGREES = 50.0
_BLOCK = 16384  # faces at once, so that what is computed of them stays in the cache


class ShadingNormals:
    """The smooth groups of one surface.

    `groups` is their number, `indices` the group of every face corner, shape (3m,), int32.

    Parameters
    ----------
    surface
        The surface at rest.
    crease_degrees
        Angle in degrees between faces from which the edge stays sharp.
    """

    def __init__(self, surface: Surface, crease_degrees: float = CREASE_DEGREES) -> None:
        triangles = np.asarray(surface.triangles, np.int64)
        self._corners = np.ascontiguousarray(triangles.T)
        labels = _smooth_groups(
            np.asarray(surface.points, np.float64), triangles, surface.origin, np.cos(np.radians(crease_degrees))
        )
        first = labels == np.arange(len(labels))  # each group is labeled by its first corner
        self.indices: NDArray[np.int32] = (np.cumsum(first) - 1)[labels].astype(np.int32)
        self._group = self.indices.astype(np.intp)
        self.groups = int(self.indices.max()) + 1 if len(self.indices) else 0

    def at(self, points: ArrayLike) -> NDArray[np.float32]:
        """Compute the normals of the deformed surface.

        Parameters
        ----------
        points
            Deformed vertices, shape (n, 3).

        Returns
        -------
        NDArray[np.float32]
            Unit normals of the smooth groups, shape (groups, 3); a group of vanished faces gets (0, 0, 1).
        """
        placed = np.ascontiguousarray(np.transpose(points), np.float64)
        weighted = np.empty((3, len(self._group) // 3, 3), np.float32)
        for start in range(0, weighted.shape[1], _BLOCK):
            block = slice(start, start + _BLOCK)
            a, b, c = (np.take(placed, corner, axis=1) for corner in self._corners[:, block])
            # Differences of places are taken in double precision; what has the digits of an edge needs no more.
            edges = [np.asarray(edge, np.float32) for edge in (b - a, c - b, a - c)]
            ahead = [unit(edge) for edge in edges]
            normals = unit(cross(ahead[0], ahead[1]))
            # Towards each corner the edge before leads; the angles of a triangle add up to pi.
            angles = [np.arccos(np.clip(-dot(ahead[k], ahead[k - 1]), -1.0, 1.0)) for k in range(2)]
            angles.append(np.float32(np.pi) - angles[0] - angles[1])
            for corner in range(3):
                weighted[:, block, corner] = angles[corner] * normals
        total = np.empty((3, self.groups))
        for axis in range(3):
            total[axis] = np.bincount(self._group, weighted[axis].ravel(), minlength=self.groups)
        total[:, length(total) == 0.0] = [[0.0], [0.0], [1.0]]
        return np.ascontiguousarray(unit(total).T, np.float32)


def _smooth_groups(
    points: NDArray[np.float64], triangles: NDArray[np.int64], origin: NDArray[np.uint8], least_cosine: float
) -> NDArray[np.int64]:
    """A label per face corner (3 m,): equal at one vertex where smooth edges join the faces."""
    count = len(triangles)
    corner = np.arange(3 * count).reshape(count, 3)
    start, end = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    vertices = int(start.max(initial=0)) + 1
    key = 2 * (np.minimum(start, end) * vertices + np.maximum(start, end)) + (start > end)  # even ahead, odd back
    order = np.argsort(key, kind="stable")  # a third of the time: neighbors lie near each other
    twins = np.flatnonzero((np.diff(key[order]) == 1) & (start[order[:-1]] < end[order[:-1]]))
    a, b = order[twins], order[twins + 1]
    corners = triangle_corners(points, triangles)
    normals = unit(cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    cosine = dot(normals[:, a // 3], normals[:, b // 3])
    smooth = (origin[a // 3] == origin[b // 3]) & (cosine >= least_cosine)
    a, b = np.concatenate([a[smooth], b[smooth]]), np.concatenate([b[smooth], a[smooth]])
    # Half-edge a runs from its own corner to the next one of its face; its twin runs the other way.
    following = np.roll(corner, -1, axis=1).ravel()
    # The corners next to each one around its vertex, on either side; itself where the surface is not smooth there.
    one, other = corner.ravel().copy(), corner.ravel().copy()
    one[a], other[following[a]] = following[b], b
    labels = corner.ravel()
    while True:
        fresh = np.minimum(labels, np.minimum(labels[one], labels[other]))
        fresh = fresh[fresh]
        if np.array_equal(fresh, labels):
            return labels
        labels = fresh
