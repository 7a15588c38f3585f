"""The objects that operators work on: the tissue, its mesh, and objects by name."""

from __future__ import annotations

import bpy

from lappet.core.problem import RefusedError


def tissue_object(scene: bpy.types.Scene) -> bpy.types.Object:
    """The scene's tissue. Raises RefusedError where it has none to work on."""
    obj = scene.lappet.tissue.object
    if obj is None:
        raise RefusedError("The scene has no tissue; select a mesh and press Make Tissue.")
    if obj.type != "MESH":
        raise RefusedError(f"The tissue {obj.name!r} is a {obj.type.lower()}; choose a mesh.")
    return obj


def changeable_mesh(obj: bpy.types.Object) -> bpy.types.Mesh:
    """The object's mesh. Raises RefusedError where it is linked from a library."""
    library = obj.library or obj.data.library
    if library is not None:
        raise RefusedError(f"The mesh of {obj.name!r} is linked from {library.filepath!r}; make it local first.")
    return obj.data


def named_object(context: bpy.types.Context, name: str) -> bpy.types.Object:
    """The object of that name in the scene, or the active one for "". Raises RefusedError where there is none."""
    if name:
        obj = context.scene.objects.get(name)
        if obj is None:
            raise RefusedError(f"There is no object {name!r} in the scene; give the name of one that is.")
        return obj
    obj = context.view_layer.objects.active
    if obj is None:
        raise RefusedError("No object is active; select one, or give its name.")
    return obj
