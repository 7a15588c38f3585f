"""Register the tools, their operators, the menu and the overlay."""

from __future__ import annotations

import bpy
from bpy.app.handlers import persistent

from . import (
    click_tool,
    edit_tool,
    flap_edit_tool,
    flap_gizmos,
    hook_tool,
    incision_tool,
    plan_overlay,
    suture_tool,
    tool_menu,
    toolbar,
)
from .preview import clear_preview
from .shown_surface import clear_cache
from .skin_modal import end_running

CLASSES = (
    *incision_tool.CLASSES,
    *click_tool.CLASSES,
    *hook_tool.CLASSES,
    *suture_tool.CLASSES,
    *edit_tool.CLASSES,
    *flap_edit_tool.CLASSES,
    *flap_gizmos.CLASSES,
    *tool_menu.CLASSES,
    *toolbar.CLASSES,
)


@persistent  # type: ignore[untyped-decorator]
def _another_file(_path: str) -> None:
    """What is kept or shown belongs to the file that is closed."""
    clear_preview()
    clear_cache()
    flap_gizmos.forget()


def register() -> None:
    """Add the tools to the toolbar and the menu to the 3D viewport's header."""
    toolbar.register()
    tool_menu.register()
    plan_overlay.register()
    bpy.app.handlers.load_pre.append(_another_file)


def unregister() -> None:
    """Take everything away again; what runs ends first, while what it shows can still be taken back."""
    end_running()
    if _another_file in bpy.app.handlers.load_pre:
        bpy.app.handlers.load_pre.remove(_another_file)
    plan_overlay.unregister()
    tool_menu.unregister()
    toolbar.unregister()
    clear_preview()
    clear_cache()
    flap_gizmos.forget()
