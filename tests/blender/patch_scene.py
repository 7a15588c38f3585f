"""A scene to solve: a patch of skin of 24 x 16 x 2 mm, frames 1 to 8, slit at 3, a hook from 4 to 8."""

from __future__ import annotations

import bpy
import numpy as np

from lappet.procedure import Tissue
from lappet.tissue.patch import flat_patch
from lappet_blender.model.event_list import add_event

TOP = 2.0


def make_patch_scene(scene: bpy.types.Scene, resolution: float = 2.0, hook: bool = True) -> bpy.types.Scene:
    """Fills an empty scene, in mm. The hook's target is the empty "target", without keyframes."""
    scene.unit_settings.scale_length = 0.001
    scene.frame_start, scene.frame_end = 1, 8
    scene.frame_set(1)
    scene.lappet.materials.add().name = "skin"
    put_tissue(scene, flat_patch((24.0, 16.0, TOP), resolution=resolution, spacing=1.0))
    add_event(scene, "INCISION", start=3, points=[(-6, 0, TOP), (6, 0, TOP)], kerf=0.1)
    if hook:
        empty = bpy.data.objects.new("target", None)
        scene.collection.objects.link(empty)
        empty.location = (0.0, 3.0, TOP + 1.0)
        add_event(scene, "HOOK", start=4, end=8, points=[(0, 2, TOP)], target=empty, stiffness=100.0)
    return scene


def put_tissue(scene: bpy.types.Scene, tissue: Tissue) -> bpy.types.Object:
    """A mesh object of these values, with groups as face attributes, as the scene's tissue."""
    faces = np.split(tissue.face_vertex_indices, np.cumsum(tissue.face_vertex_counts)[:-1])
    mesh = bpy.data.meshes.new("skin")
    mesh.from_pydata(tissue.points.tolist(), [], [face.tolist() for face in faces])
    for name, subset in tissue.subsets.items():
        chosen = np.zeros(len(faces), bool)
        chosen[subset] = True
        mesh.attributes.new(f"lappet_{name}", "BOOLEAN", "FACE").data.foreach_set("value", chosen)
    obj = bpy.data.objects.new("skin", mesh)
    scene.collection.objects.link(obj)
    scene.lappet.tissue.object = obj
    return obj
