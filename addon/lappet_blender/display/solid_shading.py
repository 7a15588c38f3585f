"""Solid viewports and Workbench show the chosen color of the skin: their shading is set when it is chosen."""

from __future__ import annotations

import bpy

from .look_materials import quantity_of

_CHOSEN = "lappet_color"


def shading_for(look: bpy.types.PropertyGroup) -> str:
    """The `color_type` of Solid shading in which a look can be read."""
    if quantity_of(look) is not None:
        return "VERTEX"
    return "TEXTURE" if look.color in ("GRID", "CHECKER") else "MATERIAL"


def suit_shading(scene: bpy.types.Scene, collection: bpy.types.Collection | None) -> None:
    """Set the shading of this scene's Solid viewports and of Workbench, once for each choice of color."""
    look = scene.lappet.look
    if collection is None or collection.hide_viewport or collection.get(_CHOSEN) == look.color:
        return
    collection[_CHOSEN] = look.color
    wanted = shading_for(look)
    scene.display.shading.color_type = wanted
    manager = bpy.context.window_manager
    for window in manager.windows if manager else ():
        if window.scene != scene:
            continue
        for area in window.screen.areas:
            for space in area.spaces:
                if space.type == "VIEW_3D":
                    space.shading.color_type = wanted
