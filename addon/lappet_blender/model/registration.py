"""Register the property groups and hang them on scenes."""

from __future__ import annotations

import bpy

from . import event_properties, plate_properties, procedure_properties

CLASSES = (*event_properties.CLASSES, *plate_properties.CLASSES, *procedure_properties.CLASSES)


def register() -> None:
    """Add `scene.lappet`."""
    bpy.types.Scene.lappet = bpy.props.PointerProperty(type=procedure_properties.LappetProcedure)


def unregister() -> None:
    """Take `scene.lappet` away; what scenes hold stays in the file."""
    del bpy.types.Scene.lappet
