"""Registers this part of the add-on."""

from __future__ import annotations

import bpy

from . import controller, live_operator, pump, scene_watch, solve_operators, solve_panel

_CLASSES = (*solve_operators.CLASSES, *live_operator.CLASSES, *solve_panel.CLASSES)


def register() -> None:
    """Adds operators, panels, handlers and the timer."""
    for each in _CLASSES:
        bpy.utils.register_class(each)
    scene_watch.register()
    pump.register()


def unregister() -> None:
    """Takes them away again and ends every worker."""
    pump.unregister()
    scene_watch.unregister()
    controller.shelf.close()
    for each in reversed(_CLASSES):
        bpy.utils.unregister_class(each)
