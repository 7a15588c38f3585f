"""Register this part of the add-on."""

from __future__ import annotations

from . import display_operators, look_panel, skin_handlers

CLASSES = (*display_operators.CLASSES, *look_panel.CLASSES)


def register() -> None:
    """Add operators, panels and handlers."""
    skin_handlers.register()


def unregister() -> None:
    """Take them away."""
    skin_handlers.unregister()
