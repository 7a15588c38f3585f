"""The skin of the whole body: how deep places lie below it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.surface_check import intersections
from lappet.geometry.triangles import area_normals
from lappet.tissue.rest_space import RestSpace

_ROUNDS = 40
_ON_SKIN = 1e-6  # mm
_HALF = 0.5  # of the way to the mean of its neighbors that a vertex goes in a round


def apart(points: NDArray[np.float64], triangles: NDArray[np.int64]) -> NDArray[np.float64]:
    """Smooth a closed surface where it passes through itself, as between toes, until it does not.

    Parameters
    ----------
    points
        Vertices in mm, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).

    Returns
    -------
    NDArray[np.float64]
        Vertices in mm, shape (n, 3), all others as they were; after some rounds as far as it came.
    """
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    count = np.bincount(edges[:, 0], minlength=len(points))
    points = points.copy()
    for _ in range(_ROUNDS):
        crossing = list(intersections(points.astype(np.float32).astype(np.float64), triangles))
        if not crossing:
            break
        moved = np.unique(triangles[np.unique(np.concatenate(crossing))])
        sums = np.zeros_like(points)
        np.add.at(sums, edges[:, 0], points[edges[:, 1]])
        means = sums[moved] / count[moved, None]
        points[moved] += _HALF * (means - points[moved])
    return points


@dataclass(frozen=True, eq=False)
class BodySkin:
    """The skin of the body, to find depths below it.

    Parameters
    ----------
    corners
        Corners of its triangles in mm, shape (m, 3, 3).
    search
        Finds the closest triangle.
    inside
        Tells what is inside.
    """

    corners: NDArray[np.float64]
    search: ClosestPoint
    inside: RestSpace

    @classmethod
    def of(cls, points: NDArray[np.float64], triangles: NDArray[np.int64]) -> BodySkin:
        """Take the skin from a mesh.

        Parameters
        ----------
        points
            Vertices in mm, shape (n, 3).
        triangles
            Vertex indices, shape (m, 3), normals out of the body.

        Returns
        -------
        BodySkin
            The skin.
        """
        return cls(points[triangles], ClosestPoint(points, triangles), RestSpace(points, triangles))

    def depth(self, points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Find how deep points lie below the skin.

        Parameters
        ----------
        points
            Points in mm, shape (n, 3).

        Returns
        -------
        tuple[NDArray[np.float64], NDArray[np.float64]]
            Their depths in mm, shape (n,), negative outside the body, and the unit directions into the body there,
            shape (n, 3).
        """
        faces, closest, distance = self.search.query(points)
        sign = np.where(self.inside.outside(points) > 0.0, -1.0, 1.0)
        inwards = -area_normals(self.corners[faces])  # of a point on the skin
        inwards /= np.linalg.norm(inwards, axis=1, keepdims=True)
        off = distance > _ON_SKIN
        inwards[off] = (sign[:, None] * (points - closest))[off] / distance[off, None]
        return sign * distance, inwards
