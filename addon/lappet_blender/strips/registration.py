"""Register the strips, their operators, keys and menu."""

from __future__ import annotations

from . import area_edge, strip_keys, strip_modal, strip_operators, strip_overlay

CLASSES = (*strip_modal.CLASSES, *strip_operators.CLASSES, *strip_keys.CLASSES)


def register() -> None:
    """Draw strips, and add keys and the menu."""
    strip_overlay.register()
    strip_keys.register()


def unregister() -> None:
    """Take them away; a drag that runs ends first."""
    area_edge.stop()
    strip_modal.end_running()
    strip_keys.unregister()
    strip_overlay.unregister()
