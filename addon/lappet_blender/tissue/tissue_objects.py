"""The objects that operators work on: the tissue, its mesh, and objects by name."""

from __future__ import annotations

import bpy

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode


def tissue_object(scene: bpy.types.Scene) -> bpy.types.Object:
    """The scene's tissue. Raises RefusedError where it has none to work on."""
    obj = scene.lappet.tissue.object
    if obj is None:
        raise refused(ProblemCode.TISSUE_NONE)
    if obj.type != "MESH":
        raise refused(ProblemCode.OBJECT_NOT_A_MESH, obj.name, obj.type.lower(), role="tissue")
    return obj


def changeable_mesh(obj: bpy.types.Object) -> bpy.types.Mesh:
    """The object's mesh. Raises RefusedError where it is linked from a library."""
    library = obj.library or obj.data.library
    if library is not None:
        raise refused(ProblemCode.OBJECT_LINKED, obj.name, library.filepath, role="object")
    return obj.data


def named_object(context: bpy.types.Context, name: str) -> bpy.types.Object:
    """The object of that name in the scene, or the active one for "". Raises RefusedError where there is none."""
    if name:
        obj = context.scene.objects.get(name)
        if obj is None:
            raise refused(ProblemCode.OBJECT_UNKNOWN, "", name)
        return obj
    obj = context.view_layer.objects.active
    if obj is None:
        raise refused(ProblemCode.OBJECT_NONE_ACTIVE)
    return obj
