"""Tells that the procedure may have changed when the meshes of tissue or bones are edited or moved."""

from __future__ import annotations

import bpy
from bpy.app.handlers import persistent

from ..model.changes import changed


@persistent  # type: ignore[untyped-decorator]
def on_depsgraph_update(_scene: bpy.types.Scene, graph: bpy.types.Depsgraph) -> None:
    """Every scene whose tissue or bones the update is about; other updates cost next to nothing."""
    touched = {
        update.id.original
        for update in graph.updates
        if (update.is_updated_geometry or update.is_updated_transform)
        and isinstance(update.id, (bpy.types.Object, bpy.types.Mesh))
    }
    if not touched:
        return
    for scene in bpy.data.scenes:
        if scene.lappet.version and any(obj in touched or obj.data in touched for obj in _own(scene)):
            changed(scene)


def _own(scene: bpy.types.Scene) -> list[bpy.types.Object]:
    every = [scene.lappet.tissue.object, *(bone.object for bone in scene.lappet.bones)]
    return [obj for obj in every if obj is not None]


def register() -> None:
    """Listens from now on."""
    if on_depsgraph_update not in bpy.app.handlers.depsgraph_update_post:
        bpy.app.handlers.depsgraph_update_post.append(on_depsgraph_update)


def unregister() -> None:
    """Listens no more."""
    if on_depsgraph_update in bpy.app.handlers.depsgraph_update_post:
        bpy.app.handlers.depsgraph_update_post.remove(on_depsgraph_update)
