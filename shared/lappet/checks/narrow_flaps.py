"""Flaps whose base is narrow for their length: skin that hangs on a neck gets its blood through that neck alone.

The cuts are drawn in the plane of their own, on a grid. For a width b the skin whose nearest cut is farther than b / 2,
where it is joined to the skin far from all cuts, is what a disk of that width reaches from outside; what lies beyond
hangs on necks narrower than b, and its length is how far it reaches from there along the skin. The ratio of a flap is
the greatest of length to b: of a strip its length to its width, of a tip of the angle α 1 / (2 sin(α / 2)). Pieces that
are cut free all around (islands) live on what lies below them and are left out, as is skin that stays on its bed, and
skin with a vessel of its own: one that runs from near the base into the outer half without being cut.

A flap must live from when it is raised: the cuts are looked at as they are before each later one, as the division of a
pedicle, which makes an island of a flap that hung on it until then.
"""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.core.problem import Place, Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.curve import sample_curve
from lappet.geometry.surface_check import place
from lappet.procedure import Event, Excision, Incision, Point, Procedure, Undermine
from lappet.procedure.prim_paths import TIMELINE

# Length to width of a flap without a vessel of its own. On the face 3:1 to 4:1 is the rule, on trunk and limbs 1:1 to
# 1.5:1 (S. R. Baker, Local Flaps in Facial Reconstruction; a U-flap of 3:1 is exceptional already).
MOST_RATIO = 3.0
_FINEST, _ACROSS = 0.4, 120.0  # mm: edge of a cell; cells across the cuts, at most
_STEP, _STRIDE = 1.06, 6  # from width to width; widths that are looked at together
_WIDEST = 0.36  # of the span of the cuts: no flap on a wider base is longer than the span
_NEAR_BASE = 0.25  # of a flap's length: a vessel that feeds it comes so near to its base
_TOGETHER = 25.0  # mm: cuts nearer to each other are looked at together


@dataclass(frozen=True)
class NarrowFlap:
    """A flap and its base.

    Parameters
    ----------
    tip
        Its farthest point in mm.
    base
        The middle of where it is narrowest in mm.
    length
        How far it reaches from there in mm.
    width
        How wide it is there in mm.
    """

    tip: Point
    base: Point
    length: float
    width: float

    @property
    def ratio(self) -> float:
        """Its length in widths."""
        return self.length / self.width


def narrow_flaps(procedure: Procedure, wrong: set[str]) -> list[Problem]:
    """Find flaps whose base is narrow for their length.

    Parameters
    ----------
    procedure
        The procedure.
    wrong
        Paths of the prims with errors, which are left out.

    Returns
    -------
    list[Problem]
        A warning for each group of cuts with such a flap.
    """
    events = [event for event in procedure.events if f"{TIMELINE}/{event.name}" not in wrong]
    cuts = [event for event in events if isinstance(event, Incision) and len(event.points) > 1]
    alive = [vessel.points for vessel in procedure.vessels]
    found = []
    for group in _groups(cuts):
        flap = _narrowest_in_time(group, events, alive)
        if flap is None:
            continue
        nearest = min(group, key=lambda cut: float(np.linalg.norm(np.subtract(cut.points, flap.tip), axis=1).min()))
        found.append(
            problem(
                ProblemCode.FLAP_NARROW_BASE,
                f"{TIMELINE}/{nearest.name}",
                f"{flap.ratio:.2g}",
                place=Place.at(flap.tip, flap.base),
                where=f"{place(np.round(flap.tip, 1))} mm",
                length=flap.length,
                width=flap.width,
                most=MOST_RATIO,
            )
        )
    return found


def _narrowest_in_time(cuts: list[Incision], events: list[Event], alive: list[tuple[Point, ...]]) -> NarrowFlap | None:
    """The flap with the narrowest base of all that are there before one of the cuts, or after the last."""
    found = []
    for end in (*sorted({cut.time for cut in cuts})[1:], math.inf):
        before = [event for event in events if isinstance(event, Excision | Undermine) and event.time < end]
        made = [cut for cut in cuts if cut.time < end]
        seeds = [seed for event in before if isinstance(event, Excision) for seed in event.seeds]
        flap = narrowest_flap(made, seeds, [event.points for event in before if isinstance(event, Undermine)], alive)
        found += [] if flap is None else [flap]
    return max(found, key=lambda flap: flap.ratio, default=None)


def narrowest_flap(
    cuts: list[Incision],
    seeds: list[Point],
    freed: list[tuple[Point, ...]],
    alive: list[tuple[Point, ...]],
    above: float = MOST_RATIO,
) -> NarrowFlap | None:
    """Find the flap with the narrowest base for its length that cuts leave.

    Parameters
    ----------
    cuts
        Incisions beside each other.
    seeds
        Points in mm in what is excised.
    freed
        Outlines of what is undermined, points in mm.
    alive
        Courses of vessels, points in mm.
    above
        Least ratio of length to width that is looked for.

    Returns
    -------
    NarrowFlap | None
        The flap; None where the cuts leave none above that ratio.
    """
    if not freed:
        return None
    lines = [_sampled(cut) for cut in cuts]
    plane = _Plane.through(np.vstack(lines))
    if plane is None:
        return None
    grid = _Grid.around([plane.flat(line) for line in lines])
    for cut, line in zip(cuts, lines, strict=True):
        if cut.closed and seeds and _within(plane.flat(line), plane.flat(seeds)).any():
            grid.skin[grid.within(plane.flat(line))] = False
    ways = _Ways.of(grid)
    neck = _necks(grid, ways)
    lifted = np.zeros_like(grid.skin)
    for outline in freed:
        lifted |= grid.within(plane.flat(outline))
    fed = [piece for course in alive for piece in grid.uncut(plane.flat(course))]
    best: NarrowFlap | None = None
    least = 4.0 * grid.cell
    widths = least * _STEP ** np.arange(int(np.log(max(_WIDEST * grid.span / least, 1.0)) / np.log(_STEP)) + 2)
    # What hangs on a neck of one width hangs on a wider one too and reaches farther from it: a bound for those between.
    for first in range(0, len(widths) - 1, _STRIDE):
        between = widths[first : first + _STRIDE + 1]
        if _longest(grid, ways, neck, between[-1], lifted, fed, above).length <= above * between[0]:
            continue
        for width in between:
            flap = _longest(grid, ways, neck, width, lifted, fed, above)
            if flap.length > (above if best is None else best.ratio) * width:
                best = NarrowFlap(plane.space(flap.tip), plane.space(flap.base), flap.length, float(width))
    return best


@dataclass(frozen=True, eq=False)
class _Reach:
    """How far skin reaches from where it is of a width: its tip and where it begins in the plane in mm, shape (2,)."""

    tip: NDArray[np.float64]
    base: NDArray[np.float64]
    length: float


def _longest(
    grid: _Grid,
    ways: _Ways,
    neck: NDArray[np.float64],
    width: float,
    lifted: NDArray[np.bool_],
    fed: list[set[int]],
    above: float,
) -> _Reach:
    """The flap that reaches farthest from where a disk of this width comes from outside."""
    reach, begins = _reaches(ways, neck, 0.5 * width)
    hangs = lifted.ravel()
    free = sorted(((length, cell) for cell, length in reach.items() if hangs[cell]), reverse=True)
    seen: set[int] = set()
    for length, tip in free:
        if length <= above * width or tip in seen:
            break
        half = _outer_half(ways, reach, tip)
        near = _NEAR_BASE * length
        if not any(piece & half and min(reach.get(cell, 0.0) for cell in piece) <= near for piece in fed):
            return _Reach(grid.place(tip), grid.place(begins[tip]), length)
        seen |= half
    return _Reach(grid.low, grid.low, 0.0)


def _necks(grid: _Grid, ways: _Ways) -> NDArray[np.float64]:
    """Half the width in mm of the narrowest place on the widest way to each cell from outside; 0 without a way."""
    away: list[float] = grid.away().ravel().tolist()
    neck = [0.0] * len(away)
    heap = [(-away[0], 0)]
    neck[0] = away[0]
    while heap:
        wide, cell = heapq.heappop(heap)
        if -wide < neck[cell]:
            continue
        for step in ways.straight[cell]:
            other = cell + step
            through = min(-wide, away[other])
            if through > neck[other]:
                neck[other] = through
                heapq.heappush(heap, (-through, other))
    return np.array(neck).reshape(grid.skin.shape)


def _reaches(ways: _Ways, neck: NDArray[np.float64], half: float) -> tuple[dict[int, float], dict[int, int]]:
    """How far in mm each cell behind a neck of this half width is from outside, and from which cell."""
    beyond = neck > half
    edge = np.zeros_like(beyond)
    edge[1:] |= beyond[1:] & ~beyond[:-1]
    edge[:-1] |= beyond[:-1] & ~beyond[1:]
    edge[:, 1:] |= beyond[:, 1:] & ~beyond[:, :-1]
    edge[:, :-1] |= beyond[:, :-1] & ~beyond[:, 1:]
    starts: list[int] = np.flatnonzero(edge).tolist()
    outside: list[bool] = beyond.ravel().tolist()
    reach = dict.fromkeys(starts, 0.0)
    begins = {cell: cell for cell in starts}
    heap = [(0.0, cell) for cell in starts]
    while heap:
        length, cell = heapq.heappop(heap)
        if length > reach[cell]:
            continue
        for step, size in ways.all[cell]:
            other = cell + step
            if not outside[other] and length + size < reach.get(other, math.inf):
                reach[other], begins[other] = length + size, begins[cell]
                heapq.heappush(heap, (length + size, other))
    return reach, begins


def _outer_half(ways: _Ways, reach: dict[int, float], tip: int) -> set[int]:
    """The cells of a flap that are farther from its base than half of its length."""
    found, least, queue = {tip}, 0.5 * reach[tip], [tip]
    while queue:
        cell = queue.pop()
        for step in ways.straight[cell]:
            other = cell + step
            if other not in found and reach.get(other, 0.0) > least:
                found.add(other)
                queue.append(other)
    return found


@dataclass(frozen=True, eq=False)
class _Plane:
    """A plane in which lengths from its middle are those along the skin."""

    middle: NDArray[np.float64]
    axes: NDArray[np.float64]
    normal: NDArray[np.float64]

    @classmethod
    def through(cls, points: NDArray[np.float64]) -> _Plane | None:
        """The plane nearest to points (k, 3); None where they lie along a line."""
        middle = points.mean(axis=0)
        _, sizes, axes = np.linalg.svd(points - middle, full_matrices=False)
        if not sizes[1] > 0.02 * sizes[0]:
            return None
        return cls(middle, axes[:2], axes[2])

    def flat(self, points: ArrayLike) -> NDArray[np.float64]:
        """Points (k, 3) in the plane (k, 2), as far from its middle as they are in space."""
        offsets = np.asarray(points, np.float64).reshape(-1, 3) - self.middle
        flat = offsets @ self.axes.T
        size = np.linalg.norm(flat, axis=1)
        return flat * (np.linalg.norm(offsets, axis=1) / np.maximum(size, 1e-300))[:, None]

    def space(self, flat: NDArray[np.float64]) -> Point:
        """A point of the plane (2,) in space."""
        x, y, z = self.middle + flat @ self.axes
        return (float(x), float(y), float(z))


@dataclass(frozen=True, eq=False)
class _Grid:
    """Cells of the plane around cuts, counted row by row: which of them are skin.

    Parameters
    ----------
    low
        Middle of the first cell in mm, shape (2,).
    cell
        Edge of a cell in mm.
    span
        Diagonal of what the cuts cover in mm.
    skin
        Whether a cell is skin, shape (n, m).
    """

    low: NDArray[np.float64]
    cell: float
    span: float
    skin: NDArray[np.bool_]

    @classmethod
    def around(cls, lines: list[NDArray[np.float64]]) -> _Grid:
        """The grid around lines (k, 2), with their cells taken out."""
        drawn = np.vstack(lines)
        span = float(np.linalg.norm(np.ptp(drawn, axis=0)))
        cell = max(span / _ACROSS, _FINEST)
        low = drawn.min(axis=0) - 0.3 * span
        shape = np.ceil((drawn.max(axis=0) + 0.3 * span - low) / cell).astype(int) + 1
        grid = cls(low, cell, span, np.ones(shape, bool))
        for line in lines:
            grid.skin[tuple(np.round((grid.fine(line) - low) / cell).astype(int).T)] = False
        return grid

    def fine(self, line: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points (k, 2) of a line with several in each cell."""
        way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
        at = np.linspace(0.0, way[-1], int(way[-1] / (0.25 * self.cell)) + 2)
        return np.column_stack([np.interp(at, way, line[:, k]) for k in range(2)])

    def uncut(self, line: NDArray[np.float64]) -> Iterator[set[int]]:
        """The cells of each piece of a line that no cut divides."""
        skin = self.skin.ravel()
        cells = [self.at(point) for point in self.fine(line)]
        for whole, piece in itertools.groupby(cells, key=lambda cell: bool(skin[cell])):
            if whole:
                yield set(piece)

    def at(self, point: NDArray[np.float64]) -> int:
        """The cell of a point (2,), the nearest one of the grid."""
        i, j = np.clip(np.round((point - self.low) / self.cell).astype(int), 0, np.array(self.skin.shape) - 1)
        return int(i) * self.skin.shape[1] + int(j)

    def away(self) -> NDArray[np.float64]:
        """The distance in mm of each cell from the nearest that is not skin, 0 for those, shape (n, m)."""
        cut = np.argwhere(~self.skin)
        flat = np.column_stack([cut, np.zeros(len(cut))]).astype(np.float64)
        cells = np.column_stack([np.argwhere(self.skin), np.zeros(int(self.skin.sum()))]).astype(np.float64)
        away = np.zeros(self.skin.shape)
        each = np.arange(len(cut))
        away[self.skin] = self.cell * ClosestPoint(flat, np.column_stack([each, each, each])).query(cells)[2]
        return away

    def place(self, cell: int) -> NDArray[np.float64]:
        """The middle of a cell in mm, shape (2,)."""
        return self.low + self.cell * np.array(divmod(cell, self.skin.shape[1]), np.float64)

    def within(self, outline: NDArray[np.float64]) -> NDArray[np.bool_]:
        """The cells inside a closed line (k, 2)."""
        cells = np.indices(self.skin.shape).reshape(2, -1).T
        return _within(outline, self.low + self.cell * cells).reshape(self.skin.shape)


@dataclass(frozen=True, eq=False)
class _Ways:
    """The ways from each cell to the cells of skin next to it, none across the corner of what is not skin.

    Found once for a grid: every width goes over all of them again.

    Parameters
    ----------
    straight
        For each cell what leads to those beside it, above and below.
    all
        For each cell what leads to those and the slanted ones, each with its length in mm.
    """

    straight: list[tuple[int, ...]]
    all: list[tuple[tuple[int, float], ...]]

    @classmethod
    def of(cls, grid: _Grid) -> _Ways:
        """Find the ways of a grid."""
        skin, wide = np.pad(grid.skin, 1), grid.skin.shape[1]
        down, up, right, left = skin[2:, 1:-1], skin[:-2, 1:-1], skin[1:-1, 2:], skin[1:-1, :-2]
        free = [down, up, right, left]
        free += [down & right & skin[2:, 2:], down & left & skin[2:, :-2]]
        free += [up & right & skin[:-2, 2:], up & left & skin[:-2, :-2]]
        steps = (wide, -wide, 1, -1, wide + 1, wide - 1, 1 - wide, -1 - wide)
        sizes = (grid.cell,) * 4 + (2**0.5 * grid.cell,) * 4
        # Cells have 256 kinds of surroundings, a bit for each direction.
        kind: list[int] = sum(each.astype(int) << k for k, each in enumerate(free)).ravel().tolist()  # type: ignore[union-attr]
        open_in = [[k for k in range(8) if bits >> k & 1] for bits in range(256)]
        straight = [tuple(steps[k] for k in ways if k < 4) for ways in open_in]
        every = [tuple((steps[k], sizes[k]) for k in ways) for ways in open_in]
        return cls([straight[bits] for bits in kind], [every[bits] for bits in kind])


def _within(outline: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether points (n, 2) lie inside a closed line (k, 2), by the number of its crossings on a ray."""
    inside = np.zeros(len(points), bool)
    for (ax, ay), (bx, by) in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        between = (ay > points[:, 1]) != (by > points[:, 1])
        if between.any():
            inside ^= between & (points[:, 0] < ax + (points[:, 1] - ay) / (by - ay) * (bx - ax))
    return inside


def _sampled(cut: Incision) -> NDArray[np.float64]:
    """The curve of an incision, points (k, 3), its first one again at the end where it is closed."""
    control = np.asarray(cut.points, np.float64)
    size = float(np.linalg.norm(np.diff(control, axis=0), axis=1).sum())
    points = sample_curve(control, cut.basis, cut.closed, max(size / 200.0, 0.3))
    return np.vstack([points, points[:1]]) if cut.closed else points


def _groups(cuts: list[Incision]) -> list[list[Incision]]:
    """The cuts, those near each other together."""
    groups: list[list[Incision]] = []
    for cut in cuts:
        near = [group for group in groups if any(_apart(cut, other) < _TOGETHER for other in group)]
        groups = [group for group in groups if not any(group is other for other in near)]
        groups.append([*(each for group in near for each in group), cut])
    return groups


def _apart(one: Incision, other: Incision) -> float:
    """The distance of the nearest points of two cuts in mm."""
    a, b = np.asarray(one.points, np.float64), np.asarray(other.points, np.float64)
    return float(np.linalg.norm(a[:, None] - b[None], axis=2).min())
