"""Laid flaps changed afterwards: moved, turned, with other measures; their events are laid anew."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lappet.core.problem import Problem, problem, refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.event_names import named_apart, prefixed
from lappet.designs.library import library_design
from lappet.designs.library_operation import flap_events, skin_line_direction
from lappet.procedure import Event, FlapLines, LaidFlap, Procedure, Tissue
from lappet.procedure.prim_paths import FLAPS

_BY_HAND = 1e-3  # of a number, or a share of it: less than that is rounding


def laid_flap(procedure: Procedure, name: str) -> LaidFlap:
    """Look up a laid flap.

    Parameters
    ----------
    procedure
        The procedure.
    name
        Its name.

    Returns
    -------
    LaidFlap
        The flap.

    Raises
    ------
    RefusedError
        If there is none of that name.
    """
    for flap in procedure.flaps:
        if flap.name == name:
            return flap
    raise refused(ProblemCode.FLAP_UNKNOWN, FLAPS, name, known=", ".join(f.name for f in procedure.flaps) or "none")


def changed_flap(
    procedure: Procedure,
    laid: LaidFlap,
    *,
    at: ArrayLike | None = None,
    direction: ArrayLike | None = None,
    lines: FlapLines | None = None,
    measures: Mapping[str, float] | None = None,
    mirrored: bool | None = None,
    start: float | None = None,
) -> LaidFlap:
    """Change a laid flap; what is not given stays.

    A flap whose direction follows the lines of the skin follows them at its new place too, unless it gets a direction.

    Parameters
    ----------
    procedure
        The procedure.
    laid
        The flap.
    at
        Its new place in mm, shape (3,).
    direction
        Its new direction along the skin, shape (3,).
    lines
        How its direction follows the lines of the skin: "along", "across", or "" for not any more.
    measures
        New values of some of its measures.
    mirrored
        Whether it is mirrored.
    start
        Time code before the first cut.

    Returns
    -------
    LaidFlap
        The changed flap; its events are those of before.

    Raises
    ------
    RefusedError
        If the design has no such measure, a value is out of range, or there are no lines of the skin to follow.
    """
    row = library_design(laid.design)
    values = row.values({**dict(laid.measures), **(measures or {})})
    place = np.asarray(laid.at if at is None else at, np.float64)
    way = np.asarray(laid.direction if direction is None else direction, np.float64)
    follows = ("" if direction is not None else laid.lines) if lines is None else lines
    if follows and direction is None and (at is not None or lines is not None):
        way = skin_line_direction(procedure, place, across=follows == "across")
    (x, y, z), (u, v, w) = place.tolist(), way.tolist()
    return replace(
        laid,
        at=(x, y, z),
        direction=(u, v, w),
        lines=follows,
        measures=tuple(values.items()),
        mirrored=laid.mirrored if mirrored is None else mirrored,
        start=laid.start if start is None else float(start),
    )


def relay(procedure: Procedure, changed: LaidFlap) -> Procedure:
    """Lay a flap of a procedure anew.

    Parameters
    ----------
    procedure
        The procedure.
    changed
        The flap as it should be; of the procedure's flaps it replaces the one of its name.

    Returns
    -------
    Procedure
        The procedure with the new events where the old ones were, its timeline long enough for them.

    Raises
    ------
    RefusedError
        If the procedure has no such flap, or as `lappet.designs.laid_design.flap_on_skin`.
    """
    before = laid_flap(procedure, changed.name)
    gone = set(before.events)
    index = next((k for k, event in enumerate(procedure.events) if event.name in gone), len(procedure.events))
    others = tuple(event for event in procedure.events if event.name not in gone)
    events, end = fresh_events(procedure.tissue, replace(changed, events=before.events))
    if {event.name for event in others} & {event.name for event in events}:
        events, _ = named_apart(flap_events(procedure.tissue, changed)[0], replace(procedure, events=others), "flap")
    laid = replace(changed, events=tuple(event.name for event in events))
    return replace(
        procedure,
        events=(*others[:index], *events, *others[index:]),
        end_time=max(procedure.end_time, end),
        flaps=tuple(laid if flap.name == changed.name else flap for flap in procedure.flaps),
    )


def fresh_events(tissue: Tissue, laid: LaidFlap) -> tuple[tuple[Event, ...], float]:
    """Make the events of a laid flap anew, with the names that they had.

    Parameters
    ----------
    tissue
        The tissue.
    laid
        The flap.

    Returns
    -------
    tuple[tuple[Event, ...], float]
        The events, and the last time code of the operation.

    Raises
    ------
    RefusedError
        As `lappet.designs.laid_design.flap_on_skin`.
    """
    events, end = flap_events(tissue, laid)
    if laid.events and all(name.startswith(f"{laid.name}_") for name in laid.events):
        events = prefixed(events, laid.name, laid.design)
    return events, end


def by_hand(procedure: Procedure, name: str) -> list[Problem]:
    """Find the events of a laid flap that are not as the design made them: changed, or taken out of it.

    Parameters
    ----------
    procedure
        The procedure.
    name
        Name of the flap.

    Returns
    -------
    list[Problem]
        A warning with their names; nothing where there are none, or where the design cannot be laid there any more.

    Raises
    ------
    RefusedError
        If there is no such flap.
    """
    laid = laid_flap(procedure, name)
    made = {event.name: event for event in fresh_events(procedure.tissue, laid)[0]}
    there = {event.name: event for event in procedure.events}
    changed = [each for each in made if each not in there or not _alike(made[each], there[each])]
    if not changed:
        return []
    return [problem(ProblemCode.FLAP_BY_HAND, f"{FLAPS}/{name}", ", ".join(changed))]


def _alike(one: Any, other: Any) -> bool:
    """Whether two values are the same but for rounding."""
    if is_dataclass(one):
        return type(one) is type(other) and all(
            _alike(getattr(one, each.name), getattr(other, each.name)) for each in fields(one)
        )
    if isinstance(one, tuple):
        return isinstance(other, tuple) and len(one) == len(other) and all(map(_alike, one, other))
    if isinstance(one, float) and isinstance(other, float | int):
        return math.isclose(one, other, rel_tol=_BY_HAND, abs_tol=_BY_HAND)
    return bool(one == other)
