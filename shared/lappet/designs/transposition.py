"""The operation of a flap design: incise, excise, undermine, carry the flap over with hooks, suture, let go."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lappet.designs.flap_design import Carry, Division, FlapDesign
from lappet.designs.seam_sutures import beside_edge, edge_length, suture_runs, sutures
from lappet.designs.technique import Schedule, Technique
from lappet.procedure import Event, Excision, Hook, Incision, Landmark, Point, Thin, Undermine
from lappet.tissue.skin_sheet import SkinSheet

Way = Callable[[float], NDArray[np.float64]]  # from a share of the way to a point in mm, shape (3,)


_USUAL_SCHEDULE, _USUAL_TECHNIQUE = Schedule(), Technique()
_LAID = 0.03  # of its height: where a hook ends that lays a flap down


def flap_operation(
    design: FlapDesign,
    skin: SkinSheet,
    when: Schedule = _USUAL_SCHEDULE,
    how: Technique = _USUAL_TECHNIQUE,
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
        The events: incisions, excision, undermining, hooks, sutures or runs of them, landmarks.
    """
    return (
        *(
            Incision(
                cut.name,
                when.trim - 1.0 if cut.late else when.incise,
                cut.outline,
                kerf=how.kerf,
                closed=not cut.open,
                direction=design.blade,
            )
            for cut in design.excised
        ),
        *([Incision("opening", when.incise, design.opening, kerf=how.kerf)] if design.opening else []),
        *(
            Incision(
                _numbered("limbs", k, len(design.incisions)),
                when.incise,
                curve,
                kerf=how.kerf,
                direction=design.blade,
            )
            for k, curve in enumerate(design.incisions)
        ),
        *excisions(design, when),
        *undermining(design, skin, when, how),
        *(carry_hook(carry, skin, when, how) for carry in design.carries),
        *(suture_runs(design, when, how) if how.runs else sutures(design, skin, when, how)),
        *([] if design.division is None else second_stage(design.division, skin, when, how)),
        *([] if design.thinned is None else [Thin("thinning", when.thin, design.thinned.outline, design.thinned.left)]),
        *landmarks(design, skin, how),
    )


def second_stage(division: Division, skin: SkinSheet, when: Schedule, how: Technique) -> list[Event]:
    """Cut a pedicle off at both ends, take it out and sew what was joined to it.

    Parameters
    ----------
    division
        The second stage.
    skin
        The skin.
    when
        Time codes of the steps.
    how
        Distances and rows of sutures.

    Returns
    -------
    list[Event]
        Incisions, an excision, sutures or runs of them.
    """
    later = replace(when, donor_from=when.rejoin_from, donor_to=when.rejoin_to, suture_from=when.rejoin_from)
    later = replace(later, suture_to=when.rejoin_to)
    sewn = FlapDesign((), (), division.seams, division.corners)
    return [
        *(
            Incision(_numbered("division", k, len(division.cuts)), when.divide, curve, kerf=how.kerf)
            for k, curve in enumerate(division.cuts)
        ),
        Excision("pedicle", when.divide, division.seeds),  # at once: a piece that only a hook holds has no rest
        *(suture_runs(sewn, later, how) if how.runs else sutures(sewn, skin, later, how)),
    ]


def undermining(design: FlapDesign, skin: SkinSheet, when: Schedule, how: Technique) -> list[Undermine]:
    """Free the skin around all cuts, or what a design says is freed.

    Parameters
    ----------
    design
        The design.
    skin
        The skin.
    when
        Time codes of the steps.
    how
        Distances.

    Returns
    -------
    list[Undermine]
        A line for each area; none where the skin stays on its bed.
    """
    if not how.beyond > 0.0:
        return []
    lines = design.freed or (outline(design, skin, how.beyond),)
    return [Undermine(_numbered("undermining", k, len(lines)), when.undermine, line) for k, line in enumerate(lines)]


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
    over = _straight(anchor, lay) if carry.pivot is None else _turned(skin, anchor, lay, carry.pivot, carry.turn)
    # On curved skin the pivot's plane misses the ends by a little, which is spread along the way.
    misses = anchor - skin.place(over(0.0))[0], lay - skin.place(over(1.0))[0]
    height = carry.lift * how.height
    ends = _LAID if carry.holds is None else carry.holds
    targets = []
    # Up, over, down: shares of the time, of the turn and of the height.
    for time, turned, lifted in (
        (0.0, 0.0, 0.0),
        (0.2, 0.08, 0.7),
        (0.4, 0.35, 1.0),
        (0.6, 0.7, 1.0),
        (0.8, 0.95, max(0.6, ends)),
        (1.0, 1.0, ends),
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
        release=when.let_go if carry.holds is None else when.divide,
        stiffness=how.stiffness,
    )


def _straight(start: NDArray[np.float64], end: NDArray[np.float64]) -> Way:
    """The way straight from start to end."""
    return lambda share: start + share * (end - start)


def _turned(
    skin: SkinSheet, start: NDArray[np.float64], end: NDArray[np.float64], about: Point, by: float | None
) -> Way:
    """The way from start to end about a pivot, in the plane of the skin there, by the angle nearest to `by` degrees."""
    pivot, normal = (value[0] for value in skin.at(about))
    first = start - pivot
    first -= (first @ normal) * normal
    axes = np.stack([first / np.linalg.norm(first), np.cross(normal, first / np.linalg.norm(first))])
    begin, finish = (axes @ (point - pivot) for point in (start, end))
    turn = float(np.arctan2(finish[1], finish[0]))
    if by is not None:
        turn += 2.0 * np.pi * round((np.radians(by) - turn) / (2.0 * np.pi))
    sizes = np.linalg.norm(begin), np.linalg.norm(finish)

    def at(share: float) -> NDArray[np.float64]:
        size = sizes[0] + share * (sizes[1] - sizes[0])
        return pivot + size * (np.cos(share * turn) * axes[0] + np.sin(share * turn) * axes[1])

    return at


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
        count = max(3, round(0.5 * sum(edge_length(edge) for edge in seam.edges) / how.follow))
        shares = (np.arange(count) + 0.5) / count
        for what, edge in zip(("flap", "wound"), seam.edges, strict=True):
            points = tuple(beside_edge(skin, edge, share, beside) for share in shares)
            marks.append(Landmark(f"{seam.name}_{what}_edge", points, f"{seam.name} {what} edge"))
    if design.flaps:
        middles = tuple(skin.below(middle, 0.0) for middle in design.flaps)
        marks.append(Landmark("flap_middle", middles, "flap middle"))
    return marks


def _numbered(name: str, k: int, count: int) -> str:
    return name if count == 1 else f"{name}_{k + 1}"
