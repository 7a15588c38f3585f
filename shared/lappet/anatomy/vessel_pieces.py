"""What the cuts leave of vessels: the pieces of each that lie in an epoch's tissue, with where they were divided."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Place, refused
from lappet.core.problem_code import ProblemCode
from lappet.cutting.epoch import no_entries
from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.curve import sample_curve
from lappet.geometry.inside import InsideTest
from lappet.geometry.labeled_surface import FaceOrigin, Surface
from lappet.geometry.surface_check import place
from lappet.procedure import Vessel
from lappet.procedure.prim_paths import ANATOMY
from lappet.tissue.rest_space import ROUNDING, RestSpace

MOST_SAMPLES = 1000  # of one vessel
# In lattice spacings: shorter pieces between two cuts are left out; how far the triangles of whole skin may lie from
# where they were before a cut.
_SHORTEST, _REDRAWN = 0.05, 0.05


@dataclass(frozen=True, eq=False)
class VesselPieces:
    """The pieces of all vessels in the tissue of an epoch, one after another.

    Parameters
    ----------
    vessel
        Number of the vessel of each piece in `Procedure.vessels`, shape (p,), int32.
    counts
        Number of points of each piece, at least 2, shape (p,), int32; q are they in all.
    divided
        1 where the begin or the end of each piece was cut, else 0, shape (p, 2), uint8.
    points
        The pieces at rest in mm, shape (q, 3), float64.
    triangles
        Triangle of the epoch's surface nearest to each point, shape (q,), int32.
    """

    vessel: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))
    counts: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))
    divided: NDArray[np.uint8] = field(default_factory=lambda: no_entries((0, 2), np.uint8))
    points: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    triangles: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))

    def split(self, points: NDArray[np.float64]) -> list[NDArray[np.float64]]:
        """Divide points among the pieces.

        Parameters
        ----------
        points
            A place for each point of the pieces in mm, shape (q, 3).

        Returns
        -------
        list[NDArray[np.float64]]
            The places of each piece, each of shape (counts, 3).
        """
        return np.split(points, np.cumsum(self.counts)[:-1]) if len(self.counts) else []


class Course(NamedTuple):
    """A vessel at rest, moved onto the tissue where it runs a little outside.

    Parameters
    ----------
    points
        Its samples in mm, shape (n, 3).
    outside
        How far the middle between each sample and the next lies outside the uncut tissue in mm, shape (n - 1,).
    """

    points: NDArray[np.float64]
    outside: NDArray[np.float64]


class _Cuts(NamedTuple):
    """Where the steps of a course pierce a surface.

    step: the step (k,). share: how far along it (k,), 0 to 1. triangle: which triangle (k,).
    """

    step: NDArray[np.int64]
    share: NDArray[np.float64]
    triangle: NDArray[np.int64]


def vessel_course(vessel: Vessel, tissue: RestSpace, uncut: ClosestPoint, spacing: float, most: float) -> Course:
    """Sample a vessel, at steps of the lattice spacing or longer ones.

    Parameters
    ----------
    vessel
        The vessel.
    tissue
        The uncut tissue.
    uncut
        A search of its surface.
    spacing
        Lattice spacing in mm.
    most
        How far outside the tissue it may run in mm; it is moved onto its surface.

    Returns
    -------
    Course
        Its course.

    Raises
    ------
    RefusedError
        If its points make no curve, or it runs farther outside.
    """
    path = f"{ANATOMY}/{vessel.name}"
    step = max(spacing, 1e-9 * tissue.diagonal, tissue.diagonal / MOST_SAMPLES)
    points = sample_curve(vessel.points, vessel.basis, False, step, path)
    outside = tissue.outside(points)
    worst = int(np.argmax(outside))
    if not outside[worst] <= most:
        at, off_tissue = points[worst], ProblemCode.PROGRAM_POINT_OFF_TISSUE
        shown = f"{place(np.round(at, 3))} mm"
        raise refused(off_tissue, path, shown, place=Place.at(at), off=float(outside[worst]), most=most)
    off = np.flatnonzero(outside > 0.0)
    if len(off):
        points[off] = uncut.query(points[off])[1]
    return Course(points, tissue.outside(0.5 * (points[1:] + points[:-1])))


class VesselCutter:
    """A search for the pieces of vessels in one epoch's tissue.

    Parameters
    ----------
    surface
        Surface of the epoch.
    spacing
        Lattice spacing in mm.
    """

    def __init__(self, surface: Surface, spacing: float) -> None:
        self._shortest = _SHORTEST * spacing
        self._closest = ClosestPoint(surface.points, surface.triangles)
        self._inside = InsideTest(surface.points, surface.triangles)
        self._rounding = ROUNDING * float(np.linalg.norm(np.ptp(surface.points, axis=0)))
        wall = surface.origin == FaceOrigin.WOUND_WALL
        self._walls = np.flatnonzero(wall)
        self._slack = np.where(wall, self._rounding, max(self._rounding, _REDRAWN * spacing))
        self._corners = surface.points[surface.triangles[self._walls]]

    def pieces(self, courses: Sequence[Course]) -> VesselPieces:
        """Find what the epoch's tissue holds of vessels.

        Parameters
        ----------
        courses
            The course of each vessel.

        Returns
        -------
        VesselPieces
            The pieces, in the order of the vessels and along each.
        """
        found = [(number, piece) for number, course in enumerate(courses) for piece in self._of_course(course)]
        if not found:
            return VesselPieces()
        points = np.concatenate([points for _, (points, _, _) in found])
        given = np.concatenate([triangles for _, (_, triangles, _) in found])
        nearest = self._closest.query(points)[0]
        return VesselPieces(
            vessel=np.array([number for number, _ in found], np.int32),
            counts=np.array([len(points) for _, (points, _, _) in found], np.int32),
            divided=np.array([divided for _, (_, _, divided) in found], np.uint8),
            points=points,
            triangles=np.where(given >= 0, given, nearest).astype(np.int32),
        )

    def _of_course(self, course: Course) -> list[tuple[NDArray[np.float64], NDArray[np.int64], tuple[bool, bool]]]:
        """Points, triangles (-1 where not known) and divided ends of each piece of a course."""
        cuts = self._cuts(course.points)
        steps = np.arange(len(course.points) - 1)
        # The parts of the course: from sample to sample, divided where it is cut.
        begin = np.concatenate([steps + 0.0, cuts.step + cuts.share])
        wall = np.concatenate([np.full(len(steps), -1), self._walls[cuts.triangle]])
        order = np.argsort(begin, kind="stable")
        begin, wall = np.append(begin[order], float(len(steps))), np.append(wall[order], -1)
        places = self._at(course.points, begin)
        step = np.minimum(begin[:-1].astype(np.int64), len(steps) - 1)
        held = self._is_held(0.5 * (places[1:] + places[:-1]), course.outside[step])
        held |= np.diff(begin) <= 1e-12  # a cut at a sample: what comes next decides
        pieces = []
        edges = np.flatnonzero(np.diff(np.concatenate([[False], held, [False]]).astype(np.int8)))
        for first, last in edges.reshape(-1, 2):
            rows = np.arange(first, last + 1)
            rows = rows[np.append(np.linalg.norm(np.diff(places[rows], axis=0), axis=1) > self._rounding, True)]
            if len(rows) < 2 or np.linalg.norm(np.diff(places[rows], axis=0), axis=1).sum() < self._shortest:
                continue
            triangle = np.full(len(rows), -1)
            triangle[0], triangle[-1] = wall[first], wall[last]
            pieces.append((places[rows], triangle, (bool(wall[first] >= 0), bool(wall[last] >= 0))))
        return pieces

    @staticmethod
    def _at(points: NDArray[np.float64], along: NDArray[np.float64]) -> NDArray[np.float64]:
        """Places (k, 3) at so many steps along samples (n, 3)."""
        step = np.minimum(along.astype(np.int64), len(points) - 2)
        share = (along - step)[:, None]
        return np.asarray((1.0 - share) * points[step] + share * points[step + 1])

    def _is_held(self, middles: NDArray[np.float64], before: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Whether places lie in the tissue, or no farther outside than before any cut."""
        triangle, closest, distance = self._closest.query(middles)
        away = np.flatnonzero(distance > before + self._slack[triangle])
        held = np.ones(len(middles), np.bool_)
        held[away] = self._inside.contains(middles[away], triangle[away], closest[away])
        return held

    def _cuts(self, points: NDArray[np.float64]) -> _Cuts:
        """Where a course pierces wound walls (Möller and Trumbore 1997)."""
        low, high = points.min(axis=0) - self._rounding, points.max(axis=0) + self._rounding
        near = ((self._corners.max(axis=1) >= low) & (self._corners.min(axis=1) <= high)).all(axis=1)
        rows = np.flatnonzero(near)
        corners = self._corners[rows]
        below, above = corners.min(axis=1), corners.max(axis=1)
        found = []
        for step, (a, b) in enumerate(pairwise(points)):
            meets = ((above >= np.minimum(a, b)) & (below <= np.maximum(a, b))).all(axis=1)
            hit = np.flatnonzero(meets)
            if not len(hit):
                continue
            origin = corners[hit, 0]
            first, second, ahead = corners[hit, 1] - origin, corners[hit, 2] - origin, a - origin
            normal, turned = np.cross(b - a, second), np.cross(ahead, first)
            size = np.einsum("ij,ij->i", first, normal)
            with np.errstate(divide="ignore", invalid="ignore"):
                u = np.einsum("ij,ij->i", ahead, normal) / size
                v, share = turned @ (b - a) / size, np.einsum("ij,ij->i", second, turned) / size
            inside = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (share >= 0.0) & (share <= 1.0)
            found += [(step, float(share[k]), int(rows[hit[k]])) for k in np.flatnonzero(inside)]
        table = np.array(found, np.float64).reshape(-1, 3)
        return _Cuts(table[:, 0].astype(np.int64), table[:, 1], table[:, 2].astype(np.int64))
