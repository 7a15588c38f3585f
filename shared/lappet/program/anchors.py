"""Place the anchors of events (rest points) in an epoch's tissue: inside where they are, else on its surface."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.inside import InsideTest
from lappet.geometry.labeled_surface import FaceOrigin, Surface
from lappet.procedure import Incision, Procedure
from lappet.tissue.fan_triangles import fan_triangles
from lappet.tissue.rest_space import ROUNDING, RestSpace

# How far outside the tissue an anchor may be, and how far beyond the kerf a wound's wall may move it without a word, in
# lattice spacings of the tissue (chosen).
OFF_TISSUE, UNSAID = 0.5, 0.1


@dataclass(frozen=True)
class PlacedAnchors:
    """Anchors in the tissue of an epoch.

    Parameters
    ----------
    point
        Where they are in mm, shape (q, 3), float64: where they were put if that is inside the tissue, else on its
        surface.
    triangle
        The triangle of the surface nearest to each, shape (q,), int32.
    distance
        How far each was moved in mm, shape (q,).
    """

    point: NDArray[np.float64]
    triangle: NDArray[np.int32]
    distance: NDArray[np.float64]

    def __getitem__(self, rows: slice | NDArray[np.int64]) -> PlacedAnchors:
        """Some of the anchors."""
        return PlacedAnchors(self.point[rows], self.triangle[rows], self.distance[rows])


class AnchorSearch:
    """A search for the place of each anchor in one epoch's tissue.

    A point inside the tissue stays where it is. For others a face of the skin, the underside or the rim is preferred to
    a wound wall unless the wall is nearer by more than a margin: what is drawn at a wound's edge belongs to the skin.

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
        self._inside = InsideTest(surface.points, surface.triangles)
        self._rounding = ROUNDING * float(np.linalg.norm(np.ptp(surface.points, axis=0)))

    def locate(self, points: ArrayLike) -> PlacedAnchors:
        """Place rest points in the tissue.

        Parameters
        ----------
        points
            Points in mm, shape (q, 3).

        Returns
        -------
        PlacedAnchors
            The anchors.
        """
        queries = np.asarray(points, np.float64).reshape(-1, 3)
        found = []
        for faces, closest in self._parts:
            index, point, distance = closest.query(queries)
            found.append((faces[index], point, distance))
        chosen = nearest = found[0]
        if len(found) == 2:
            chosen, nearest = _nearer(found[0], found[1], self._margin), _nearer(found[0], found[1], 0.0)
        deep = np.flatnonzero(nearest[2] > self._rounding)
        deep = deep[self._inside.contains(queries[deep], nearest[0][deep], nearest[1][deep])]
        triangle, point, distance = chosen[0].copy(), chosen[1].copy(), chosen[2].copy()
        triangle[deep], point[deep], distance[deep] = nearest[0][deep], queries[deep], 0.0
        return PlacedAnchors(point, triangle.astype(np.int32), distance)


_Found = tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]


def _nearer(first: _Found, second: _Found, margin: float) -> _Found:
    """The first triangles, points and distances, the second where they are nearer by more than a margin."""
    nearer = second[2] + margin < first[2]
    return (
        np.where(nearer, second[0], first[0]),
        np.where(nearer[:, None], second[1], first[1]),
        np.where(nearer, second[2], first[2]),
    )


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

    An anchor may lie in a kerf, or a little beyond the wall of a wound: it is moved onto that, like one that is put a
    little outside the uncut tissue. Beyond half a lattice spacing the tissue under it is gone.

    Parameters
    ----------
    procedure
        The procedure.
    """

    def __init__(self, procedure: Procedure) -> None:
        tissue = procedure.tissue
        triangles, _ = fan_triangles(tissue)
        self._tissue = RestSpace(tissue.points, triangles)
        kerf = max((event.kerf for event in procedure.events if isinstance(event, Incision)), default=0.0)
        self.margin = kerf + 1e-4 * self._tissue.diagonal
        self.allowed = OFF_TISSUE * tissue.spacing
        self.unsaid = self.margin + UNSAID * tissue.spacing

    def distance(self, points: ArrayLike) -> NDArray[np.float64]:
        """Measure how far points are outside the uncut tissue.

        Parameters
        ----------
        points
            Points in mm, shape (q, 3).

        Returns
        -------
        NDArray[np.float64]
            Distances in mm, shape (q,); 0 inside and on the surface.
        """
        return self._tissue.outside(points)

    def is_off(self, distance: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Find distances that are too large for the anchor to be meant.

        Parameters
        ----------
        distance
            How far outside the uncut tissue in mm, shape (q,).

        Returns
        -------
        NDArray[np.bool_]
            Which are too large, shape (q,).
        """
        return ~(distance <= self.allowed)

    def is_lost(self, off: NDArray[np.float64], placed: PlacedAnchors) -> NDArray[np.bool_]:
        """Find anchors that have lost their tissue.

        Parameters
        ----------
        off
            How far outside the uncut tissue they are in mm, shape (q,).
        placed
            How they were placed in an epoch.

        Returns
        -------
        NDArray[np.bool_]
            Which have lost it, shape (q,).
        """
        return placed.distance > off + max(self.margin, self.allowed)

    def is_moved(self, off: NDArray[np.float64], placed: PlacedAnchors) -> NDArray[np.bool_]:
        """Find anchors that a cut moves so far that it is worth a word.

        Parameters
        ----------
        off
            How far outside the uncut tissue they are in mm, shape (q,).
        placed
            How they were placed in an epoch.

        Returns
        -------
        NDArray[np.bool_]
            Which are moved onto a wound's wall or edge, shape (q,).
        """
        return placed.distance > off + self.unsaid
