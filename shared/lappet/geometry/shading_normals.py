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

CREASE_DEGREES = 50.0
_BLOCK = 4096  # faces at once, so that what is computed of them stays in the cache


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
        self._triangles = np.asarray(surface.triangles, np.int64)
        labels = _smooth_groups(
            np.asarray(surface.points, np.float64), self._triangles, surface.origin, np.cos(np.radians(crease_degrees))
        )
        first = labels == np.arange(len(labels))  # each group is labeled by its first corner
        self.indices: NDArray[np.int32] = (np.cumsum(first) - 1)[labels].astype(np.int32)
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
        placed = np.asarray(points, np.float64)
        weighted = np.empty((3, *self._triangles.shape))
        for start in range(0, len(self._triangles), _BLOCK):
            block = slice(start, start + _BLOCK)
            weighted[:, block] = _weighted_normals(placed[self._triangles[block]])
        total = np.empty((3, self.groups))
        for axis in range(3):
            total[axis] = np.bincount(self.indices, weighted[axis].ravel(), minlength=self.groups)
        total[:, _length(total) == 0.0] = [[0.0], [0.0], [1.0]]
        return np.ascontiguousarray(_unit(total).T, np.float32)


def _weighted_normals(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """The normal of each face (m, 3, 3) times its angle at each corner: (coordinate, face, corner)."""
    # Axes: coordinate, corner, face. The long one is the last: numpy is slow along short ones.
    corners = np.ascontiguousarray(corners.transpose(2, 1, 0))
    edges = corners[:, [1, 2, 0]] - corners
    normals = _unit(_cross(edges[:, 0], edges[:, 1]))
    ahead = _unit(edges)
    product = ahead * ahead[:, [2, 0, 1]]  # with the direction of the edge before, which leads towards the corner
    angles = np.arccos(np.clip(-((product[0] + product[2]) + product[1]), -1.0, 1.0))
    return (angles * normals[:, None]).transpose(0, 2, 1)


def _smooth_groups(
    points: NDArray[np.float64], triangles: NDArray[np.int64], origin: NDArray[np.uint8], least_cosine: float
) -> NDArray[np.int64]:
    """A label per face corner (3 m,): equal at one vertex where smooth edges join the faces."""
    count = len(triangles)
    corner = np.arange(3 * count).reshape(count, 3)
    start = triangles.ravel()
    end = np.roll(triangles, -1, axis=1).ravel()
    face = np.repeat(np.arange(count), 3)
    vertices = int(start.max()) + 1 if count else 0
    forward, backward = start * vertices + end, end * vertices + start
    order = np.argsort(forward, kind="stable")
    found = order[np.minimum(np.searchsorted(forward[order], backward), len(order) - 1)] if count else order
    twin = forward[found] == backward
    a, b = np.flatnonzero(twin), found[twin]
    first = points[triangles]
    first = np.ascontiguousarray(first.transpose(1, 2, 0))
    normals = np.ascontiguousarray(_unit(_cross(first[1] - first[0], first[2] - first[0])).T)
    cosine = np.einsum("ij,ij->i", normals[face[a]], normals[face[b]])
    smooth = (origin[face[a]] == origin[face[b]]) & (cosine >= least_cosine)
    a, b = a[smooth], b[smooth]
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


def _cross(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """The cross products of vectors (3, …)."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def _length(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """The lengths (…) of vectors (3, …)."""
    square = vectors * vectors
    return np.asarray(np.sqrt((square[0] + square[1]) + square[2]))


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Vectors (3, …) of length 1, or 0."""
    length = _length(vectors)
    return np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0.0)
