"""Names of the events of laid flaps: those of a design, with the flap's name before them where they are taken."""

from __future__ import annotations

from dataclasses import replace

from lappet.procedure import Event, Landmark, Procedure


def named_apart(events: tuple[Event, ...], procedure: Procedure, design: str) -> tuple[tuple[Event, ...], str]:
    """Give events names, and labels, that a procedure does not have yet.

    Parameters
    ----------
    events
        The events with the names that the design gives them.
    procedure
        The procedure.
    design
        Name of the design.

    Returns
    -------
    tuple[tuple[Event, ...], str]
        The events, and what was put before their names: "limberg_2", or nothing.
    """
    taken = {event.name for event in procedure.events}
    if not taken & {event.name for event in events}:
        return events, ""
    laid = {flap.name for flap in procedure.flaps}
    number = 2
    while _numbered(design, number) in laid or any(name.startswith(f"{_numbered(design, number)}_") for name in taken):
        number += 1
    return prefixed(events, _numbered(design, number), design), _numbered(design, number)


def prefixed(events: tuple[Event, ...], prefix: str, design: str) -> tuple[Event, ...]:
    """Put the name of a flap before the names of its events, and before the labels of its landmarks.

    Parameters
    ----------
    events
        The events with the names that the design gives them.
    prefix
        The flap's name, as "limberg_2".
    design
        Name of the design.

    Returns
    -------
    tuple[Event, ...]
        The events with their new names.
    """

    def renamed(event: Event) -> Event:
        fresh = f"{prefix}_{event.name}"
        if isinstance(event, Landmark):
            return replace(event, name=fresh, label=f"{design} {prefix.rpartition('_')[2]} {event.label}")
        return replace(event, name=fresh)

    return tuple(renamed(event) for event in events)


def free_name(procedure: Procedure, design: str) -> str:
    """Find a name for a laid flap that no other of a procedure has.

    Parameters
    ----------
    procedure
        The procedure.
    design
        Name of the design.

    Returns
    -------
    str
        The design's name as that of a prim, with a number where that is taken.
    """
    taken = {flap.name for flap in procedure.flaps}
    fresh, number = design.replace("-", "_"), 2
    while fresh in taken:
        fresh, number = _numbered(design, number), number + 1
    return fresh


def _numbered(design: str, number: int) -> str:
    return f"{design.replace('-', '_')}_{number}"
