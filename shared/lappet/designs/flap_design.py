"""What a flap design says about an operation: what is cut, which edges and corners meet, where the flap is carried.

Points are on the uncut skin, mm. A design knows nothing of depth, time or lattice: `lappet.designs.transposition` makes
the events of it.
"""

from __future__ import annotations

from dataclasses import dataclass

from lappet.procedure import Point


@dataclass(frozen=True)
class Edge:
    """One edge of a cut with the side on which its tissue lies.

    Parameters
    ----------
    points
        Points along the edge in mm.
    side
        1 where the tissue lies to the left of the edge's direction, -1 to the right.
    """

    points: tuple[Point, ...]
    side: int


@dataclass(frozen=True)
class Seam:
    """Two edges that are sewn together from start to end, at equal shares of their lengths.

    Parameters
    ----------
    name
        Name of the seam; what begins with "donor" is closed before the rest.
    edges
        The two edges, first the flap's.
    """

    name: str
    edges: tuple[Edge, Edge]


@dataclass(frozen=True)
class Excised:
    """Skin that is cut out: the defect, or a triangle that would stand up as a dog-ear.

    Parameters
    ----------
    name
        Name of the cut around it.
    outline
        Points in mm, closed, counter-clockwise about the normal.
    seed
        A point in its middle in mm.
    late
        Whether it is cut out only after the seams whose names begin with "donor" are closed, as a dog-ear is.
    open
        Whether the side from the outline's last point to its first is not cut, as it lies on the border of an opening.
    """

    name: str
    outline: tuple[Point, ...]
    seed: Point
    late: bool = False
    open: bool = False


@dataclass(frozen=True)
class Spot:
    """A corner of the cut skin.

    Parameters
    ----------
    point
        The corner in mm.
    towards
        A point in mm towards which the corner's tissue lies.
    """

    point: Point
    towards: Point


@dataclass(frozen=True)
class Corner:
    """Two corners that meet in the end.

    Parameters
    ----------
    name
        Name of the pair.
    flap
        Corner of the flap, or of what closes the donor site.
    wound
        Corner of the wound.
    """

    name: str
    flap: Spot
    wound: Spot


@dataclass(frozen=True)
class Carry:
    """The way of a hook that takes a flap by a corner, turns or draws it over and lays it down.

    Parameters
    ----------
    name
        Name of the hook.
    corner
        The flap's corner.
    pivot
        Point in mm about which the flap turns; None for a flap that is drawn straight there.
    lay
        Where the corner goes.
    lift
        Height of the way, as a share of the technique's: of two flaps that pass each other one goes over the other.
    turn
        Angle in degrees by which it turns about the pivot, counter-clockwise as seen from outside, to within half a
        turn; None for the smaller angle.
    holds
        Height at which it ends and holds what it carries until the pedicle is divided, as a share of that of the way;
        None where it lays it down and lets go.
    """

    name: str
    corner: Spot
    pivot: Point | None
    lay: Spot
    lift: float = 1.0
    turn: float | None = None
    holds: float | None = None


@dataclass(frozen=True)
class Division:
    """The second stage of an interpolated flap: when it has healed in, its pedicle is cut off at both ends.

    Parameters
    ----------
    cuts
        Open curves in mm, from one side of the pedicle to the other.
    seeds
        Points in mm in what is discarded.
    seams
        The edges that are sewn together then.
    corners
        The corners that meet then.
    """

    cuts: tuple[tuple[Point, ...], ...]
    seeds: tuple[Point, ...]
    seams: tuple[Seam, ...]
    corners: tuple[Corner, ...] = ()


@dataclass(frozen=True)
class Thinned:
    """The last stage of a flap that is too thick for its place: its deep tissue is taken away.

    Parameters
    ----------
    outline
        Closed curve in mm around what is thinned.
    left
        Thickness that stays below the skin in mm, skin included.
    """

    outline: tuple[Point, ...]
    left: float


@dataclass(frozen=True)
class FlapDesign:
    """A flap, or several, or none, that fill what was excised, or change places.

    Parameters
    ----------
    excised
        What is cut out: first the defect, if there is one.
    incisions
        Open curves in mm, each from the defect, or from the incision before, outwards.
    seams
        The edges that are sewn together.
    corners
        The corners that meet.
    carries
        How hooks carry the flaps.
    flaps
        A point in the middle of each flap in mm.
    undermined
        How far around the cuts the skin is undermined, as a share of what is usual; 0 where it stays on its bed, as an
        island flap does.
    blade
        Direction in which all of it is cut, shape (3,); None for square to the skin.
    freed
        Closed curves in mm inside which the skin is undermined; none for all that lies around the cuts.
    division
        The second stage; None for a flap that needs none.
    thinned
        The stage in which the flap is thinned; None for a flap that needs none.
    opening
        Points in mm, from end to end, of the slit of an opening, such as the mouth, that the cuts go round. Skin
        without an opening is cut there; on skin that has one the design is laid around it, and none is left here.
    """

    excised: tuple[Excised, ...]
    incisions: tuple[tuple[Point, ...], ...]
    seams: tuple[Seam, ...]
    corners: tuple[Corner, ...] = ()
    carries: tuple[Carry, ...] = ()
    flaps: tuple[Point, ...] = ()
    undermined: float = 1.0
    blade: Point | None = None
    freed: tuple[tuple[Point, ...], ...] = ()
    division: Division | None = None
    thinned: Thinned | None = None
    opening: tuple[Point, ...] = ()
