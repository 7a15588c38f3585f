"""Scenery: between the scene's objects and the procedure's values.

An object is scenery where it has the property `lappet_scenery`, which says of what kind.
"""

from __future__ import annotations

import bpy
import numpy as np
from numpy.typing import NDArray

from lappet.drawing.surface_look import SKIN_LOOK
from lappet.procedure import SCENERY_KINDS, Procedure, Scenery

from .mesh_objects import mesh_object
from .mesh_values import mesh_values
from .tissue_values import identifier

PROPERTY = "lappet_scenery"
_COLORS = {
    "skin": (*SKIN_LOOK.color, 1.0),  # that of the tissue among it
    "eye": (0.86, 0.85, 0.83, 1.0),
    "iris": (0.13, 0.19, 0.22, 1.0),
    "pupil": (0.01, 0.01, 0.012, 1.0),
    "teeth": (0.80, 0.76, 0.66, 1.0),
}


def make_scenery(
    scene: bpy.types.Scene, collection: bpy.types.Collection, procedure: Procedure
) -> list[bpy.types.Object]:
    """Make the objects of a procedure's scenery, which cannot be selected; they count once `claim_scenery` has them.

    Raises RefusedError for meshes that Blender cannot hold, having made none.
    """
    made: list[bpy.types.Object] = []
    try:
        for each in procedure.scenery:
            mesh = (each.points, each.face_vertex_counts, each.face_vertex_indices)
            obj = mesh_object(scene, collection, each.name, *mesh)
            made.append(obj)
            obj.data.shade_smooth()
            obj.data.materials.append(_material(each.kind))
            obj.hide_select = True
    except BaseException:
        for obj in made:
            bpy.data.meshes.remove(obj.data)
        raise
    return made


def claim_scenery(scene: bpy.types.Scene, procedure: Procedure, objects: list[bpy.types.Object]) -> None:
    """Make objects the scenery of the scene, in place of those that were."""
    for obj in scene.objects:
        if PROPERTY in obj:
            del obj[PROPERTY]
    for obj, each in zip(objects, procedure.scenery, strict=True):
        obj[PROPERTY] = each.kind


def scenery_values(scene: bpy.types.Scene) -> tuple[Scenery, ...]:
    """The scene's scenery in the order of its objects; what is no mesh, or of no known kind, is left out."""
    found: list[Scenery] = []
    names: set[str] = set()
    for obj in scene.objects:
        kind = obj.get(PROPERTY)
        if obj.type != "MESH" or kind not in SCENERY_KINDS:
            continue
        mesh, name = mesh_values(scene, obj), identifier(obj.name, names)
        names.add(name)
        found.append(Scenery(name, mesh.points, mesh.counts, mesh.indices, kind))
    return tuple(found)


def scenery_points(scene: bpy.types.Scene) -> list[NDArray[np.float64]]:
    """The vertices in mm, shape (n, 3), of each object of the scenery that a render shows."""
    shown = [obj for obj in scene.objects if obj.type == "MESH" and PROPERTY in obj and not obj.hide_render]
    return [points for obj in shown if len(points := np.asarray(mesh_values(scene, obj).points, np.float64))]


def _material(kind: str) -> bpy.types.Material:
    """The material of a kind of scenery, made once for a file."""
    name = f"Lappet {kind}"
    material = bpy.data.materials.get(name)
    if material is None:
        material = bpy.data.materials.new(name)
        if not material.use_nodes:
            material.use_nodes = True
        material.diffuse_color = _COLORS[kind]
        bsdf = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
        bsdf.inputs["Base Color"].default_value = _COLORS[kind]
        bsdf.inputs["Roughness"].default_value = SKIN_LOOK.roughness if kind == "skin" else 0.2
    return material
