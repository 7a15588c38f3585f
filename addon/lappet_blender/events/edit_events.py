"""Retimes, selects, duplicates events, and goes to their frames."""

from __future__ import annotations

from typing import Any

import bpy

from lappet.core.problem import RefusedError

from ..model.changes import changed
from ..model.event_list import add_event, event_index, event_time, find_event, move_event, set_points, target_name
from ..model.event_target import copy_target, is_there
from ..model.event_values import event_value
from ..model.suture_run_values import run_corners, run_insides, run_layers, set_corners, set_layers
from ..model.tissue_values import tissue_value
from .event_check import check_events

_COPIED = (
    "enabled",
    "start",
    "end",
    "duration",
    "basis",
    "closed",
    "through",
    "depth",
    "kerf",
    "thickness",
    "dressing",
    "direction",
    "stiffness",
    "mode",
    "thread",
    "length",
    "tension",
    "pull_through",
    "grip",
    "label",
    "second_from",
    "first_left",
    "second_left",
    "spacing",
    "margin",
    "bite",
    "pattern",
    "pass_depth",
    "order",
    "drawn",
)


def retime_event(scene: bpy.types.Scene, event: Any, time: float) -> None:
    """Move an event to another frame. Raises RefusedError, with the event as it was, where it cannot happen then."""
    before = event_time(event)
    move_event(scene, event, time)
    try:
        if event.enabled and tissue_value(scene)[0] is not None:
            check_events(scene, [event_value(scene, event)])
    except RefusedError:
        move_event(scene, event, before)
        raise


def select_event(scene: bpy.types.Scene, layer: bpy.types.ViewLayer, event: Any) -> None:
    """Make an event the active one, and its empty the selected object."""
    scene.lappet.active_event = event_index(scene, event.uid)
    if is_there(scene, event.target) and layer.objects.get(event.target.name) is not None:
        for each in layer.objects.selected:
            each.select_set(False, view_layer=layer)
        event.target.select_set(True, view_layer=layer)
        layer.objects.active = event.target


def jump_to_event(scene: bpy.types.Scene, event: Any) -> None:
    """Make an event the active one and go to its frame."""
    scene.lappet.active_event = event_index(scene, event.uid)
    time = event_time(event)
    scene.frame_set(int(time // 1), subframe=time % 1)


def duplicate_event(scene: bpy.types.Scene, source: Any, shift: float = 0.0) -> None:
    """Add a copy of an event, `shift` frames later, with an empty and keyframes of its own."""
    uid, target = source.uid, source.target
    fields = {field: getattr(source, field) for field in _COPIED}
    points = [tuple(point.co) for point in source.points]
    corners, insides, layers = run_corners(source), run_insides(source), run_layers(source)
    named = not source.name.startswith(f"{source.kind.lower()}_")
    fresh = add_event(scene, source.kind, source.name if named else "", **fields)
    if fresh.kind == "LANDMARK":
        fresh.label = fresh.name  # reports tell landmarks apart by their labels
    set_points(fresh, points)
    set_corners(fresh, corners, insides)
    set_layers(fresh, layers)
    if target is not None:
        fresh.target = copy_target(scene, target, fresh.uid)
        fresh.target.name = target_name(fresh.name)
    if shift:
        move_event(scene, fresh, event_time(find_event(scene, uid)) + shift)
    changed(scene)
