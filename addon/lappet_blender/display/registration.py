"""Register this part of the add-on."""

from __future__ import annotations

from . import display_operators, frame_all, look_panel, skin_handlers

CLASSES = (*display_operators.CLASSES, *frame_all.CLASSES, *look_panel.CLASSES)


def register() -> None:
    """Add operators, panels, handlers and a key."""
    skin_handlers.register()
    frame_all.register()


def unregister() -> None:
    """Take them away."""
    frame_all.unregister()
    skin_handlers.unregister()
