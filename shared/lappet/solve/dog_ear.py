"""Dog-ears: how far the skin at the end of a seam stands above the surface around it.

That surface is the quadric z = a + b x + c y + d x² + e x y + f y², fitted by least squares to the skin in a ring
around the end, each point weighted by its area, without what lies beside a wound's edge.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.labeled_surface import FaceOrigin, Surface
from lappet.geometry.triangles import area_normals, areas, directions
from lappet.geometry.wound_edges import WoundEdges

REACH = 10.0
"""Chosen: how far from the seam's end a dog-ear is looked for in mm; the ring is what lies up to twice as far."""

BESIDE = 5.0
"""Chosen: what is nearer to a wound's edge than this in mm is left out of the ring."""

GONE = 3.0 * REACH
"""Chosen: what is farther from the seam's end than this in mm has been carried away with a flap; it is left out."""

_MIN_FACING = 0.7  # of the ring's area must be seen along its mean normal
_SECTORS, _MIN_SECTORS = 8, 6  # around the end; in so many of them there must be skin


@dataclass(frozen=True, eq=False)
class DogEar:
    """The skin around the end of a seam.

    Parameters
    ----------
    end
        Vertex of the skin at the end.
    inner
        Vertices of the skin near the end, shape (k,).
    ring
        Vertices of the ring, shape (r,).
    weights
        Area of skin that each of these stands for in mm², shape (r,).
    triangles
        Triangles of the skin with a corner in the ring, shape (t, 3).
    at_rest
        Heights of the inner vertices above the quadric of the surface at rest in mm, shape (k,).
    """

    end: int
    inner: NDArray[np.int64]
    ring: NDArray[np.int64]
    weights: NDArray[np.float64]
    triangles: NDArray[np.int64]
    at_rest: NDArray[np.float64]

    def height(self, points: NDArray[np.floating]) -> float | None:
        """Measure the dog-ear.

        Parameters
        ----------
        points
            Points of the surface in mm, shape (n, 3).

        Returns
        -------
        float | None
            How much farther a point of the skin rises above the fitted surface than at rest, in mm; at least 0. None
            where too little skin is left around the end because flaps were carried away from it.
        """
        near = np.linalg.norm(points - points[self.end], axis=1) <= GONE
        inner, ring = near[self.inner], near[self.ring]
        if np.count_nonzero(ring) < _SECTORS:
            return None
        triangles = self.triangles[near[self.triangles].all(axis=1)]
        now = heights_above_quadric(points, self.inner[inner], self.ring[ring], self.weights[ring], triangles)
        return max(0.0, float((now - self.at_rest[inner]).max()))


def dog_ear_at(surface: Surface, edges: WoundEdges, end: NDArray[np.float64]) -> DogEar | None:
    """Find the skin around the end of a seam.

    Parameters
    ----------
    surface
        Surface of the epoch at rest.
    edges
        The edges of its wounds.
    end
        The seam's end at rest in mm, shape (3,).

    Returns
    -------
    DogEar | None
        The skin, or None where the rim of the tissue is nearer than `REACH`, less than three quarters of the way around
        are left of the ring, or its skin does not face one way.
    """
    skin = surface.triangles[surface.origin == FaceOrigin.SKIN].astype(np.int64)
    area = np.zeros(len(surface.points))
    np.add.at(area, skin.ravel(), np.repeat(areas(surface.points[skin]) / 3.0, 3))
    far = np.linalg.norm(surface.points - end, axis=1)
    inner = np.flatnonzero((area > 0.0) & (far <= REACH))
    ring = np.flatnonzero((area > 0.0) & (far > REACH) & (far <= 2.0 * REACH) & (edges.distance > BESIDE))
    rim = np.unique(surface.triangles[surface.origin == FaceOrigin.RIM])
    if len(inner) == 0 or len(ring) < _SECTORS or (far[rim] <= REACH).any():
        return None
    triangles = skin[np.isin(skin, ring).any(axis=1)]
    normals = area_normals(surface.points[triangles])
    if np.linalg.norm(normals.sum(axis=0)) < _MIN_FACING * np.linalg.norm(normals, axis=1).sum():
        return None
    around, across, _ = _axes(surface.points, triangles)
    offsets = surface.points[ring] - end
    sectors = np.floor(np.arctan2(offsets @ across, offsets @ around) / (2.0 * np.pi) * _SECTORS).astype(int)
    if len(np.unique(sectors % _SECTORS)) < _MIN_SECTORS:
        return None
    at_rest = heights_above_quadric(surface.points, inner, ring, area[ring], triangles)
    return DogEar(int(inner[np.argmin(far[inner])]), inner, ring, area[ring], triangles, at_rest)


def heights_above_quadric(
    points: NDArray[np.floating],
    inner: NDArray[np.int64],
    ring: NDArray[np.int64],
    weights: NDArray[np.float64],
    triangles: NDArray[np.int64],
) -> NDArray[np.float64]:
    """Measure how far vertices stand above the quadric through others.

    Parameters
    ----------
    points
        Points of the surface in mm, shape (n, 3).
    inner
        Vertices to measure, shape (k,).
    ring
        Vertices to fit to, shape (r,).
    weights
        Their weights, shape (r,).
    triangles
        Triangles of the skin around, whose mean normal is the direction of the height, shape (t, 3).

    Returns
    -------
    NDArray[np.float64]
        Heights in mm, shape (k,).
    """
    points = np.asarray(points, np.float64)
    axes = np.stack(_axes(points, triangles), axis=1)
    center = np.average(points[ring], axis=0, weights=weights)
    size = float(np.linalg.norm(points[ring] - center, axis=1).max())
    fitted, measured = (((points[index] - center) / size) @ axes for index in (ring, inner))
    root = np.sqrt(weights / weights.sum())
    found, *_ = np.linalg.lstsq(_terms(fitted) * root[:, None], fitted[:, 2] * root, rcond=None)
    return np.asarray(size * (measured[:, 2] - _terms(measured) @ found))


def _terms(local: NDArray[np.float64]) -> NDArray[np.float64]:
    x, y = local[:, 0], local[:, 1]
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1)


def _axes(
    points: NDArray[np.floating], triangles: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Two directions along the skin and its mean normal."""
    up = directions(area_normals(np.asarray(points[triangles], np.float64)).sum(axis=0)[None])[0]
    along = np.cross(up, np.eye(3)[int(np.argmin(np.abs(up)))])
    along /= np.linalg.norm(along)
    return along, np.cross(up, along), up
