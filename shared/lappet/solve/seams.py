"""Seams: where the sutures of a program draw one edge of a wound to the other, on an epoch's surface at rest.

A seam has one or more closures that lie over each other (skin, dermis …). It reaches from end to end of what they
close: beyond the last suture on to the wound's tip or the rim of the tissue, or half way to the sutures of another
seam.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.closest_point import closest_points
from lappet.geometry.labeled_surface import FaceOrigin, Surface
from lappet.geometry.wound_edges import EdgeLoop, EdgePlace, WoundEdges
from lappet.procedure import Suture
from lappet.program.thread_pieces import bites_at_wounds, pieces_between
from lappet.solve.suture_forces import closure_of, suture_number

SAMPLES = 65
"""Places along a seam at which its lips are compared."""

_SPACING = 1.0  # mm of which an anchor may lie a thousandth beyond the wall that it holds
_OVER = 1.0  # mm along an edge that sutures of closures that lie over each other may be apart beyond the others' ends


@dataclass(frozen=True, eq=False)
class Lip:
    """One edge of a seam, as a line through nodes that move with the surface.

    Parameters
    ----------
    pairs
        The two vertices of the surface that each node lies between, shape (n, 2).
    shares
        Its share of the way from the first to the second, shape (n,).
    loop
        Index of its loop in `WoundEdges.loops`.
    places
        Where each sample is along that in mm, shape (SAMPLES,).
    index, share
        Node before each sample, and the sample's share of the way to the next, shape (SAMPLES,).
    """

    pairs: NDArray[np.int64]
    shares: NDArray[np.float64]
    loop: int
    places: NDArray[np.float64]
    index: NDArray[np.int64]
    share: NDArray[np.float64]

    def nodes(self, points: NDArray[np.floating]) -> NDArray[np.float64]:
        """Place the nodes.

        Parameters
        ----------
        points
            Points of the surface in mm, shape (n, 3).

        Returns
        -------
        NDArray[np.float64]
            The nodes in mm, shape (n, 3).
        """
        first, second = (np.asarray(points[self.pairs[:, k]], np.float64) for k in (0, 1))
        return first + self.shares[:, None] * (second - first)

    def samples(self, nodes: NDArray[np.float64]) -> NDArray[np.float64]:
        """Place the samples.

        Parameters
        ----------
        nodes
            The nodes in mm, shape (n, 3).

        Returns
        -------
        NDArray[np.float64]
            The samples in mm, shape (SAMPLES, 3).
        """
        before = nodes[self.index]
        return before + self.share[:, None] * (nodes[self.index + 1] - before)


@dataclass(frozen=True, eq=False)
class Seam:
    """A seam on the surface of an epoch at rest.

    Parameters
    ----------
    name
        Name of the closure that leads, that nearest to the skin's outer side.
    sutures
        Names of the sutures of each closure, that of the leading one first.
    lips
        Its two edges in the same order. Along the first one the skin lies on the left.
    """

    name: str
    sutures: dict[str, tuple[str, ...]]
    lips: tuple[Lip, Lip]


@dataclass(frozen=True)
class _Row:
    """A closure on the edges: places on either lip in the order of the first one's loop; the second's runs back."""

    name: str
    sutures: tuple[str, ...]
    depth: float
    loops: tuple[int, int]
    places: tuple[tuple[float, ...], tuple[float, ...]]


def seams_of(sutures: Sequence[Suture], surface: Surface, edges: WoundEdges) -> tuple[Seam, ...]:
    """Find the seams of an epoch, whether or not their sutures are placed by then.

    Parameters
    ----------
    sutures
        The sutures of the program.
    surface
        Surface of the epoch.
    edges
        The edges of its wounds.

    Returns
    -------
    tuple[Seam, ...]
        The seams. A closure with an anchor farther than `lappet.geometry.wound_edges.REACH` from a wound's edge, or
        whose sutures do not follow one edge of one wound on either side, belongs to none.
    """
    rows = [row for row in _rows(sutures, surface, edges) if row is not None]
    groups: list[list[_Row]] = []
    for row in sorted(rows, key=lambda row: (round(row.depth, 1), -_reach(edges, row))):
        over = next((group for group in groups if _over(edges, group[0], row)), None)
        if over is None:
            groups.append([row])
        else:
            over.append(row)
    seams = (_seam(surface, edges, group, [row for row in rows if row not in group]) for group in groups)
    return tuple(seam for seam in seams if seam is not None)


def _rows(sutures: Sequence[Suture], surface: Surface, edges: WoundEdges) -> list[_Row | None]:
    if not sutures or not edges.loops:
        return []
    bites = [np.array(suture.anchors) for suture in sutures]
    every = np.concatenate(bites)
    borders = np.cumsum([len(each) for each in bites])[:-1]
    skin = np.flatnonzero(surface.origin == FaceOrigin.SKIN)
    triangles = closest_points(every, surface.points, surface.triangles)[0]
    above, _, below_skin = closest_points(every, surface.points, surface.triangles[skin])
    depths = [_depth(each) for each in np.split(below_skin, borders)]
    # From the underside the way to an edge leads around a wall; what is deep belongs to the edge that the skin above
    # it does.
    inner = np.repeat([len(each) > 2 for each in bites], [len(each) for each in bites])
    below = ~np.isin(surface.origin[triangles], (FaceOrigin.SKIN, FaceOrigin.WOUND_WALL))
    triangles = np.where(inner & below, skin[above], triangles)
    passes = _passes(surface, bites, np.split(triangles, borders))
    rows = []
    for name in dict.fromkeys(closure_of(suture.name) for suture in sutures):
        own = [k for k, suture in enumerate(sutures) if closure_of(suture.name) == name]
        own.sort(key=lambda k: suture_number(sutures[k].name))
        ends = [(edges.locate(first, a), edges.locate(second, b)) for k in own for first, a, second, b in passes[k]]
        pairs = [(first, second) for first, second in ends if first and second]
        if pairs and len(pairs) == len(ends) and all(passes[k] for k in own):
            depth = float(np.mean([depths[k] for k in own]))
            rows.append(_row(edges, name, [sutures[k].name for k in own], depth, pairs))
    return rows


_Pass = tuple[NDArray[np.float64], int, NDArray[np.float64], int]


def _passes(
    surface: Surface, bites: Sequence[NDArray[np.float64]], triangles: Sequence[NDArray[np.integer]]
) -> list[list[_Pass]]:
    """For each suture what draws edges together: its two ends, or the passes of a thread across a wound."""
    pieces = pieces_between(bites, triangles)
    held = bites_at_wounds(surface, pieces.points.reshape(-1, 3), pieces.triangles.reshape(-1), _SPACING)
    parted = np.zeros(len(pieces.row), bool) if held is None else held.parted()
    found: list[list[_Pass]] = [[] for _ in bites]
    for k in np.flatnonzero(pieces.passes(parted)):
        (first, second), (a, b) = pieces.points[k], pieces.triangles[k]
        found[pieces.row[k]].append((first, int(a), second, int(b)))
    return found


def _depth(depths: NDArray[np.float64]) -> float:
    """How deep a suture lies in mm: in the mean of its two ends; a thread with more bites as its highest."""
    return float(depths.mean() if len(depths) == 2 else depths.min())


def _row(
    edges: WoundEdges, name: str, sutures: Sequence[str], depth: float, pairs: Sequence[tuple[EdgePlace, EdgePlace]]
) -> _Row | None:
    """A closure whose sutures follow one loop on either side; None where they do not."""
    first, second = [pairs[0][0]], [pairs[0][1]]
    for one, other in pairs[1:]:
        straight = _apart(edges, first[-1], one) + _apart(edges, second[-1], other)
        turned = _apart(edges, first[-1], other) + _apart(edges, second[-1], one)
        one, other = (one, other) if straight <= turned else (other, one)
        first.append(one)
        second.append(other)
    places = []
    for lip in (first, second):
        ordered = _in_order(edges, lip)
        if ordered is None:
            return None
        places.append(ordered)
    lips = _from_one_suture(edges, first, second, places[0], places[1][::-1])
    return _Row(name, tuple(sutures), depth, (first[0].loop, second[0].loop), (tuple(lips[0]), tuple(lips[1])))


def _from_one_suture(
    edges: WoundEdges,
    first: Sequence[EdgePlace],
    second: Sequence[EdgePlace],
    one: list[float],
    other: list[float],
) -> tuple[list[float], list[float]]:
    """Begin both lips of a seam all around an island with the same suture: where it leaves out most of both."""
    count = len(first)
    ahead = other.index(second[[place.at for place in first].index(one[0])].at)
    if min(ahead, count - ahead) <= max(2, count // 8):  # the same, but for sutures that cross
        return one, other
    loops = [edges.loops[lip[0].loop] for lip in (first, second)]
    back = one.index(first[[place.at for place in second].index(other[0])].at)
    lips = ((one, 1), (other, -1))
    held = [
        loop.to_rim(lip[-1], way) < loop.ahead(lip[-1], lip[0], way)
        for loop, (lip, way) in zip(loops, lips, strict=True)
    ]
    begins = [(0, ahead)] * (not held[1]) + [(back, 0)] * (not held[0])  # what ends at a rim begins there
    if not begins:
        return one, other
    left_out = [
        sum(loop.ahead(lip[k - 1], lip[k], way) for loop, (lip, way), k in zip(loops, lips, begin, strict=True))
        for begin in begins
    ]
    a, b = begins[int(np.argmax(left_out))]
    return [*one[a:], *one[:a]], [*other[b:], *other[:b]]


def _apart(edges: WoundEdges, first: EdgePlace, second: EdgePlace) -> float:
    if first.loop != second.loop:
        return float("inf")
    loop = edges.loops[first.loop]
    return min(loop.ahead(first.at, second.at, 1), loop.ahead(first.at, second.at, -1))


def _in_order(edges: WoundEdges, places: Sequence[EdgePlace]) -> list[float] | None:
    """Places along a loop, begun after the widest gap; None where one edge of a wound does not hold them all."""
    if len({place.loop for place in places}) > 1:
        return None
    loop = edges.loops[places[0].loop]
    at = sorted(place.at for place in places)
    gaps = [loop.ahead(one, other, 1) for one, other in zip(at, [*at[1:], at[0]], strict=True)]
    if len(at) > 1:
        gaps[-1] = loop.length - (at[-1] - at[0])
    else:
        gaps[-1] = loop.length
    broken = [loop.to_rim(one, 1) < gap - 1e-9 for one, gap in zip(at, gaps, strict=True)]
    if sum(broken) > 1:
        return None
    widest = broken.index(True) if any(broken) else int(np.argmax(gaps))
    return [*at[widest + 1 :], *at[: widest + 1]]


def _reach(edges: WoundEdges, row: _Row) -> float:
    """Length of the first lip from a closure's first suture to its last in mm."""
    return edges.loops[row.loops[0]].ahead(row.places[0][0], row.places[0][-1], 1)


def _over(edges: WoundEdges, leading: _Row, row: _Row) -> bool:
    """Whether a closure lies over or under another one: most of its sutures are between the others' on either edge."""
    for swap in (False, True):
        loops, places = (row.loops[::-1], row.places[::-1]) if swap else (row.loops, row.places)
        if loops == leading.loops and all(
            _within(edges.loops[leading.loops[k]], leading.places[k], places[k], 1 - 2 * k) for k in (0, 1)
        ):
            return True
    return False


def _within(loop: EdgeLoop, span: Sequence[float], places: Sequence[float], way: int) -> bool:
    """Whether most of some places lie between the ends of others, or no more than `_OVER` beyond."""
    size = loop.ahead(span[0], span[-1], way)
    offs = [loop.ahead(span[0], place, way) for place in places]
    beyond = [0.0 if off <= size else min(off - size, loop.length - off) for off in offs]
    return float(np.median(beyond)) <= _OVER


def _seam(surface: Surface, edges: WoundEdges, group: Sequence[_Row], others: Sequence[_Row]) -> Seam | None:
    leading = group[0]
    loops = [edges.loops[index] for index in leading.loops]
    stops = [
        [place for row in others for k in (0, 1) if row.loops[k] == index for place in row.places[k]]
        for index in leading.loops
    ]
    begins, ends = ((leading.places[0][k], leading.places[1][k]) for k in (0, -1))
    same = leading.loops[0] == leading.loops[1]
    before = _ends(surface, loops, stops, begins, (-1, 1), same, ends)
    after = _ends(surface, loops, stops, ends, (1, -1), same, begins)
    found = []
    for k, way in ((0, 1), (1, -1)):
        places = leading.places[k]
        sizes = [before[k], *(loops[k].ahead(one, other, way) for one, other in pairwise(places)), after[k]]
        # Sutures in one place: rounding may put the second one before the first, a whole loop ahead.
        found.append([0.0 if loops[k].length - size < 1e-6 else size for size in sizes])
    knots = np.concatenate([[0.0], np.cumsum(np.mean(found, axis=0))])
    if knots[-1] < 1e-6:
        return None
    lips = []
    for k, way in ((0, 1), (1, -1)):
        begin = leading.places[k][0] - way * before[k]
        lips.append(_lip(surface, loops[k], leading.loops[k], begin, way, found[k], knots))
    return Seam(leading.name, {row.name: row.sutures for row in group}, (lips[0], lips[1]))


def _lip(
    surface: Surface,
    loop: EdgeLoop,
    index: int,
    begin: float,
    way: int,
    sizes: Sequence[float],
    knots: NDArray[np.float64],
) -> Lip:
    along = np.concatenate([[0.0], np.cumsum(sizes)])
    pairs, shares = loop.nodes(begin, float(along[-1]), way)
    nodes = surface.points[pairs[:, 0]]
    nodes = nodes + shares[:, None] * (surface.points[pairs[:, 1]] - nodes)
    at = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(nodes, axis=0), axis=1))])
    # Between two sutures, what lies at equal shares of the edges' lengths at rest should meet.
    wanted = np.interp(np.linspace(0.0, knots[-1], SAMPLES), knots, along)
    before = np.clip(np.searchsorted(at, wanted, side="right") - 1, 0, len(at) - 2)
    share = np.clip((wanted - at[before]) / np.maximum(at[before + 1] - at[before], 1e-300), 0.0, 1.0)
    return Lip(pairs, shares, index, (begin + way * wanted) % loop.length, before, share)


def _ends(
    surface: Surface,
    loops: Sequence[EdgeLoop],
    stops: Sequence[Sequence[float]],
    last: tuple[float, float],
    ways: tuple[int, int],
    same: bool,
    first: tuple[float, float],
) -> tuple[float, float]:
    """How far either lip goes on beyond its last suture."""
    found = []
    for k, (loop, way) in enumerate(zip(loops, ways, strict=True)):
        others = [loop.ahead(last[k], place, way) for place in stops[k]]
        others.append(loop.ahead(last[k], first[k], way) or loop.length)  # the seam's own other end, all around
        rim, other = loop.to_rim(last[k], way), min(others)
        tip = (loop.ahead(last[k], last[1 - k], way) or loop.length) if same else np.inf
        if tip <= min(other, rim):
            return _tip(surface, loop, last, ways[0], loop.ahead(last[0], last[1], ways[0]))
        found.append(min(rim, 0.5 * other))
    return found[0], found[1]


def _tip(surface: Surface, loop: EdgeLoop, last: tuple[float, float], way: int, size: float) -> tuple[float, float]:
    """Where both lips meet: what is farthest from their last sutures."""
    pairs, shares = loop.nodes(last[0], size, way)
    nodes = surface.points[pairs[:, 0]]
    nodes = nodes + shares[:, None] * (surface.points[pairs[:, 1]] - nodes)
    far = np.minimum(np.linalg.norm(nodes - nodes[0], axis=1), np.linalg.norm(nodes - nodes[-1], axis=1))
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(nodes, axis=0), axis=1))])
    tip = float(along[int(np.argmax(far))])
    return tip, size - tip
