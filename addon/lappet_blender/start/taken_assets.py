"""Take up what was dropped from the asset library: the act that an object stands for, and the object goes."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from lappet.core.problem import RefusedError, refused
from lappet.core.problem_code import ProblemCode
from lappet.geometry.triangles import barycentric
from lappet.tissue.presets import PRESETS

from ..interface.operator_base import last_refusal
from ..model.event_kinds import SEWN_KINDS, THREAD_OF
from ..model.material_values import find_material
from ..model.units import mm_per_unit
from ..tools.shown_surface import Located, shown_surface
from .asset_items import AssetItem, item_of
from .asset_library import TAG

_LIFT = 8.0  # mm above the skin, to which a hook that is dropped pulls


def stands_for(obj: Any) -> AssetItem | None:
    """What an object of the library stands for, None for any other."""
    return item_of(str(obj[TAG])) if obj is not None and TAG in obj else None


def take_up(context: bpy.types.Context, obj: bpy.types.Object) -> str:
    """Do what an object of the library stands for, and remove it. Returns what was done.

    Raises RefusedError where that cannot be.
    """
    item = stands_for(obj)
    if item is None:
        raise refused(ProblemCode.ASSET_UNKNOWN)
    done = _ACTS[item.kind](context, item, obj.matrix_world.translation.copy())
    bpy.data.objects.remove(obj)
    return done


def _model(_context: bpy.types.Context, item: AssetItem, _place: Vector) -> str:
    _run(bpy.ops.lappet.model_add, model=item.name)
    return f"Added the model {item.title}."


def _material(context: bpy.types.Context, item: AssetItem, _place: Vector) -> str:
    procedure = context.scene.lappet
    if procedure.tissue.object is None:
        raise refused(ProblemCode.TISSUE_NONE)
    same = find_material(context.scene, PRESETS[item.name].material)
    if same is None:
        _run(bpy.ops.lappet.material_add, preset=item.name.upper())
        procedure.tissue.material = procedure.materials[procedure.active_material].name
    else:  # a second one of the same values would be a copy that nobody asked for
        procedure.active_material = procedure.materials.find(same)
        procedure.tissue.material = same
    return f"The tissue is of {procedure.tissue.material}."


def _thread(context: bpy.types.Context, item: AssetItem, _place: Vector) -> str:
    events = context.scene.lappet.events
    active = context.scene.lappet.active_event
    chosen = [each for each in events if each.selected and each.kind in SEWN_KINDS]
    if not chosen and 0 <= active < len(events) and events[active].kind in SEWN_KINDS:
        chosen = [events[active]]
    if not chosen:
        raise refused(ProblemCode.ASSET_NO_SUTURE, "", item.title)
    for event in chosen:
        event.mode = "THREAD"
        event.thread = next(key for key, name in THREAD_OF.items() if name == item.name)
    return f"{len(chosen)} suture{'s' * (len(chosen) != 1)} of {item.title}."


def _instrument(context: bpy.types.Context, item: AssetItem, place: Vector) -> str:
    scene = context.scene
    surface = shown_surface(scene, None)
    if surface is None:
        raise refused(ProblemCode.TISSUE_NONE)
    rest = surface.rest
    tree = BVHTree.FromPolygons(surface.positions.tolist(), rest.triangles[rest.skin].tolist())
    near, normal, index, _ = tree.find_nearest(place)
    triangle = rest.skin[np.array([index])]
    corners = surface.positions[rest.triangles[triangle]]
    located = Located(triangle, barycentric(np.array([tuple(near)]), corners))
    anchor = tuple(float(v) for v in rest.at(located)[0])
    if item.name == "landmark":
        _run(bpy.ops.lappet.place_landmark, point=anchor)
        return "Placed a landmark."
    mm = mm_per_unit(scene)
    origin = np.array(tuple(near)) * mm
    target = origin + _LIFT * np.array(tuple(normal))
    _run(bpy.ops.lappet.hook_add, anchor=anchor, origin=tuple(origin), target=tuple(target))
    return "Set a hook; drag its target."


def _plate(_context: bpy.types.Context, item: AssetItem, _place: Vector) -> str:
    _run(bpy.ops.lappet.plate_add, template=item.name)
    return f"Added the plate {item.name}."


def _run(operator: Any, **values: Any) -> None:
    """Run one of Lappet's operators within this step of undo. Raises RefusedError with why it refuses."""
    try:
        operator("EXEC_DEFAULT", False, **values)
    except RuntimeError as error:
        problems = last_refusal()
        if not problems:
            raise
        raise RefusedError(list(problems)) from error


_ACTS = {"model": _model, "material": _material, "thread": _thread, "instrument": _instrument, "plate": _plate}
