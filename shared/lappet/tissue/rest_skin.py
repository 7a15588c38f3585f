"""The uncut skin at rest: where a drawn point lies on it, its normal there and the thickness below.

Events are placed against this surface, whatever has been cut before, so that a cut never depends on older kerfs.
"""

from __future__ import annotations

from dataclasses import dataclass

import manifold3d
import numpy as np
from numpy.typing import NDArray

from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.labeled_surface import FaceOrigin, Surface
from lappet.geometry.normals import corner_normals
from lappet.geometry.surface_check import open_edges
from lappet.geometry.triangles import barycentric

_POCKET = 2.0  # times the thickness: how wide a gap inside a rolled rim is at most


@dataclass(frozen=True, eq=False)
class SkinPoints:
    """Points placed on the skin.

    Parameters
    ----------
    points
        Places in mm, shape (k, 3).
    normals
        Unit normals there, shape (k, 3).
    height
        How far each drawn point hovered over the skin in mm, shape (k,).
    beyond
        How far each lies outside the skin's border in mm, 0 on the skin, shape (k,).
    """

    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    height: NDArray[np.float64]
    beyond: NDArray[np.float64]


def _first_sheet(ray: list[tuple[float, bool]]) -> tuple[float, float]:
    """Where a ray enters the first tissue that it passes, and where it leaves that, in mm."""
    entering = 0.0
    for d, leaves in ray:
        if leaves and d > entering:
            return entering, d
        entering = max(d, 0.0)
    return 0.0, 0.0


class RestSkin:
    """The skin of an uncut surface, which tells where points lie on it.

    Parameters
    ----------
    surface
        The surface; its faces of origin `SKIN` are the skin.
    solid
        The same surface as a solid.
    """

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
        """Place points on the skin; past its border they stay out there, in the border's tangent plane.

        Parameters
        ----------
        points
            Points in mm, shape (k, 3).

        Returns
        -------
        SkinPoints
            The placed points.
        """
        index, closest, _ = self._closest.query(points)
        weights = barycentric(closest, self.points[self.triangles[index]])
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
        """Measure the distance to the skin's border.

        Parameters
        ----------
        points
            Points in mm, shape (k, 3).

        Returns
        -------
        NDArray[np.float64]
            Distances in mm, shape (k,); infinite for a skin without a border.
        """
        return np.full(len(points), np.inf) if self._border is None else self._border.query(points)[2]

    def distance(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Measure the distance to the skin.

        Parameters
        ----------
        points
            Points in mm, shape (k, 3).

        Returns
        -------
        NDArray[np.float64]
            Distances in mm, shape (k,).
        """
        return self._closest.query(points)[2]

    def thickness(self, points: NDArray[np.float64], normals: NDArray[np.float64]) -> NDArray[np.float64]:
        """Measure how deep the tissue is below points of the skin.

        Parameters
        ----------
        points
            Points on the skin in mm, shape (k, 3).
        normals
            Unit normals, shape (k, 3); rays go against them.

        Returns
        -------
        NDArray[np.float64]
            Depths in mm, shape (k,); 0 where a ray meets no tissue.
        """
        lift = 1e-6 * self._size
        depth = np.zeros(len(points))
        for k, (point, normal) in enumerate(zip(points, normals, strict=True)):
            behind = [d for d, leaves in self._crossings(point, normal, lift) if leaves and d > 4.0 * lift]
            depth[k] = behind[0] if behind else 0.0
        return depth

    def rolled_thickness(self, points: NDArray[np.float64], normals: NDArray[np.float64]) -> NDArray[np.float64]:
        """Measure how deep the tissue is below points where it may be rolled up or lie double, as a lip or an ear does.

        What follows behind a gap counts as well where the gap is no wider than `_POCKET` times the thickness at the
        place where that, up to the first gap, is greatest.

        Parameters
        ----------
        points
            Points on the skin, or in the air in front of it, in mm, shape (k, 3).
        normals
            Unit vectors, shape (k, 3); rays go against them.

        Returns
        -------
        NDArray[np.float64]
            Depths in mm, shape (k,); 0 where a ray meets no tissue.
        """
        lift = 1e-6 * self._size
        rays = [self._crossings(point, normal, lift) for point, normal in zip(points, normals, strict=True)]
        sheets = [leaving - entering for entering, leaving in map(_first_sheet, rays)]
        pocket = _POCKET * max(sheets, default=0.0)
        depth = np.zeros(len(points))
        for k, ray in enumerate(rays):
            for d, leaves in ray:
                if leaves and d > 4.0 * lift:
                    depth[k] = d
                elif not leaves and depth[k] > 0.0 and d - depth[k] > pocket:
                    break
        return depth

    def _crossings(
        self, point: NDArray[np.float64], normal: NDArray[np.float64], lift: float
    ) -> list[tuple[float, bool]]:
        """How deep in mm a ray against a normal crosses the surface, and whether it leaves the tissue there."""
        hits = self._solid.ray_cast(tuple(point + lift * normal), tuple(point - self._size * normal))
        depths = [float(np.dot(point - np.array(hit.position), normal)) for hit in hits]
        return [(d, bool(np.dot(hit.normal, normal) < 0.0)) for d, hit in zip(depths, hits, strict=True)]
