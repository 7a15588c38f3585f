"""The sutures of a flap design's seams and corners: one by one, or as runs.

Seams that follow each other round corners that meet are one run: those of a flap's perimeter, however many it has.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lappet.designs.flap_design import Corner, Edge, FlapDesign, Seam
from lappet.designs.technique import Row, Schedule, Technique
from lappet.procedure import Point, Suture, SutureLayer, SutureRun
from lappet.suturing.lip_pair import DRIFT, on_edge
from lappet.suturing.stitch_places import SHORT
from lappet.tissue.skin_sheet import SkinSheet

_TOUCH = 1e-3  # mm between ends of edges that are one corner


def sutures(design: FlapDesign, skin: SkinSheet, when: Schedule, how: Technique) -> list[Suture]:
    """Place a suture per row in every corner, and rows of them along every seam; those of the donor site begin first.

    Parameters
    ----------
    design
        The design.
    skin
        The skin.
    when
        Time codes of the steps.
    how
        Rows and distances.

    Returns
    -------
    list[Suture]
        The sutures.
    """
    found = []
    for row in how.rows:
        beside = 0.5 * how.kerf + 0.01 + DRIFT * row.depth
        for corner in design.corners:
            ends = [
                skin.towards(spot.point, spot.towards, 2.0 * beside, row.depth) for spot in (corner.flap, corner.wound)
            ]
            found.append(_single(f"{row.name}_{corner.name}_corner", ends, corner.name, when))
        for seam in design.seams:
            length = 0.5 * sum(edge_length(edge) for edge in seam.edges)
            for k, share in enumerate(_stations(length, how, row) / length):
                ends = [beside_edge(skin, edge, share, beside, row.depth) for edge in seam.edges]
                found.append(_single(f"{row.name}_{seam.name}_{k + 1}", ends, seam.name, when))
    return found


class _Meeting(NamedTuple):
    """Numbers of points of both edges that meet in a corner, and points toward which its tissue lies."""

    first: int
    second: int
    insides: tuple[Point, Point]


@dataclass(frozen=True)
class _Chain:
    """Seams in a row: their edges from end to end, and where corners that meet lie on them.

    seams: their names. edges: points of both. sides: where their tissue lies. corners: what meets on them.
    """

    seams: tuple[str, ...]
    edges: tuple[tuple[Point, ...], tuple[Point, ...]]
    sides: tuple[int, int]
    corners: tuple[_Meeting, ...] = ()

    @classmethod
    def of(cls, seam: Seam) -> _Chain:
        first, second = seam.edges
        return cls((seam.name,), (first.points, second.points), (first.side, second.side))

    def turned(self) -> _Chain:
        """The same from end to start."""
        first, second = self.edges
        corners = tuple(
            _Meeting(len(first) - 1 - each.first, len(second) - 1 - each.second, each.insides)
            for each in reversed(self.corners)
        )
        return _Chain(self.seams[::-1], (first[::-1], second[::-1]), (-self.sides[0], -self.sides[1]), corners)

    def swapped(self) -> _Chain:
        """The same with the other edge first."""
        first, second = self.edges
        corners = tuple(_Meeting(each.second, each.first, each.insides[::-1]) for each in self.corners)
        return _Chain(self.seams, (second, first), (self.sides[1], self.sides[0]), corners)

    def meeting_at_end(self, corner: Corner) -> _Meeting | None:
        """What meets at the end of the edges, where it is the two corners; else None."""
        ends, pair = (self.edges[0][-1], self.edges[1][-1]), (corner.flap, corner.wound)
        for one, other in (pair, pair[::-1]):
            if _same(ends, (one.point, other.point)):
                return _Meeting(len(self.edges[0]) - 1, len(self.edges[1]) - 1, (one.towards, other.towards))
        return None

    def then(self, other: _Chain, meeting: _Meeting) -> _Chain | None:
        """The chain of this one and another one that goes on where it ends on both edges; None where it does not."""
        if (other.edges[0][0], other.edges[1][0]) == (self.edges[0][0], self.edges[1][0]):
            return None
        if self.sides != other.sides:
            return None
        if not _same((self.edges[0][-1], self.edges[1][-1]), (other.edges[0][0], other.edges[1][0])):
            return None
        further = tuple(
            _Meeting(each.first + meeting.first, each.second + meeting.second, each.insides) for each in other.corners
        )
        edges = (*self.edges[0], *other.edges[0][1:]), (*self.edges[1], *other.edges[1][1:])
        return _Chain((*self.seams, *other.seams), edges, self.sides, (*self.corners, meeting, *further))


def suture_runs(design: FlapDesign, when: Schedule, how: Technique) -> list[SutureRun]:
    """Sew the seams of a design as runs, each through all rows; seams that meet in a corner on both edges are one run.

    Parameters
    ----------
    design
        The design.
    when
        Time codes of the steps.
    how
        Rows and distances.

    Returns
    -------
    list[SutureRun]
        The runs, those of the donor site named after it.
    """
    chains = _chains(design)
    names = _names(chains)
    layers = tuple(SutureLayer(row.name, row.depth, row.shift > 0.0) for row in how.rows)
    runs = []
    for name, chain in zip(names, chains, strict=True):
        start, to = _closing(chain.seams[0], when)
        size = 0.5 * sum(polyline_length(edge) for edge in chain.edges)
        runs.append(
            SutureRun(
                f"suture_{name}",
                chain.edges,
                start,
                chain.sides,
                tuple((each.first, each.second) for each in chain.corners),
                to - start,
                min(how.apart, size),
                min(how.margin, 0.45 * size),
                0.5 * how.kerf + 0.01,
                layers,
                insides=tuple(each.insides for each in chain.corners),
            )
        )
    return runs


def _chains(design: FlapDesign) -> list[_Chain]:
    """The seams joined in the corners that meet; then the corners at the chains' ends."""
    chains = [_Chain.of(seam) for seam in design.seams]
    left = list(design.corners)
    for corner in design.corners:
        joined = _join(chains, corner)
        if joined is not None:
            chains = joined
            left.remove(corner)
    found = []
    for chain in chains:
        for corner in list(left):
            last, first = chain.meeting_at_end(corner), chain.turned().meeting_at_end(corner)
            if last is not None:
                chain = replace(chain, corners=(*chain.corners, last))
                left.remove(corner)
            elif first is not None:
                chain = replace(chain, corners=(_Meeting(0, 0, first.insides), *chain.corners))
                left.remove(corner)
        found.append(chain)
    return found


def _join(chains: Sequence[_Chain], corner: Corner) -> list[_Chain] | None:
    """The chains with two joined that go on into each other in a corner; None where none do."""
    for i, one in enumerate(chains):
        for before in (one, one.turned()):
            meeting = before.meeting_at_end(corner)
            if meeting is None:
                continue
            for j, two in enumerate(chains):
                if i == j or _is_donor(one.seams[0]) != _is_donor(two.seams[0]):
                    continue
                for after in (two, two.turned(), two.swapped(), two.turned().swapped()):
                    whole = before.then(after, meeting)
                    if whole is not None:
                        low, high = sorted((i, j))
                        return [*chains[:low], whole, *chains[low + 1 : high], *chains[high + 1 :]]
    return None


def _names(chains: Sequence[_Chain]) -> list[str]:
    """A seam's name for a run of its own, "flap" for those in a row, numbered where there are several."""
    several = [chain for chain in chains if len(chain.seams) > 1]
    names = []
    for chain in chains:
        name = chain.seams[0]
        if len(chain.seams) > 1:
            name = "donor" if _is_donor(name) else "flap"
            name = name if len(several) == 1 else f"{name}_{several.index(chain) + 1}"
        names.append(name)
    return names


def _is_donor(part: str) -> bool:
    return part.startswith("donor")


def _closing(part: str, when: Schedule) -> tuple[float, float]:
    """When a seam or a corner is drawn together."""
    return (when.donor_from, when.donor_to) if _is_donor(part) else (when.suture_from, when.suture_to)


def _same(ends: tuple[Point, Point], others: tuple[Point, Point]) -> bool:
    return all(np.linalg.norm(np.subtract(a, b)) < _TOUCH for a, b in zip(ends, others, strict=True))


def beside_edge(skin: SkinSheet, edge: Edge, share: float, distance: float, depth: float = 0.0) -> Point:
    """Find the point beside an edge at a share of its length.

    Parameters
    ----------
    skin
        The skin.
    edge
        The edge.
    share
        Share of the edge's length, 0 to 1.
    distance
        Distance from the edge into its tissue in mm.
    depth
        Depth below the skin in mm.

    Returns
    -------
    Point
        The point in mm.
    """
    place = on_edge(np.array(edge.points), share)
    return skin.beside(place.point, place.along, edge.side * distance, depth)


def edge_length(edge: Edge) -> float:
    """Measure an edge.

    Parameters
    ----------
    edge
        The edge.

    Returns
    -------
    float
        Its length in mm.
    """
    return polyline_length(edge.points)


def polyline_length(points: Sequence[Point]) -> float:
    """Measure a polyline.

    Parameters
    ----------
    points
        Its points in mm.

    Returns
    -------
    float
        Its length in mm.
    """
    return float(sum(np.linalg.norm(np.subtract(b, a)) for a, b in pairwise(points)))


def _stations(length: float, how: Technique, row: Row) -> NDArray[np.float64]:
    """Where a row's sutures lie along a seam, mm from its start, shape (k,)."""
    first, last = how.margin, length - how.margin
    if last - first < SHORT * how.apart:
        return np.array([0.5 * length])
    gaps = max(1, int((last - first) / how.apart + 1e-6))
    at = np.linspace(first, last, gaps + 1)
    return at[:-1] + row.shift * np.diff(at) if row.shift else at


def _single(name: str, ends: Sequence[Point], part: str, when: Schedule) -> Suture:
    start, to = _closing(part, when)
    return Suture(name, (ends[0], ends[1]), start=start, duration=to - start)
