"""Register the panel *Plate*, its operators, the preview and the menus."""

from __future__ import annotations

from ..tools.skin_modal import end_running
from . import annotation_tools, output_jobs, output_menus, output_operators, plate_operators, plate_overlay, plate_panel

CLASSES = (
    *plate_operators.CLASSES,
    *annotation_tools.CLASSES,
    *output_operators.CLASSES,
    *output_menus.CLASSES,
    *plate_panel.CLASSES,
)


def register() -> None:
    """Add the preview and the menu entries."""
    plate_overlay.register()
    output_menus.register()


def unregister() -> None:
    """Take them away; what is being written ends first, and a tool that runs before its class goes."""
    output_jobs.stop()
    end_running()
    output_menus.unregister()
    plate_overlay.unregister()
