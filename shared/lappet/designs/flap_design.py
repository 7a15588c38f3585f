"""What a flap design says about an operation: what is cut, which edges and corners meet, where the flap is carried.

Points are on the uncut skin, mm. A design knows nothing of depth, time or lattice: `lappet.designs.transposition` makes
the events of it.
"""

from __future__ import annotations

from dataclasses import dataclass

from lappet.procedure import Point


@dataclass(frozen=True)
class Edge:
    """One edge of a cut, along which its tissue lies on the `side`: 1 to the left of its direction, -1 to the right."""

    points: tuple[Point, ...]
    side: int


@dataclass(frozen=True)
class Seam:
    """Two edges that are sewn together from start to end, at equal shares of their lengths.

    joined: whether the edges start, and end, in one point (where the cut ends) and not in two corners.
    """

    name: str
    edges: tuple[Edge, Edge]
    joined: tuple[bool, bool]


@dataclass(frozen=True)
class Spot:
    """A corner of the cut skin: the point, and another one towards which its tissue lies."""

    point: Point
    towards: Point


@dataclass(frozen=True)
class Corner:
    """Two corners that meet: of the flap, or of what closes the donor site, and of the wound."""

    name: str
    flap: Spot
    wound: Spot


@dataclass(frozen=True)
class Carry:
    """A hook's way: it takes the flap by a corner and turns it about the pivot until the corner lies at `lay`."""

    name: str
    corner: Spot
    pivot: Point
    lay: Spot


@dataclass(frozen=True)
class FlapDesign:
    """A flap or flaps that fill a defect.

    defect: its outline, closed, counter-clockwise about the normal. seed: a point in it, to excise. incisions: open
    curves, each from the defect outwards. flaps: a point in the middle of each flap.
    """

    defect: tuple[Point, ...]
    seed: Point
    incisions: tuple[tuple[Point, ...], ...]
    seams: tuple[Seam, ...]
    corners: tuple[Corner, ...]
    carries: tuple[Carry, ...]
    flaps: tuple[Point, ...]
