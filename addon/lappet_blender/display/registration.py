"""Register this part of the add-on."""

from __future__ import annotations

import bpy

from . import display_operators, look_panel, skin_handlers

_CLASSES = (*display_operators.CLASSES, *look_panel.CLASSES)


def register() -> None:
    """Add operators, panels and handlers."""
    for each in _CLASSES:
        bpy.utils.register_class(each)
    skin_handlers.register()


def unregister() -> None:
    """Take them away."""
    skin_handlers.unregister()
    for each in reversed(_CLASSES):
        bpy.utils.unregister_class(each)
