"""Where in the scene a problem is: its event or its object, which a click selects."""

from __future__ import annotations

import bpy

from lappet.core.problem import Problem
from lappet.procedure.prim_paths import TIMELINE

from ..model.event_list import event_index, event_time
from ..model.units import to_world

_SUBSET = "/Procedure/Tissue"


def problem_event(scene: bpy.types.Scene, problem: Problem) -> int:
    """The index of the event that a problem is about, -1 for none. Paths are prims or names of events and objects.

    What is wrong with a stitch is a problem of its run.
    """
    if problem.prim.startswith(f"{TIMELINE}/"):
        return event_index(scene, problem.prim.removeprefix(f"{TIMELINE}/").partition("/")[0].split(".")[0])
    return event_index(scene, problem.prim.split(".")[0].rsplit("/", 1)[-1])


def show_place(context: bpy.types.Context, problem: Problem) -> bool:
    """Move the 3D cursor to the first point of the problem's place and look there; False where it has none."""
    if problem.place is None or not problem.place.points:
        return False
    context.scene.cursor.location = to_world(context.scene, list(problem.place.points[0]))
    if context.region_data is not None:
        context.region_data.view_location = context.scene.cursor.location
    return True


def select_problem(scene: bpy.types.Scene, layer: bpy.types.ViewLayer, problem: Problem) -> bool:
    """Make the problem's event active and go to its frame, or select its object; False where it has none."""
    index = problem_event(scene, problem)
    if index >= 0:
        scene.lappet.active_event = index
        time = int(event_time(scene.lappet.events[index]))
        scene.frame_set(min(max(time, scene.frame_start), scene.frame_end))
        return True
    obj = scene.objects.get(problem.prim)
    if obj is None and problem.prim.startswith(_SUBSET):
        obj = scene.lappet.tissue.object
    if obj is None or layer.objects.get(obj.name) is None:
        return False
    for each in layer.objects:
        each.select_set(each == obj)
    layer.objects.active = obj
    return True
