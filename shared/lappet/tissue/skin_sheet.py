"""The outer surface of a tissue: where a design lies on it, beside its edges and below it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.triangulation import triangulate
from lappet.procedure import Point, Tissue
from lappet.tissue.surface import skin_faces

_DECIMALS = 4  # of what is placed, mm: every machine writes the same file


@dataclass(frozen=True, eq=False)
class SkinSheet:
    """The faces of a tissue that are outer skin.

    Parameters
    ----------
    surface
        Their triangles.
    normals
        Unit normals of those triangles, outwards, shape (m, 3).
    points
        Vertices in mm, shape (n, 3).
    triangles
        Their indices, shape (m, 3).
    """

    surface: ClosestPoint
    normals: NDArray[np.float64]
    points: NDArray[np.float64]
    triangles: NDArray[np.int64]

    @classmethod
    def of(cls, tissue: Tissue) -> SkinSheet:
        """Take the skin of a tissue.

        Parameters
        ----------
        tissue
            A tissue with the subsets "fixed" and "bed", or "rim" and "underside".

        Returns
        -------
        SkinSheet
            The skin.
        """
        outer = skin_faces(tissue)
        counts, indices = tissue.face_vertex_counts.astype(np.int64), tissue.face_vertex_indices.astype(np.int64)
        triangles, _, faces = triangulate(tissue.points, counts, indices)
        triangles = triangles[outer[faces]]
        a, b, c = (tissue.points[triangles[:, k]] for k in range(3))
        normals = np.cross(b - a, c - a)
        unit = normals / np.linalg.norm(normals, axis=1, keepdims=True)
        return cls(ClosestPoint(tissue.points, triangles), unit, tissue.points, triangles)

    def at(self, points: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Find the closest points of the skin.

        Parameters
        ----------
        points
            Points in mm, shape (k, 3).

        Returns
        -------
        tuple[NDArray[np.float64], NDArray[np.float64]]
            Closest points in mm and unit normals there, each of shape (k, 3).
        """
        faces, closest, _ = self.surface.query(np.asarray(points, np.float64).reshape(-1, 3))
        return closest, self.normals[faces]

    def place(self, points: ArrayLike) -> NDArray[np.float64]:
        """Find the closest points of the skin: a `project` for designs.

        Parameters
        ----------
        points
            Points in mm, shape (k, 3).

        Returns
        -------
        NDArray[np.float64]
            Closest points in mm, shape (k, 3).
        """
        return self.at(points)[0]

    def below(self, on_skin: ArrayLike, depth: float) -> Point:
        """Find the point below the skin's closest point.

        Parameters
        ----------
        on_skin
            A point in mm, shape (3,).
        depth
            Depth against the skin's normal in mm.

        Returns
        -------
        Point
            The point in mm, rounded.
        """
        points, normals = self.at(on_skin)
        x, y, z = np.round(points[0] - depth * normals[0], _DECIMALS) + 0.0
        return (float(x), float(y), float(z))

    def beside(self, on_skin: ArrayLike, along: ArrayLike, distance: float, depth: float = 0.0) -> Point:
        """Find the point to the left of a line on the skin.

        Parameters
        ----------
        on_skin
            A point of the line in mm, shape (3,).
        along
            Direction of the line, shape (3,).
        distance
            Distance from the line in mm.
        depth
            Depth below the skin in mm.

        Returns
        -------
        Point
            The point in mm, rounded.
        """
        points, normals = self.at(on_skin)
        across = np.cross(normals[0], np.asarray(along, np.float64))
        return self.below(points[0] + distance * across / max(float(np.linalg.norm(across)), 1e-300), depth)

    def towards(self, on_skin: ArrayLike, there: ArrayLike, distance: float, depth: float = 0.0) -> Point:
        """Find the point on the way from one point of the skin to another.

        Parameters
        ----------
        on_skin
            A point in mm, shape (3,).
        there
            The other point in mm, shape (3,).
        distance
            Distance from the first point in mm.
        depth
            Depth below the skin in mm.

        Returns
        -------
        Point
            The point in mm, rounded.
        """
        start = np.asarray(on_skin, np.float64)
        way = np.asarray(there, np.float64) - start
        return self.below(start + distance * way / max(float(np.linalg.norm(way)), 1e-300), depth)
