"""Which side of a closed surface points lie on, from the closest triangle and point of each."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

_ON_EDGE = 1e-7  # barycentric coordinates below this count as zero


class InsideTest:
    """A test of whether points lie inside a closed surface, by the sign of its angle-weighted pseudonormals.

    The normal of what is closest, a face, an edge or a corner, tells the side (Bærentzen and Aanæs 2005, "Signed
    distance computation using the angle weighted pseudonormal").

    Parameters
    ----------
    points
        Vertices in any length unit, shape (n, 3).
    triangles
        Vertex indices, outward-oriented, shape (m, 3).
    """

    def __init__(self, points: NDArray[np.float64], triangles: NDArray[np.integer]) -> None:
        self._points, self._triangles = np.asarray(points, np.float64), np.asarray(triangles, np.int64)

    @cached_property
    def _at_vertices(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """The triangles at every vertex, one vertex after the other, and where those of each begin."""
        corners = self._triangles.reshape(-1)
        order = np.argsort(corners, kind="stable")
        return order // 3, np.searchsorted(corners[order], np.arange(len(self._points) + 1))

    def contains(
        self, queries: ArrayLike, triangle: NDArray[np.integer], closest: NDArray[np.float64]
    ) -> NDArray[np.bool_]:
        """Tell which points lie inside.

        Parameters
        ----------
        queries
            Points, shape (q, 3).
        triangle
            The triangle closest to each, shape (q,).
        closest
            The closest point of it, shape (q, 3).

        Returns
        -------
        NDArray[np.bool_]
            Whether each lies inside, shape (q,).
        """
        away = np.asarray(queries, np.float64).reshape(-1, 3) - closest
        area, zero = self._areas(triangle), np.zeros((len(closest), 3), np.bool_)
        corners = self._points[self._triangles[triangle]]
        squared = np.maximum(np.einsum("ij,ij->i", area, area), 1e-300)
        for k in range(3):
            part = np.cross(corners[:, (k + 1) % 3] - closest, corners[:, (k + 2) % 3] - closest)
            zero[:, k] = np.einsum("ij,ij->i", part, area) < _ON_EDGE * squared
        normal = area
        for row in np.flatnonzero(zero.any(axis=1)):
            kept = self._triangles[triangle[row]][~zero[row]]
            if len(kept):
                normal[row] = self._normal_around(kept)
        return np.asarray(np.einsum("ij,ij->i", away, normal) < 0.0)

    def _areas(self, triangle: NDArray[np.integer]) -> NDArray[np.float64]:
        corners = self._points[self._triangles[triangle]]
        return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])

    def _normal_around(self, kept: NDArray[np.int64]) -> NDArray[np.float64]:
        """The pseudonormal of an edge (two vertices) or a corner (one), of any length."""
        triangles, start = self._at_vertices
        around, *others = (triangles[start[each] : start[each + 1]] for each in kept)
        for other in others:
            around = np.intersect1d(around, other)
        faces = self._areas(around)
        faces /= np.maximum(np.linalg.norm(faces, axis=1, keepdims=True), 1e-300)
        if len(kept) == 2:
            return np.asarray(faces.sum(axis=0))
        own = np.argmax(self._triangles[around] == kept[0], axis=1)
        corners, row = self._points[self._triangles[around]], np.arange(len(around))
        onwards = corners[row, (own + 1) % 3] - corners[row, own]
        back = corners[row, (own + 2) % 3] - corners[row, own]
        angle = np.arctan2(np.linalg.norm(np.cross(onwards, back), axis=1), np.einsum("ij,ij->i", onwards, back))
        return np.asarray(angle @ faces)
