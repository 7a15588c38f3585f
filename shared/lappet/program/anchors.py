"""Find the triangles of an epoch's surface on which the anchors of events (rest points) lie."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.labeled_surface import FaceOrigin, Surface
from lappet.procedure import Incision, Procedure
from lappet.tissue.fan_triangles import fan_triangles

# How far an anchor may be from the uncut tissue, as a fraction of the tissue's diagonal.
OFF_TISSUE = 0.05


@dataclass(frozen=True)
class PlacedAnchors:
    """Anchors on a surface.

    Parameters
    ----------
    point
        Points of the surface in mm, shape (q, 3), float64.
    triangle
        Triangle of each point, shape (q,), int32.
    distance
        Distance of each from what was asked for in mm, shape (q,).
    """

    point: NDArray[np.float64]
    triangle: NDArray[np.int32]
    distance: NDArray[np.float64]

    def __getitem__(self, rows: slice | NDArray[np.int64]) -> PlacedAnchors:
        """Some of the anchors."""
        return PlacedAnchors(self.point[rows], self.triangle[rows], self.distance[rows])


class AnchorSearch:
    """A search for the triangle under each anchor of one epoch's surface.

    A face of the skin, the underside or the rim is preferred to a wound wall unless the wall is nearer by more than a
    margin: what is drawn at a wound's edge belongs to the skin.

    Parameters
    ----------
    surface
        Surface of the epoch.
    margin
        The margin in mm.
    """

    def __init__(self, surface: Surface, margin: float) -> None:
        self._margin = margin
        self._parts = _searches(surface)

    def locate(self, points: ArrayLike) -> PlacedAnchors:
        """Tie rest points to the surface.

        Parameters
        ----------
        points
            Points in mm, shape (q, 3).

        Returns
        -------
        PlacedAnchors
            The anchors.
        """
        found = []
        for faces, closest in self._parts:
            index, point, distance = closest.query(points)
            found.append((faces[index], point, distance))
        triangle, point, distance = found[0]
        if len(found) == 2:
            on_wall, wall_point, wall_distance = found[1]
            nearer = wall_distance + self._margin < distance
            triangle = np.where(nearer, on_wall, triangle)
            point = np.where(nearer[:, None], wall_point, point)
            distance = np.where(nearer, wall_distance, distance)
        return PlacedAnchors(point, triangle.astype(np.int32), distance)


@lru_cache(maxsize=16)
def _searches(surface: Surface) -> list[tuple[NDArray[np.int64], ClosestPoint]]:
    """The faces that are no wound walls, and the walls, each with a search.

    They are kept, by the surface itself: a procedure that is compiled after each edit has the epochs it had.
    """
    wall = surface.origin == FaceOrigin.WOUND_WALL
    return [
        (faces, ClosestPoint(surface.points, surface.triangles[faces]))
        for faces in (np.flatnonzero(~wall), np.flatnonzero(wall))
        if len(faces)
    ]


class TissueLoss:
    """A test of whether the tissue under an anchor has been cut away.

    An anchor may be farther from an epoch's surface than from the uncut tissue by the widest kerf (it may lie in it)
    and by rounding; beyond that the tissue under it is gone.

    Parameters
    ----------
    procedure
        The procedure.
    """

    def __init__(self, procedure: Procedure) -> None:
        tissue = procedure.tissue
        triangles, _ = fan_triangles(tissue)
        self._tissue = ClosestPoint(tissue.points, triangles)
        self.diagonal = float(np.linalg.norm(np.ptp(tissue.points, axis=0)))
        kerf = max((event.kerf for event in procedure.events if isinstance(event, Incision)), default=0.0)
        self.margin = kerf + 1e-4 * self.diagonal

    def distance(self, points: ArrayLike) -> NDArray[np.float64]:
        """Measure how far points are from the uncut tissue.

        Parameters
        ----------
        points
            Points in mm, shape (q, 3).

        Returns
        -------
        NDArray[np.float64]
            Distances in mm, shape (q,).
        """
        return self._tissue.query(points)[2]

    def is_off(self, distance: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Find distances that are too large for the anchor to be meant.

        Parameters
        ----------
        distance
            From the uncut tissue in mm, shape (q,).

        Returns
        -------
        NDArray[np.bool_]
            Which are too large, shape (q,).
        """
        return ~(distance <= OFF_TISSUE * self.diagonal)

    def is_lost(self, points: ArrayLike, placed: PlacedAnchors) -> NDArray[np.bool_]:
        """Find anchors that have lost their tissue.

        Parameters
        ----------
        points
            Points in mm, shape (q, 3).
        placed
            How they were placed to an epoch.

        Returns
        -------
        NDArray[np.bool_]
            Which have lost it, shape (q,).
        """
        return placed.distance > self.distance(points) + self.margin
