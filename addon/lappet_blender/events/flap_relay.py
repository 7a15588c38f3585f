"""Lay a flap of a scene anew: its events are replaced, all or none."""

from __future__ import annotations

import math
from dataclasses import replace

import bpy

from lappet.core.problem import Problem, RefusedError, refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.laid_flaps import by_hand, laid_flap, relay
from lappet.procedure import LaidFlap, Procedure
from lappet.procedure.prim_paths import FLAPS

from ..model.event_list import event_index, find_event, remove_event
from ..model.laid_flaps import events_of, keep_flap
from ..model.scene_procedure import read_scene
from .add_events import add_events


def scene_procedure(scene: bpy.types.Scene) -> Procedure:
    """The scene's procedure. Raises RefusedError with what keeps it from being read."""
    reading = read_scene(scene)
    if reading.procedure is None:
        raise RefusedError([each for each in reading.problems if each.severity == "error"])
    return reading.procedure


def put_flap(scene: bpy.types.Scene, before: Procedure, after: Procedure) -> int:
    """Put the flap that was laid last into the scene, and return the number of its events.

    before, after: what the scene holds, and that with the flap. Raises RefusedError, with the scene as it was.
    """
    last = scene.frame_end
    scene.frame_end = max(last, math.ceil(after.end_time))
    try:
        names = add_events(scene, after.events[len(before.events) :])
    except RefusedError:
        scene.frame_end = last
        raise
    keep_flap(scene, replace(after.flaps[-1], events=names))
    return len(names)


def relay_flap(scene: bpy.types.Scene, procedure: Procedure, flap: LaidFlap) -> tuple[Procedure, list[Problem]]:
    """Lay a flap of the scene anew, as `flap` has it; the event that was active stays so.

    procedure: what the scene holds. Returns the procedure with the new flap, and a warning that names what of it was
    changed by hand, which is lost. Raises RefusedError, with the scene as it was.
    """
    lost = by_hand(procedure, flap.name)
    made = relay(procedure, flap)
    names = set(laid_flap(made, flap.name).events)
    old = events_of(scene, flap.name)
    active = _active_name(scene)
    values = [event for event in made.events if event.name in names]
    last = scene.frame_end
    scene.frame_end = max(last, math.ceil(made.end_time))
    try:
        fresh = add_events(scene, values, instead=old)
    except RefusedError:
        scene.frame_end = last
        raise
    keep_flap(scene, replace(laid_flap(made, flap.name), events=fresh))
    index = event_index(scene, active)
    if index >= 0:
        scene.lappet.active_event = index
    return made, lost


def remove_flap(scene: bpy.types.Scene, name: str) -> int:
    """Remove a flap with all its events, and return how many. Raises RefusedError where there is none of that name."""
    index = scene.lappet.flaps.find(name) if name else -1
    if index < 0:
        known = ", ".join(each.name for each in scene.lappet.flaps) or "none"
        raise refused(ProblemCode.FLAP_UNKNOWN, FLAPS, name, known=known)
    names = events_of(scene, name)
    for each in names:
        event = find_event(scene, each)
        if event is not None:
            remove_event(scene, event)
    scene.lappet.flaps.remove(index)
    return len(names)


def _active_name(scene: bpy.types.Scene) -> str:
    events, active = scene.lappet.events, scene.lappet.active_event
    return str(events[active].name) if 0 <= active < len(events) else ""
