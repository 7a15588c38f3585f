"""Where the stitches of a run lie along its edges, and in which order they are made."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from lappet.procedure import SutureLayer, SutureRun
from lappet.procedure.suture_run import BESIDE
from lappet.suturing.lip_pair import DRIFT, LipPair, LipPlace, in_corner, on_edge
from lappet.tissue.skin_sheet import SkinSheet

# Stitches nearer to each other than this, in cells of the lattice, hold the same cells and contradict each other.
LEAST_CELLS = 1.2
CORNER_CELLS = 1.0  # that of a stitch from one in a corner; chosen
SHORT = 0.6  # of the distance between two stitches: a stretch with less room than this between its margins gets one


@dataclass(frozen=True)
class Site:
    """Where a stitch of a layer lies.

    Parameters
    ----------
    pair
        The places on the edges.
    level
        When it is made: those of level 0 first.
    """

    pair: LipPair
    level: int


@dataclass(frozen=True)
class _Stretch:
    """A part of both edges between two knots: corners or ends.

    points: of both edges. reached: how far along the mean of both edges it begins, mm. corners: whether a stitch lies
    in the knot at either end.
    """

    points: tuple[NDArray[np.float64], NDArray[np.float64]]
    reached: float
    corners: tuple[bool, bool]

    @property
    def length(self) -> float:
        return 0.5 * sum(_length(points) for points in self.points)


def taken_spacing(run: SutureRun, spacing: float) -> float:
    """Choose the distance between stitches that a lattice can carry.

    Parameters
    ----------
    run
        The run.
    spacing
        Edge of the lattice's cells in mm; 0 where it does not matter.

    Returns
    -------
    float
        Distance in mm, at least what the run asks for.
    """
    return max(run.spacing, LEAST_CELLS * spacing)


def sites(run: SutureRun, layer: SutureLayer, skin: SkinSheet, spacing: float) -> list[Site]:
    """Place the stitches of a layer of a run, from the start of the edges to their end.

    Parameters
    ----------
    run
        The run.
    layer
        The layer.
    skin
        The skin.
    spacing
        Edge of the lattice's cells in mm; 0 where it does not matter.

    Returns
    -------
    list[Site]
        Where they lie.
    """
    stretches = _stretches(run)
    found: list[tuple[LipPair, int | None]] = []
    knot = (0, 0)
    for stretch in stretches:
        if knot == (0, 0) and stretch.corners[0]:
            found.append((_corner(run, knot, stretch, layer, skin), 0))
        for at in _stations(run, stretch, layer, spacing):
            share = at / stretch.length
            lips = on_edge(stretch.points[0], share), on_edge(stretch.points[1], share)
            found.append((LipPair(lips, run.sides, skin, stretch.reached + at), None))
        knot = (knot[0] + len(stretch.points[0]) - 1, knot[1] + len(stretch.points[1]) - 1)
        if stretch.corners[1]:
            found.append((_corner(run, knot, stretch, layer, skin), 0))
    levels = _levels(run.order, [level is not None for _, level in found])
    return [Site(pair, level) for (pair, _), level in zip(found, levels, strict=True)]


def _corner(run: SutureRun, knot: tuple[int, int], stretch: _Stretch, layer: SutureLayer, skin: SkinSheet) -> LipPair:
    """The places of a stitch in a corner, at an end of a stretch."""
    edges = [np.array(edge, np.float64) for edge in run.edges]
    at_start, at_end = knot == (0, 0), knot == (len(edges[0]) - 1, len(edges[1]) - 1)
    reached = stretch.reached + (0.0 if at_start else stretch.length)
    if run.insides:
        inside = np.array(run.insides[run.corners.index(knot)])
        spots = [edge[number] for edge, number in zip(edges, knot, strict=True)]
        ways = [points[1] - points[0] if at_start else points[-1] - points[-2] for points in stretch.points]
        first, second = (LipPlace(spots[k], ways[k], inside[k] - spots[k]) for k in (0, 1))
    elif at_start or at_end:
        # A stitch in a corner at the end of the edges lies a little before it, beside the edge like the others.
        return _near_end(run, stretch, layer, skin, int(at_end))
    else:
        first, second = (in_corner(edges[k], knot[k], run.sides[k], skin) for k in (0, 1))
    return LipPair((first, second), run.sides, skin, reached)


def _near_end(run: SutureRun, stretch: _Stretch, layer: SutureLayer, skin: SkinSheet, end: int) -> LipPair:
    """The places of a stitch in a corner at an end of the edges: where a corner of 60° is halved."""
    from_end = 3.0**0.5 * beside(run, layer)
    shares = [min(from_end / max(_length(points), 1e-300), 0.5) for points in stretch.points]
    first, second = (
        on_edge(points, share if end == 0 else 1.0 - share)
        for points, share in zip(stretch.points, shares, strict=True)
    )
    return LipPair((first, second), run.sides, skin, stretch.reached + end * stretch.length)


def beside(run: SutureRun, layer: SutureLayer) -> float:
    """Compute how far beside the edges interrupted stitches of a layer hold.

    Parameters
    ----------
    run
        The run.
    layer
        The layer.

    Returns
    -------
    float
        Distance in mm.
    """
    return (BESIDE if run.bite is None else run.bite) + DRIFT * layer.depth


def _stretches(run: SutureRun) -> list[_Stretch]:
    edges = [np.array(edge, np.float64) for edge in run.edges]
    last = len(edges[0]) - 1, len(edges[1]) - 1
    knots = list(dict.fromkeys([(0, 0), *run.corners, last]))
    found, reached = [], 0.0
    for one, other in pairwise(knots):
        points = edges[0][one[0] : other[0] + 1], edges[1][one[1] : other[1] + 1]
        stretch = _Stretch(points, reached, (one in run.corners, other in run.corners))
        found.append(stretch)
        reached += stretch.length
    return found


def _stations(run: SutureRun, stretch: _Stretch, layer: SutureLayer, spacing: float) -> NDArray[np.float64]:
    """Where the stitches of a layer lie along a stretch between its knots, mm from its start, shape (k,)."""
    apart, length = taken_spacing(run, spacing), stretch.length
    if run.margin is None:
        ends = [1.0 if corner else 0.5 for corner in stretch.corners]
        gaps = int(length / apart - sum(ends) + 1e-6)
        if gaps < 0:
            return np.array([0.5 * length])
        gap = length / (gaps + sum(ends))
        at = gap * (ends[0] + np.arange(gaps + 1))
    else:
        first, last = (max(run.margin, CORNER_CELLS * spacing) if corner else run.margin for corner in stretch.corners)
        last = length - last
        if last - first < SHORT * apart:
            return np.array([0.5 * length])
        gaps = max(1, int((last - first) / apart + 1e-6))
        at = np.linspace(first, last, gaps + 1)
    if layer.between and len(at) > 1:
        return np.asarray(at[:-1] + 0.5 * np.diff(at))
    return at


def _levels(order: str, corner: Sequence[bool]) -> list[int]:
    """When each stitch is made."""
    if order == "together":
        return [0] * len(corner)
    if order == "forward":
        return list(range(len(corner)))
    levels = [0] * len(corner)
    fixed = [k for k, is_corner in enumerate(corner) if is_corner]
    for one, other in pairwise([-1, *fixed, len(corner)]):
        _halve(levels, one + 1, other, 1 if fixed else 0)
    return levels


def _halve(levels: list[int], first: int, end: int, level: int) -> None:
    """Give the stitch in the middle of a range its level, and the halves on either side the next ones."""
    if first < end:
        middle = (first + end - 1) // 2
        levels[middle] = level
        _halve(levels, first, middle, level + 1)
        _halve(levels, middle + 1, end, level + 1)


def _length(points: NDArray[np.float64]) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
