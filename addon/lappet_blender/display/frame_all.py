"""The key Home where a stage is set: it frames what is operated on, and not the paper behind it.

The paper of a stage goes on to the horizon of a low camera. Blender's own Frame All holds all of it and then clips it
away, so that nothing is seen.
"""

from __future__ import annotations

from typing import Any

import bpy

from ..interface.operator_base import NO_UNDO, OperatorBase
from .display_collection import STAGE_OWNER, has_figure_setup

_KEYMAP, _SPACE, _KEY = "3D View", "VIEW_3D", "HOME"
_made: list[tuple[Any, Any]] = []


def off_stage(scene: bpy.types.Scene, layer: bpy.types.ViewLayer) -> list[bpy.types.Object]:
    """The objects of the scene's stage that the view layer shows, which framing leaves out."""
    stages = [child for child in scene.collection.children if child.get(STAGE_OWNER) == scene]
    return [obj for stage in stages for obj in stage.objects if obj.visible_get(view_layer=layer)]


class LAPPET_OT_frame_all(OperatorBase, bpy.types.Operator):
    """Frame everything that is shown but the camera, lights and paper of the stage"""

    bl_label = "Frame Without Stage"
    bl_options = NO_UNDO

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """A view that does not look through a camera, of a scene with a stage; anywhere else Home is Blender's."""
        space = context.space_data
        if space is None or space.type != "VIEW_3D" or context.region is None or context.region.type != "WINDOW":
            return False
        if space.region_3d is None or space.region_3d.view_perspective == "CAMERA":
            return False
        return context.scene is not None and has_figure_setup(context.scene)

    def run(self, context: bpy.types.Context) -> None:
        hidden = off_stage(context.scene, context.view_layer)
        for obj in hidden:
            obj.hide_set(True)
        try:
            bpy.ops.view3d.view_all(center=False)
        finally:
            for obj in hidden:
                obj.hide_set(False)


CLASSES = (LAPPET_OT_frame_all,)


def register() -> None:
    """Add the key."""
    manager = bpy.context.window_manager
    configuration = manager.keyconfigs.addon if manager is not None else None
    if configuration is None or _made:
        return  # without windows there are no keys
    keymap = configuration.keymaps.new(name=_KEYMAP, space_type=_SPACE)
    _made.append((keymap, keymap.keymap_items.new(LAPPET_OT_frame_all.bl_idname, _KEY, "PRESS")))


def unregister() -> None:
    """Take the key away."""
    for keymap, item in _made:
        keymap.keymap_items.remove(item)
    _made.clear()
