"""The uncut skin at rest: where a drawn point lies on it, its normal there and the thickness below.

Events are placed against this surface, whatever has been cut before, so that a cut never depends on older kerfs.
"""

from __future__ import annotations

from dataclasses import dataclass

import manifold3d
import numpy as np
from numpy.typing import NDArray

from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.labelled_surface import FaceOrigin, Surface
from lappet.geometry.normals import corner_normals
from lappet.geometry.surface_check import open_edges


@dataclass(frozen=True, eq=False)
class SkinPoints:
    """Points placed on the skin.

    points, normals: (k, 3), mm and unit. height: (k,) mm, how far the drawn point hovered over the skin.
    beyond: (k,) mm, how far it lies outside the skin's border (0 on the skin).
    """

    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    height: NDArray[np.float64]
    beyond: NDArray[np.float64]


class RestSkin:
    """Answers where points lie on the skin of an uncut surface (its faces of origin SKIN)."""

    def __init__(self, surface: Surface, solid: manifold3d.Manifold) -> None:
        skin = np.flatnonzero(surface.origin == FaceOrigin.SKIN)
        if len(skin) == 0:
            skin = np.arange(len(surface.triangles))
        self.triangles = surface.triangles[skin].astype(np.int64)
        self.points = surface.points
        self._solid = solid
        self._closest = ClosestPoint(self.points, self.triangles)
        self._normals = corner_normals(self.points, self.triangles)
        self._size = float(np.linalg.norm(np.ptp(self.points, axis=0)))
        border = open_edges(self.triangles)
        degenerate = np.column_stack([border, border[:, 1]])
        self._border = ClosestPoint(self.points, degenerate) if len(border) else None

    def locate(self, points: NDArray[np.float64]) -> SkinPoints:
        """Places points (k, 3) on the skin; past its border they stay out there, in the border's tangent plane."""
        index, closest, _ = self._closest.query(points)
        weights = _barycentric(closest, self.points[self.triangles[index]])
        normals = np.einsum("kc,kci->ki", weights, self._normals[index])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        offset = points - closest
        height = np.einsum("ki,ki->k", offset, normals)
        beyond = np.linalg.norm(offset - height[:, None] * normals, axis=1)
        aside = np.flatnonzero(beyond > 1e-6 * self._size)
        outside = aside[self.to_border(closest[aside]) < 1e-6 * self._size]
        placed = closest.copy()
        placed[outside] = points[outside] - height[outside, None] * normals[outside]
        beyond[np.setdiff1d(np.arange(len(points)), outside)] = 0.0
        return SkinPoints(placed, normals, height, beyond)

    def to_border(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """The distance (k,) in mm of points (k, 3) to the skin's border; infinite for a skin without one."""
        return np.full(len(points), np.inf) if self._border is None else self._border.query(points)[2]

    def distance(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """The distance (k,) in mm of points (k, 3) to the skin."""
        return self._closest.query(points)[2]

    def thickness(self, points: NDArray[np.float64], normals: NDArray[np.float64]) -> NDArray[np.float64]:
        """How deep the tissue is below skin points (k, 3) along -normal, in mm; 0 where a ray meets none."""
        lift = 1e-6 * self._size
        depth = np.zeros(len(points))
        for k, (point, normal) in enumerate(zip(points, normals, strict=True)):
            hits = self._solid.ray_cast(tuple(point + lift * normal), tuple(point - self._size * normal))
            depths = [float(np.dot(point - np.array(hit.position), normal)) for hit in hits]
            leaving = [d for d, hit in zip(depths, hits, strict=True) if np.dot(hit.normal, normal) < 0.0]
            behind = [d for d in leaving if d > 4.0 * lift]
            depth[k] = behind[0] if behind else 0.0
        return depth


def _barycentric(points: NDArray[np.float64], corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Barycentric weights (k, 3) of points on triangles (k, 3, 3), clipped to the triangle."""
    a = corners[:, 0]
    u, v, w = corners[:, 1] - a, corners[:, 2] - a, points - a
    uu, uv, vv = (np.einsum("ij,ij->i", p, q) for p, q in ((u, u), (u, v), (v, v)))
    wu, wv = np.einsum("ij,ij->i", w, u), np.einsum("ij,ij->i", w, v)
    det = uu * vv - uv * uv
    safe = np.where(np.abs(det) > 1e-300, det, 1.0)
    b, c = (vv * wu - uv * wv) / safe, (uu * wv - uv * wu) / safe
    weights = np.clip(np.stack([1.0 - b - c, b, c], axis=1), 0.0, 1.0)
    return weights / np.maximum(weights.sum(axis=1, keepdims=True), 1e-300)
