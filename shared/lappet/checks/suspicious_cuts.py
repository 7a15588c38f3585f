"""What is suspicious about incisions: too wide, off the tissue, made twice, or across themselves."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Place, Problem, RefusedError, problem
from lappet.core.problem_code import ProblemCode
from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.curve import sample_curve
from lappet.geometry.surface_check import place
from lappet.procedure import Incision
from lappet.procedure.prim_paths import TIMELINE
from lappet.tissue.rest_space import RestSpace

# Chosen: a blade of 0.4 mm opens a kerf below this, whatever the lattice.
NARROW = 0.5  # mm
# Chosen: a curve that is to part a border ends within twice the thickness, or a tenth of the diagonal, beyond it.
BEYOND_THICKNESS, BEYOND_DIAGONAL = 2.0, 0.1
TWICE = 0.5  # of its length beside another incision; closed ones that share a side have less
SAMPLES = 300  # of a curve, at most about


class CutCheck:
    """A check of the incisions of one tissue.

    Parameters
    ----------
    rest
        The tissue at rest.
    thickness
        Its mean thickness in mm.
    spacing
        Lattice spacing in mm.
    """

    def __init__(self, rest: RestSpace, thickness: float, spacing: float) -> None:
        self._rest, self._thickness, self._spacing = rest, thickness, spacing

    def check(self, incisions: list[Incision]) -> list[Problem]:
        """Find what is suspicious about incisions.

        Parameters
        ----------
        incisions
            The incisions, each free of errors.

        Returns
        -------
        list[Problem]
            The warnings.
        """
        found: list[Problem] = []
        earlier: list[tuple[Incision, NDArray[np.float64]]] = []
        for each in sorted(incisions, key=lambda incision: incision.time):
            curve = self._curve(each)
            if curve is None:
                continue
            path = f"{TIMELINE}/{each.name}"
            found += [*self._kerf(each, path), *self._beyond(curve, path)]
            found += [*self._crossing(curve, each.closed, path), *self._twice(each, curve, earlier, path)]
            earlier.append((each, curve))
        return found

    def _curve(self, incision: Incision) -> NDArray[np.float64] | None:
        """Samples of the curve (k, 3), its first one again at the end where it is closed."""
        control = np.asarray(incision.points, np.float64)
        length = float(np.linalg.norm(np.diff(control, axis=0), axis=1).sum())
        step = max(0.5 * self._spacing, length / SAMPLES)
        try:
            samples = sample_curve(control, incision.basis, incision.closed, step)
        except RefusedError:
            return None
        samples = np.concatenate([samples, samples[:1]]) if incision.closed else samples
        apart = np.linalg.norm(np.diff(samples, axis=0), axis=1) > 1e-9 * max(length, 1.0)
        return samples[np.concatenate([[True], apart])]

    def _kerf(self, incision: Incision, path: str) -> list[Problem]:
        cell, half = max(self._spacing, NARROW), 0.5 * self._thickness
        most = min(cell, half)
        if incision.kerf <= most:
            return []
        of = "half of the tissue's thickness" if half < cell else "a lattice spacing"
        where = Place.at(*incision.points)
        code, kerf = ProblemCode.KERF_WIDE, f"{incision.kerf:g}"
        return [problem(code, path, kerf, place=where, most=most, of=of, usual=Incision.kerf)]

    def _beyond(self, curve: NDArray[np.float64], path: str) -> list[Problem]:
        most = max(BEYOND_THICKNESS * self._thickness, BEYOND_DIAGONAL * self._rest.diagonal)
        far = curve[self._rest.distance(curve) > most]
        off = self._rest.off(far) if len(far) else np.zeros(0)
        if not (off > most).any():
            return []
        worst = far[int(off.argmax())]
        where = f"{place(np.round(worst, 3))} mm"
        at = Place.at(*far[off > most][[0, -1]], worst)
        return [problem(ProblemCode.INCISION_RUNS_OFF, path, f"{off.max():.3g}", place=at, where=where, most=most)]

    def _crossing(self, curve: NDArray[np.float64], closed: bool, path: str) -> list[Problem]:
        at = crossings(curve, closed, 0.5 * self._spacing)
        if not len(at):
            return []
        said = " and ".join(place(np.round(point, 3)) for point in at[:3])
        return [problem(ProblemCode.INCISION_CROSSES_ITSELF, path, f"{said} mm", place=Place.at(*at))]

    def _twice(
        self,
        incision: Incision,
        curve: NDArray[np.float64],
        earlier: list[tuple[Incision, NDArray[np.float64]]],
        path: str,
    ) -> list[Problem]:
        near = 0.5 * self._spacing
        for other, line in earlier:
            deeper = other.depth is not None and (incision.depth is None or incision.depth > other.depth)
            longer = _length(curve) > _length(line)
            points, along = (line, curve) if longer else (curve, line)
            beside = points[_distance(points, along) <= near]
            share = len(beside) / len(points)
            if not deeper and share > TWICE:
                where = Place.at(beside[0], beside[-1])
                code, percent = ProblemCode.INCISION_TWICE, f"{100.0 * share:.0f}"
                middle = f"{place(np.round(beside[len(beside) // 2], 3))} mm"
                return [problem(code, path, percent, place=where, where=middle, near=near, other=other.name)]
        return []


def crossings(curve: NDArray[np.float64], closed: bool, reach: float) -> NDArray[np.float64]:
    """Find where a curve on a surface crosses itself.

    Two of its chords cross where their common perpendicular meets both between their ends and is no longer than
    `reach`. The ends of an open curve may touch it.

    Parameters
    ----------
    curve
        Samples in mm, shape (k, 3); those of a closed curve end with the first one.
    closed
        Whether it is closed.
    reach
        Greatest length of the perpendicular in mm.

    Returns
    -------
    NDArray[np.float64]
        Points in mm, shape (c, 3).
    """
    starts, chords = curve[:-1], np.diff(curve, axis=0)
    first, second = np.triu_indices(len(chords), 2)
    if closed:
        apart = ~((first == 0) & (second == len(chords) - 1))
        first, second = first[apart], second[apart]
    u, v, between = chords[first], chords[second], starts[second] - starts[first]
    normal = np.cross(u, v)
    area = np.einsum("ij,ij->i", normal, normal)
    slanted = area > 1e-12 * np.einsum("ij,ij->i", u, u) * np.einsum("ij,ij->i", v, v)
    area = np.where(slanted, area, 1.0)
    s = np.einsum("ij,ij->i", np.cross(between, v), normal) / area
    t = np.einsum("ij,ij->i", np.cross(between, u), normal) / area
    height = np.abs(np.einsum("ij,ij->i", between, normal)) / np.sqrt(area)
    meets = slanted & (s >= 0.0) & (s < 1.0) & (t >= 0.0) & (t < 1.0) & (height <= reach)
    points = starts[first[meets]] + s[meets, None] * u[meets]
    if not closed:
        ends = np.minimum(*(np.linalg.norm(points - end, axis=1) for end in (curve[0], curve[-1])))
        points = points[ends > 1e-3 * _length(curve)]
    return points


def _length(curve: NDArray[np.float64]) -> float:
    return float(np.linalg.norm(np.diff(curve, axis=0), axis=1).sum())


def _distance(points: NDArray[np.float64], line: NDArray[np.float64]) -> NDArray[np.float64]:
    """How far points (k, 3) are from a line (n, 3), mm."""
    after = np.arange(1, len(line))
    return ClosestPoint(line, np.stack([after - 1, after, after], axis=1)).query(points)[2]
