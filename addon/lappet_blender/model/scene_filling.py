"""Give a scene the values of a procedure: the inverse of reading it."""

from __future__ import annotations

import math

import bpy
import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Bone, Procedure, Tissue, position_of

from .changes import changed
from .event_list import add_event, remove_event
from .event_values import kind_of, set_event
from .kept_values import KEPT_EVENTS, keep
from .laid_flaps import keep_flap
from .material_values import set_material, set_region
from .mesh_objects import mesh_object
from .plate_values import keep_plates
from .procedure_properties import VERSION
from .scenery_values import claim_scenery, make_scenery
from .skin_line_values import set_skin_line
from .vessel_values import set_vessel


def fill_scene(scene: bpy.types.Scene, procedure: Procedure, collection: bpy.types.Collection) -> list[Problem]:
    """Put the procedure's tissue, bones, scenery, materials, timeline and events into the scene.

    They take the place of what it had.
    Objects are linked to `collection`; the scene keeps its unit. Objects of the procedure before stay in the scene, but
    no part of it. Returns a note of everything that a scene cannot hold. Raises RefusedError, with the
    scene as it was, for meshes that Blender cannot hold.
    """
    made: list[bpy.types.Object] = []
    tissue = procedure.tissue
    try:
        skin = mesh_object(scene, collection, "Tissue", *_polygons(tissue), uv=tissue.uv, groups=tissue.subsets)
        made.append(skin)
        made += [mesh_object(scene, collection, bone.name, *_polygons(bone)) for bone in procedure.bones]
        scenery = make_scenery(scene, collection, procedure)
    except BaseException:
        for obj in made:
            bpy.data.meshes.remove(obj.data)
        raise
    notes = _timeline(scene, procedure)
    _clear(scene)
    _tissue(scene, tissue, skin)
    claim_scenery(scene, procedure, scenery)
    for bone, obj in zip(procedure.bones, made[1:], strict=True):
        entry = scene.lappet.bones.add()
        entry.name, entry.object = bone.name, obj
    for material in procedure.materials:
        set_material(scene, scene.lappet.materials.add(), material)
    for line in procedure.skin_lines:
        set_skin_line(scene.lappet.skin_lines.add(), line)
    for vessel in procedure.vessels:
        set_vessel(scene.lappet.vessels.add(), vessel)
    for region in tissue.regions:
        set_region(scene.lappet.regions.add(), region)
    _events(scene, procedure)
    for flap in procedure.flaps:
        keep_flap(scene, flap)
    keep_plates(scene, procedure.plates)
    kept = keep(scene, procedure)
    names = [*(each.name for each in kept.events), *(each.faces for each in kept.rollers)]
    names += [*(each.name for each in kept.muscles), *(each.name for each in kept.moving_bones)]
    if names:
        notes.append(problem(ProblemCode.SCENE_KEPT, "", ", ".join(names)))
    scene.lappet.version = VERSION
    changed(scene)
    return notes


def _polygons(mesh: Tissue | Bone) -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.int32]]:
    return mesh.points, mesh.face_vertex_counts, mesh.face_vertex_indices


def _clear(scene: bpy.types.Scene) -> None:
    while len(scene.lappet.events):
        remove_event(scene, scene.lappet.events[-1])
    for name in ("bones", "materials", "regions", "skin_lines", "vessels", "flaps"):
        getattr(scene.lappet, name).clear()


def _tissue(scene: bpy.types.Scene, tissue: Tissue, skin: bpy.types.Object) -> None:
    settings = scene.lappet.tissue
    settings.object, settings.thicken = skin, False
    settings.material, settings.spacing, settings.bed_stiffness = tissue.material, tissue.spacing, tissue.bed_stiffness
    settings.bed_shear = tissue.bed_shear
    scene.lappet.solving.self_contact = tissue.self_contact
    settings.use_gravity = tissue.has_gravity
    if tissue.has_gravity:
        settings.gravity = tissue.gravity
    position = position_of(tissue.gravity_direction)
    settings.position = position.upper() if position else "CUSTOM"
    settings.gravity_direction = tissue.gravity_direction


def _timeline(scene: bpy.types.Scene, procedure: Procedure) -> list[Problem]:
    notes = []
    start, end = math.ceil(procedure.start_time), math.floor(procedure.end_time)
    if (start, end) != (procedure.start_time, procedure.end_time):
        span = f"{procedure.start_time:g} to {procedure.end_time:g}"
        notes.append(problem(ProblemCode.SCENE_RANGE, "", span, first=start, last=end))
    scene.frame_start, scene.frame_end = start, end
    if scene.frame_start != start:
        notes.append(problem(ProblemCode.SCENE_START, "", start, first=scene.frame_start))
    fps = max(1, round(procedure.fps))
    scene.render.fps, scene.render.fps_base = fps, fps / procedure.fps
    return notes


def _events(scene: bpy.types.Scene, procedure: Procedure) -> None:
    for value in procedure.events:
        if isinstance(value, KEPT_EVENTS):
            continue
        set_event(scene, add_event(scene, kind_of(value), name=value.name), value)
