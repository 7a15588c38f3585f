"""The operation of a flap design: incise, excise, undermine, carry the flap over with hooks, suture, let go."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from lappet.designs.flap_design import Carry, Edge, FlapDesign
from lappet.procedure import Event, Excision, Hook, Incision, Landmark, Point, Suture, Undermine
from lappet.tissue.skin_sheet import SkinSheet

# How far into the tissue a deep bite lies for each mm of its depth: what the wall of a cut through curved tissue, made
# of chords, drifts from the skin's normal at most, or the bite would be in the other wall. Measured on the examples:
# less than 0.03.
DRIFT = 0.05
SHORT = 0.6  # of the distance between two sutures: a seam with less room than this between its margins gets one suture

Way = Callable[[float], NDArray[np.float64]]  # from a share of the way to a point in mm, shape (3,)


@dataclass(frozen=True)
class Schedule:
    """When what is done, as time codes.

    Parameters
    ----------
    incise
        The cuts.
    excise
        The removal of the defect.
    undermine
        The release of the skin around it.
    lift
        The hooks begin to lift the flap.
    carried
        The hooks have laid the flap down.
    donor_from
        The sutures of the donor site begin to draw together.
    donor_to
        The donor site is closed.
    suture_from
        The other sutures begin to draw together.
    suture_to
        All seams are closed.
    let_go
        The hooks are released.
    end
        Last frame.
    trim
        The removal of what is cut out late; it is incised a frame before.
    """

    incise: float = 2
    excise: float = 4
    undermine: float = 6
    lift: float = 8
    carried: float = 24
    donor_from: float = 24
    donor_to: float = 32
    suture_from: float = 26
    suture_to: float = 37
    let_go: float = 35
    end: float = 40
    trim: float = 34


@dataclass(frozen=True)
class Row:
    """A row of sutures.

    Parameters
    ----------
    name
        Name of the row.
    depth
        Depth of the anchors below the skin in mm.
    shift
        Shift of its sutures along the seam, as a share of the distance between two.
    """

    name: str
    depth: float
    shift: float = 0.0


@dataclass(frozen=True)
class Technique:
    """How the surgeon works.

    Parameters
    ----------
    kerf
        Width of the cuts in mm.
    beyond
        How far around the design the skin is undermined in mm; 0 where it is not.
    apart
        Distance from suture to suture in mm.
    margin
        Distance from the first suture of a seam to the seam's end in mm.
    rows
        Rows of sutures; the corners are held in each.
    height
        Height to which the hooks lift the flap in mm.
    inside
        Distance from a flap's corner to its hook in mm.
    stiffness
        Stiffness of the hooks in mN/mm.
    follow
        Distance between two points of an edge that are measured in mm.
    """

    kerf: float = 0.05
    beyond: float = 15.0
    apart: float = 2.8
    margin: float = 2.0
    rows: tuple[Row, ...] = (Row("deep", 3.2), Row("dermal", 0.6, 0.5), Row("skin", 0.0))
    height: float = 10.0
    inside: float = 2.0
    stiffness: float = 300.0
    follow: float = 1.0


def flap_operation(
    design: FlapDesign,
    skin: SkinSheet,
    when: Schedule = Schedule(),
    how: Technique = Technique(),
) -> tuple[Event, ...]:
    """Plan the operation of a flap design, with the landmarks to judge it by.

    Landmarks come in pairs that lie on each other when all is well: "<corner> flap" and "<corner> wound" for every
    corner of the design, "<seam> flap edge" and "<seam> wound edge" with points along the edges of every seam; and
    "flap middle" where there are flaps.

    Parameters
    ----------
    design
        The design on the skin.
    skin
        The skin on which the sutures and hooks are placed.
    when
        Time codes of the steps.
    how
        Distances and stiffness.

    Returns
    -------
    tuple[Event, ...]
        The events: incisions, excision, undermining, hooks, sutures, landmarks.
    """
    return (
        *(
            Incision(cut.name, when.trim - 1.0 if cut.late else when.incise, cut.outline, kerf=how.kerf, closed=True)
            for cut in design.excised
        ),
        *(
            Incision(_numbered("limbs", k, len(design.incisions)), when.incise, curve, kerf=how.kerf)
            for k, curve in enumerate(design.incisions)
        ),
        *excisions(design, when),
        *([Undermine("undermining", when.undermine, outline(design, skin, how.beyond))] if how.beyond > 0.0 else []),
        *(carry_hook(carry, skin, when, how) for carry in design.carries),
        *sutures(design, skin, when, how),
        *landmarks(design, skin, how),
    )


def excisions(design: FlapDesign, when: Schedule) -> list[Excision]:
    """Take out what is cut out, at first and late.

    Parameters
    ----------
    design
        The design.
    when
        Time codes of the steps.

    Returns
    -------
    list[Excision]
        At most two excisions.
    """
    steps = (("excision", when.excise, False), ("trimming", when.trim, True))
    seeds = {late: tuple(cut.seed for cut in design.excised if cut.late == late) for late in (False, True)}
    return [Excision(name, time, seeds[late]) for name, time, late in steps if seeds[late]]


def outline(design: FlapDesign, skin: SkinSheet, beyond: float) -> tuple[Point, ...]:
    """Draw a convex line around all cuts of a design.

    Parameters
    ----------
    design
        The design.
    skin
        The skin on which the line lies.
    beyond
        Distance of the line from the cuts in mm.

    Returns
    -------
    tuple[Point, ...]
        Points of the closed line on the skin in mm.
    """
    curves = [*(cut.outline for cut in design.excised), *design.incisions]
    drawn = np.array([point for curve in curves for point in curve])
    middle, normal = skin.at(drawn.mean(axis=0))
    first = np.cross(normal[0], (0.0, 1.0, 0.0) if abs(normal[0][1]) < 0.9 else (1.0, 0.0, 0.0))
    first /= np.linalg.norm(first)
    axes = np.stack([first, np.cross(normal[0], first)])
    flat = (drawn - middle[0]) @ axes.T
    # On curved skin the plane sees lengths shortened: measured from the middle they are those of the skin again.
    height = np.einsum("ij,j->i", drawn - middle[0], normal[0])
    size = np.linalg.norm(flat, axis=1)
    flat *= (np.hypot(size, height) / np.maximum(size, 1e-300))[:, None]
    turn = 2.0 * np.pi * np.arange(48) / 48
    rays = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    around = flat[(flat @ rays.T).argmax(axis=0)] + beyond * rays
    return tuple(skin.below(point, 0.0) for point in middle[0] + around @ axes)


def carry_hook(carry: Carry, skin: SkinSheet, when: Schedule, how: Technique) -> Hook:
    """Make the hook that lifts a flap near its corner, turns it about the pivot or draws it over, and lays it down.

    Parameters
    ----------
    carry
        The flap's way.
    skin
        The skin.
    when
        Time codes of the steps.
    how
        Distances and stiffness.

    Returns
    -------
    Hook
        The hook.
    """
    anchor = np.array(skin.towards(carry.corner.point, carry.corner.towards, how.inside))
    lay = np.array(skin.towards(carry.lay.point, carry.lay.towards, how.inside))
    over = _straight(anchor, lay) if carry.pivot is None else _turned(skin, anchor, lay, carry.pivot)
    # On curved skin the pivot's plane misses the ends by a little, which is spread along the way.
    misses = anchor - skin.place(over(0.0))[0], lay - skin.place(over(1.0))[0]
    height = carry.lift * how.height
    targets = []
    # Up, over, down: shares of the time, of the turn and of the height.
    for time, turned, lifted in (
        (0.0, 0.0, 0.0),
        (0.2, 0.08, 0.7),
        (0.4, 0.35, 1.0),
        (0.6, 0.7, 1.0),
        (0.8, 0.95, 0.6),
        (1.0, 1.0, 0.03),
    ):
        below = skin.place(over(turned))[0]
        on_skin, up = skin.at(below + (1.0 - turned) * misses[0] + turned * misses[1])
        x, y, z = np.round(on_skin[0] + lifted * height * up[0], 4)
        targets.append((float(round(when.lift + time * (when.carried - when.lift))), (float(x), float(y), float(z))))
    return Hook(
        f"hook_{carry.name}",
        skin.below(anchor, 0.0),
        tuple(targets),
        start=when.lift,
        release=when.let_go,
        stiffness=how.stiffness,
    )


def _straight(start: NDArray[np.float64], end: NDArray[np.float64]) -> Way:
    """The way straight from start to end."""
    return lambda share: start + share * (end - start)


def _turned(skin: SkinSheet, start: NDArray[np.float64], end: NDArray[np.float64], about: Point) -> Way:
    """The way from start to end about a pivot, in the plane of the skin there."""
    pivot, normal = (value[0] for value in skin.at(about))
    first = start - pivot
    first -= (first @ normal) * normal
    axes = np.stack([first / np.linalg.norm(first), np.cross(normal, first / np.linalg.norm(first))])
    begin, finish = (axes @ (point - pivot) for point in (start, end))
    turn = float(np.arctan2(finish[1], finish[0]))
    sizes = np.linalg.norm(begin), np.linalg.norm(finish)

    def at(share: float) -> NDArray[np.float64]:
        size = sizes[0] + share * (sizes[1] - sizes[0])
        return pivot + size * (np.cos(share * turn) * axes[0] + np.sin(share * turn) * axes[1])

    return at


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
            found.append(_suture(f"{row.name}_{corner.name}_corner", ends, corner.name, when))
        for seam in design.seams:
            length = 0.5 * sum(_length(edge) for edge in seam.edges)
            for k, share in enumerate(_stations(length, how, row) / length):
                ends = [beside_edge(skin, edge, share, beside, row.depth) for edge in seam.edges]
                found.append(_suture(f"{row.name}_{seam.name}_{k + 1}", ends, seam.name, when))
    return found


def landmarks(design: FlapDesign, skin: SkinSheet, how: Technique) -> list[Landmark]:
    """Mark both corners of every pair, the edges of every seam, the middles of the flaps and the ends of the field.

    Parameters
    ----------
    design
        The design.
    skin
        The skin.
    how
        Distances.

    Returns
    -------
    list[Landmark]
        The landmarks.
    """
    marks = []
    beside = 0.5 * how.kerf + 0.05
    for corner in design.corners:
        for what, spot in (("flap", corner.flap), ("wound", corner.wound)):
            at = skin.towards(spot.point, spot.towards, 2.0 * beside)
            marks.append(Landmark(f"{corner.name}_{what}_corner", (at,), f"{corner.name} {what}"))
    for seam in design.seams:
        count = max(3, round(0.5 * sum(_length(edge) for edge in seam.edges) / how.follow))
        shares = (np.arange(count) + 0.5) / count
        for what, edge in zip(("flap", "wound"), seam.edges, strict=True):
            points = tuple(beside_edge(skin, edge, share, beside) for share in shares)
            marks.append(Landmark(f"{seam.name}_{what}_edge", points, f"{seam.name} {what} edge"))
    if design.flaps:
        middles = tuple(skin.below(middle, 0.0) for middle in design.flaps)
        marks.append(Landmark("flap_middle", middles, "flap middle"))
    return marks


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
    points = np.array(edge.points)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    at = share * along[-1]
    k = min(int(np.searchsorted(along, at, side="right")), len(points) - 1)
    on_edge = points[k - 1] + (at - along[k - 1]) / (along[k] - along[k - 1]) * (points[k] - points[k - 1])
    low, high = max(k - 2, 0), min(k + 1, len(points) - 1)  # the direction of a curved edge, over its neighbors too
    return skin.beside(on_edge, points[high] - points[low], edge.side * distance, depth)


def _stations(length: float, how: Technique, row: Row) -> NDArray[np.float64]:
    """Where a row's sutures lie along a seam, mm from its start, shape (k,)."""
    first, last = how.margin, length - how.margin
    if last - first < SHORT * how.apart:
        return np.array([0.5 * length])
    gaps = max(1, int((last - first) / how.apart + 1e-6))
    at = np.linspace(first, last, gaps + 1)
    return at[:-1] + row.shift * np.diff(at) if row.shift else at


def _suture(name: str, ends: Sequence[Point], part: str, when: Schedule) -> Suture:
    donor = part.startswith("donor")
    start, to = (when.donor_from, when.donor_to) if donor else (when.suture_from, when.suture_to)
    return Suture(name, (ends[0], ends[1]), start=start, duration=to - start)


def _length(edge: Edge) -> float:
    return float(sum(np.linalg.norm(np.subtract(b, a)) for a, b in pairwise(edge.points)))


def _numbered(name: str, k: int, count: int) -> str:
    return name if count == 1 else f"{name}_{k + 1}"
