"""Register the property groups and hang them on scenes."""

from __future__ import annotations

import bpy

from . import event_properties, procedure_properties

_CLASSES = (*event_properties.CLASSES, *procedure_properties.CLASSES)


def register() -> None:
    """Add `scene.lappet`."""
    for each in _CLASSES:
        bpy.utils.register_class(each)
    bpy.types.Scene.lappet = bpy.props.PointerProperty(type=procedure_properties.LappetProcedure)


def unregister() -> None:
    """Take `scene.lappet` away; what scenes hold stays in the file."""
    del bpy.types.Scene.lappet
    for each in reversed(_CLASSES):
        bpy.utils.unregister_class(each)
