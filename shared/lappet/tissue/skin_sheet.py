"""The outer surface of a tissue: where a design lies on it, beside its edges and below it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.triangulation import triangulate
from lappet.procedure import Point, Tissue

_DECIMALS = 4  # of what is placed, mm: every machine writes the same file


@dataclass(frozen=True, eq=False)
class SkinSheet:
    """The faces of a tissue that are neither fixed nor on the bed.

    surface: their triangles. normals: (m, 3) of those, outwards, unit length.
    """

    surface: ClosestPoint
    normals: NDArray[np.float64]

    @classmethod
    def of(cls, tissue: Tissue) -> SkinSheet:
        """The skin of a tissue with the subsets "fixed" and "bed"."""
        outer = np.ones(len(tissue.face_vertex_counts), bool)
        for name in ("fixed", "bed"):
            outer[tissue.subsets[name]] = False
        counts, indices = tissue.face_vertex_counts.astype(np.int64), tissue.face_vertex_indices.astype(np.int64)
        triangles, _, faces = triangulate(tissue.points, counts, indices)
        triangles = triangles[outer[faces]]
        a, b, c = (tissue.points[triangles[:, k]] for k in range(3))
        normals = np.cross(b - a, c - a)
        return cls(ClosestPoint(tissue.points, triangles), normals / np.linalg.norm(normals, axis=1, keepdims=True))

    def at(self, points: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The closest points (k, 3) of the skin and its normals (k, 3) there."""
        faces, closest, _ = self.surface.query(np.asarray(points, np.float64).reshape(-1, 3))
        return closest, self.normals[faces]

    def place(self, points: ArrayLike) -> NDArray[np.float64]:
        """The closest points (k, 3) of the skin: a `project` for designs."""
        return self.at(points)[0]

    def below(self, on_skin: ArrayLike, depth: float) -> Point:
        """The point so deep (mm, against the normal) below the skin's closest point, rounded."""
        points, normals = self.at(on_skin)
        x, y, z = np.round(points[0] - depth * normals[0], _DECIMALS) + 0.0
        return (float(x), float(y), float(z))

    def beside(self, on_skin: ArrayLike, along: ArrayLike, distance: float, depth: float = 0.0) -> Point:
        """The point so far (mm) to the left of a line on the skin with the direction `along`, and so deep below."""
        points, normals = self.at(on_skin)
        across = np.cross(normals[0], np.asarray(along, np.float64))
        return self.below(points[0] + distance * across / max(float(np.linalg.norm(across)), 1e-300), depth)

    def towards(self, on_skin: ArrayLike, there: ArrayLike, distance: float, depth: float = 0.0) -> Point:
        """The point so far (mm) from one point of the skin towards another, and so deep below."""
        start = np.asarray(on_skin, np.float64)
        way = np.asarray(there, np.float64) - start
        return self.below(start + distance * way / max(float(np.linalg.norm(way)), 1e-300), depth)
