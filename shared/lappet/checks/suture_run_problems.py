"""What is wrong with a suture run: its edges, its distances, its corners and its layers."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Place, Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.geometry.surface_check import place as text_of
from lappet.procedure import SutureMode, SutureOrder, SuturePattern, SutureRun
from lappet.suturing.stitches_of_run import run_stitches
from lappet.tissue.rest_space import RestSpace
from lappet.tissue.skin_sheet import SkinSheet

# Lengths of the edges of a run, the longer by the shorter, above which it is warned. Chosen: the most unequal edges of
# the flap library, those of a V–Y, a Y–V and a dorsal nasal flap, are 1.45 times each other, on a face 1.6 and 2.
UNEQUAL = 2.0
MOST_BITES = 256  # of one thread that the daemon takes
OFF_SKIN = 0.5  # lattice spacings from the skin to an edge, at most, as of anchors (chosen)
_NAMES = ("first", "second")
_SAME = 1e-3  # mm between lines that are one
_REACH, _TOUCH = 2.0, 0.2  # mm from a crossing at which lines that cross are apart, and by how much at least


class RunCheck:
    """A check of one suture run.

    Parameters
    ----------
    run
        The run.
    path
        Path of its prim.
    """

    def __init__(self, run: SutureRun, path: str) -> None:
        self.run, self._path = run, path
        self.problems: list[Problem] = []

    def check(self, rest: RestSpace | None, skin: SkinSheet | None, spacing: float) -> list[Problem]:
        """Find the problems of the run.

        Parameters
        ----------
        rest
            The tissue at rest, or None where its mesh cannot be read.
        skin
            Its skin, or None where it has none.
        spacing
            Lattice spacing in mm.

        Returns
        -------
        list[Problem]
            The problems.
        """
        self._words()
        self._numbers()
        self._layers()
        if self._edges():
            self._distances()
            self._corners()
            self._apart()
        if not self.problems and rest is not None and skin is not None and spacing > 0.0:
            self._on_skin(skin, spacing)
            if not self.problems:
                self._stitches(rest, skin, spacing)
        return self.problems

    def _add(self, code: ProblemCode, value: object, place: Place | None = None, **fields: Any) -> None:
        self.problems.append(problem(code, self._path, value, place=place, **fields))

    def _words(self) -> None:
        for name, kinds in (("pattern", SuturePattern), ("order", SutureOrder), ("mode", SutureMode)):
            value, known = getattr(self.run, name), get_args(kinds)
            if value not in known:
                self._add(ProblemCode.SUTURE_RUN_WORD, value, name=name, known=", ".join(known))
        for side, name in zip(self.run.sides, _NAMES, strict=True):
            if side not in (1, -1):
                self._add(ProblemCode.SUTURE_RUN_SIDE, side, name=name)

    def _numbers(self) -> None:
        for name in ("bite", "pass_depth", "drawn", "tension", "pull_through"):
            value: float | None = getattr(self.run, name)
            if value is not None and not (math.isfinite(value) and value >= 0.0):
                self._add(ProblemCode.SUTURE_RUN_NUMBER, f"{value:g}", name=name.replace("_", " "))

    def _layers(self) -> None:
        names = [layer.name for layer in self.run.layers]
        if not names or len(set(names)) < len(names) or not all(name.isidentifier() for name in names):
            self._add(ProblemCode.SUTURE_RUN_LAYERS, ", ".join(names) or "nothing")
        for layer in self.run.layers:
            if not (math.isfinite(layer.depth) and layer.depth >= 0.0):
                self._add(ProblemCode.SUTURE_RUN_NUMBER, f"{layer.depth:g}", name=f"depth of its layer {layer.name}")

    def _edges(self) -> bool:
        for edge, name in zip(self.run.edges, _NAMES, strict=True):
            if not np.isfinite(np.array(edge)).all():
                bad = next(point for point in edge if not np.isfinite(point).all())
                self._add(ProblemCode.EVENT_POINT_NOT_FINITE, text_of(np.array(bad)), name=f"point of the {name} edge")
                return False
        for edge, name in zip(self.run.edges, _NAMES, strict=True):
            distinct = len(set(edge))
            if distinct < 2 or any(a == b for a, b in pairwise(edge)):
                self._add(ProblemCode.SUTURE_RUN_EDGE, distinct, name=name)
                return False
        return True

    def _distances(self) -> None:
        first, second = self.run.lengths
        spacing, margin, mean = self.run.spacing, self.run.margin, 0.5 * (first + second)
        if not (math.isfinite(spacing) and 0.0 < spacing <= mean):
            self._add(ProblemCode.SUTURE_RUN_SPACING, f"{spacing:g}", first=first, second=second)
        if margin is not None and not (math.isfinite(margin) and 0.0 <= margin < 0.5 * mean):
            self._add(ProblemCode.SUTURE_RUN_MARGIN, f"{margin:g}", first=first, second=second)
        ratio = max(first, second) / min(first, second)
        if ratio > UNEQUAL:
            where = Place.at(self.run.edges[0][-1], self.run.edges[1][-1])
            code = ProblemCode.SUTURE_RUN_UNEQUAL
            self._add(code, f"{ratio:.3g}", where, first=first, second=second, most=UNEQUAL)

    def _corners(self) -> None:
        counts = [len(edge) for edge in self.run.edges]
        before = (-1, -1)
        for corner in self.run.corners:
            inside = all(0 <= number < count for number, count in zip(corner, counts, strict=True))
            ends = {(number == 0, number == count - 1) for number, count in zip(corner, counts, strict=True)}
            if not inside or len(ends) > 1 or not (corner[0] > before[0] and corner[1] > before[1]):
                self._add(ProblemCode.SUTURE_RUN_CORNER, corner, first=counts[0], second=counts[1])
                return
            before = corner
        if self.run.insides and (
            len(self.run.insides) != len(self.run.corners) or not np.isfinite(np.array(self.run.insides)).all()
        ):
            self._add(ProblemCode.SUTURE_RUN_INSIDES, len(self.run.insides), corners=len(self.run.corners))

    def _apart(self) -> None:
        first, second = (np.array(edge) for edge in self.run.edges)
        if len(first) == len(second):
            for other, side in ((second, self.run.sides[1]), (second[::-1], -self.run.sides[1])):
                same = np.abs(first - other).max() <= _SAME
                if same and (side == self.run.sides[0] or self.run.bite == 0.0):
                    name = "left" if side == 1 else "right"
                    self._add(ProblemCode.SUTURE_RUN_SAME_EDGE, name, Place.at(first[0], first[-1]))
                    return
                if same:
                    return
        crossing = edges_cross(first, second)
        if crossing is not None:
            self._add(ProblemCode.SUTURE_RUN_EDGES_CROSS, text_of(np.round(crossing, 2)), Place.at(crossing))

    def _on_skin(self, skin: SkinSheet, spacing: float) -> None:
        for edge, name in zip(self.run.edges, _NAMES, strict=True):
            off = skin.surface.query(np.array(edge))[2]
            worst = int(np.argmax(off))
            if off[worst] > OFF_SKIN * spacing:
                at = np.array(edge[worst])
                code, away = ProblemCode.SUTURE_RUN_OFF_SKIN, float(off[worst])
                self._add(code, text_of(np.round(at, 3)), Place.at(at), name=name, off=away)

    def _stitches(self, rest: RestSpace, skin: SkinSheet, spacing: float) -> None:
        made = run_stitches(self.run, skin, spacing)
        if made.merged is not None:
            self.problems.append(made.merged)
        for layer in self.run.layers:
            prefix = self.run.name if len(self.run.layers) == 1 else f"{self.run.name}/{layer.name}"
            own = [suture for suture in made.sutures if suture.name.rpartition("/")[0] == prefix]
            bites = max(len(suture.anchors) for suture in own)
            if bites > MOST_BITES:
                self._add(ProblemCode.SUTURE_BITES, bites, Place.at(*self.run.edges[0]), most=MOST_BITES)
            points = np.array([anchor for suture in own for anchor in suture.anchors])
            off = np.asarray(rest.outside(points))
            worst = int(np.argmax(off))
            if off[worst] > OFF_SKIN * spacing:
                code, depth = ProblemCode.SUTURE_RUN_DEPTH, f"{layer.depth or self.run.pass_depth:g}"
                self._add(code, depth, Place.at(points[worst]), name=layer.name, off=float(off[worst]))


def edges_cross(first: NDArray[np.float64], second: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Find where two lines on a surface cross each other; lines that only touch do not.

    Parameters
    ----------
    first
        Points of a line in mm, shape (n, 3).
    second
        Points of the other, shape (m, 3).

    Returns
    -------
    NDArray[np.float64] | None
        A place in mm at which they cross, shape (3,), or None.
    """
    starts, ways = first[:-1, None], np.diff(first, axis=0)[:, None]
    paths = np.diff(second, axis=0)[None]
    normal = np.cross(ways, paths)
    size = np.linalg.norm(normal, axis=2)
    lengths = np.linalg.norm(ways, axis=2), np.linalg.norm(paths, axis=2)
    apart = second[None, :-1] - starts
    with np.errstate(divide="ignore", invalid="ignore"):
        along = np.einsum("ijk,ijk->ij", np.cross(apart, paths), normal) / size**2
        reached = np.einsum("ijk,ijk->ij", np.cross(apart, ways), normal) / size**2
        gap = np.abs(np.einsum("ijk,ijk->ij", apart, normal)) / size
    inside = (along >= 0.0) & (along <= 1.0) & (reached >= 0.0) & (reached <= 1.0)
    near = gap < 0.1 * np.minimum(*lengths)
    for i, j in np.argwhere((size > 1e-6 * lengths[0] * lengths[1]) & inside & near):
        where = first[i] + along[i, j] * ways[i, 0]
        aside = np.cross(normal[i, j], paths[0, j])
        heights = [_height(end, second, where, aside) for end in _around(first, int(i), where)]
        others = np.cross(normal[i, j], ways[i, 0])
        reaches = [_height(end, first, where, others) for end in _around(second, int(j), where)]
        if heights[0] * heights[1] < 0.0 and reaches[0] * reaches[1] < 0.0:
            return np.asarray(where)
    return None


def _around(line: NDArray[np.float64], segment: int, where: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """The places of a line `_REACH` before and behind one in a segment of it, or its ends where these are nearer."""
    found = []
    for way in (line[: segment + 1][::-1], line[segment + 1 :]):
        path = np.vstack([where, way])
        reached = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
        at = min(_REACH, reached[-1])
        found.append(np.array([np.interp(at, reached, path[:, axis]) for axis in range(3)]))
    return found


def _height(
    point: NDArray[np.float64], line: NDArray[np.float64], where: NDArray[np.float64], aside: NDArray[np.float64]
) -> float:
    """How far aside of a line a point is in mm; 0 where it is on it, to `_TOUCH`."""
    starts, ways = line[:-1], np.diff(line, axis=0)
    shares = np.clip(np.einsum("ij,ij->i", point - starts, ways) / np.einsum("ij,ij->i", ways, ways), 0.0, 1.0)
    off = float(np.linalg.norm(starts + shares[:, None] * ways - point, axis=1).min())
    return off * float(np.sign((point - where) @ aside)) if off > _TOUCH else 0.0
