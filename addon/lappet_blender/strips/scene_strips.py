"""The events of a scene as strips, its markers as steps, and drags written back to the events."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import bpy

from lappet.core.problem import RefusedError, refused
from lappet.core.problem_code import ProblemCode

from ..events.edit_events import duplicate_event
from ..events.event_check import check_events
from ..model.changes import changed
from ..model.decimals import decimal
from ..model.event_kinds import HOLD_KINDS, SEWN_KINDS
from ..model.event_list import event_end, event_index, event_time, find_event, move_event, remove_event
from ..model.event_values import event_value
from ..model.tissue_values import tissue_value
from .strip import Part, Step, Strip, steps_of, strips_of_step
from .strip_drag import Span, dragged


def scene_strips(scene: bpy.types.Scene) -> tuple[Strip, ...]:
    """A strip for every event that has a time: landmarks have none."""
    data = scene.lappet
    return tuple(
        Strip(
            event.uid,
            event.name,
            event.kind,
            event_time(event),
            event_end(event),
            event.enabled,
            event.selected,
            index == data.active_event,
        )
        for index, event in enumerate(data.events)
        if event.kind != "LANDMARK"
    )


def scene_steps(scene: bpy.types.Scene) -> tuple[Step, ...]:
    """The steps that the scene's markers name."""
    return steps_of(((each.name, float(each.frame)) for each in scene.timeline_markers), float(scene.frame_end))


def chosen_strips(scene: bpy.types.Scene, names: str = "") -> list[Strip]:
    """The strips of events named in a text, separated by blanks or commas; for "" the selected, else the active one.

    Raises RefusedError for a name that no event has, and where there is none to act on.
    """
    strips = {strip.uid: strip for strip in scene_strips(scene)}
    if names.strip():
        uids = [_uid(scene, name) for name in names.replace(",", " ").split()]
        found = [strips[uid] for uid in uids if uid in strips]
    else:
        found = [s for s in strips.values() if s.selected] or [s for s in strips.values() if s.active]
    if not found:
        raise refused(ProblemCode.EVENT_NONE_ACTIVE)
    return found


def select_strips(scene: bpy.types.Scene, uids: Iterable[str], extend: bool = False) -> None:
    """Select the strips of events, and make the first the active event; a selected one alone is taken out by extend."""
    wanted = list(uids)
    events = scene.lappet.events
    if extend and len(wanted) == 1 and (event := find_event(scene, wanted[0])) is not None and event.selected:
        event.selected = False
        return
    for event in events:
        event.selected = event.uid in wanted or (extend and event.selected)
    if wanted:
        scene.lappet.active_event = event_index(scene, wanted[0])


def move_strips(scene: bpy.types.Scene, strips: Sequence[Strip], part: Part, shift: float) -> None:
    """Shift strips, or one end of each. Raises RefusedError, with all events as they were, where one cannot be so."""
    before = {strip.uid: Span(strip.start, strip.end) for strip in strips}
    _set_spans(scene, dragged(strips, part, shift))
    try:
        _check(scene, before)
    except RefusedError:
        _set_spans(scene, before)
        raise


def copy_strips(scene: bpy.types.Scene, strips: Sequence[Strip], shift: float) -> list[str]:
    """Add copies of events, so many frames later, and select them instead; return their uids.

    Raises RefusedError, without any copy, where one cannot be there.
    """
    copies = []
    for strip in strips:
        duplicate_event(scene, find_event(scene, strip.uid), shift)
        copies.append(scene.lappet.events[-1].uid)
    try:
        _check(scene, copies)
    except RefusedError:
        for uid in copies:
            remove_event(scene, find_event(scene, uid))
        raise
    select_strips(scene, copies)
    return copies


def move_step(scene: bpy.types.Scene, step: Step, shift: float) -> None:
    """Shift a step: its marker and all that begins in it, by whole frames.

    Raises RefusedError, with all as it was, where an event cannot be so.
    """
    whole = round(shift)
    strips = scene_strips(scene)
    uids = strips_of_step(step, strips)
    move_strips(scene, [strip for strip in strips if strip.uid in uids], Part.BODY, float(whole))
    for marker in scene.timeline_markers:
        if marker.frame == round(step.start):
            marker.frame += whole
            break


def _set_spans(scene: bpy.types.Scene, spans: Mapping[str, Span]) -> None:
    """Have events begin and end then; keyframes of targets move with what moves whole."""
    for uid, span in spans.items():
        event: Any = find_event(scene, uid)
        start, end = event_time(event), event_end(event)
        if abs((span.end - end) - (span.start - start)) < 1e-6:
            move_event(scene, event, span.start)
            continue
        event.start = span.start
        if event.kind in HOLD_KINDS:
            event.end = span.end
        elif event.kind in SEWN_KINDS:
            event.duration = round(span.end - decimal(event.start), 4)
    changed(scene)


def _check(scene: bpy.types.Scene, uids: Iterable[str]) -> None:
    """Raise RefusedError for what is wrong with events that take place; without a tissue nothing is."""
    if tissue_value(scene)[0] is None:
        return
    events: list[Any] = [find_event(scene, uid) for uid in uids]
    values = [event_value(scene, event) for event in events if event is not None and event.enabled]
    if values:
        check_events(scene, values)


def _uid(scene: bpy.types.Scene, name: str) -> str:
    event = find_event(scene, name)
    if event is None:
        known = ", ".join(each.name for each in scene.lappet.events) or "none"
        raise refused(ProblemCode.EVENT_UNKNOWN, "", name, known=known)
    return str(event.uid)
