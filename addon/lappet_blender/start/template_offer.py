"""A button in the empty panel Tissue that adds the template, until it is there.

The template lies in the user's scripts, outside of the extension's own folder, where an extension writes when asked.
"""

from __future__ import annotations

from typing import Any

import bpy

from .template_files import is_written


def draw_offer(panel: Any, context: bpy.types.Context) -> None:
    """Draw the button where the scene has no tissue yet."""
    if context.scene.lappet.tissue.object is None and not is_written():
        panel.layout.separator()
        panel.layout.operator("lappet.template_install", icon="FILE_NEW")


def register() -> None:
    """Hang it into the panel."""
    bpy.types.LAPPET_PT_tissue.append(draw_offer)


def unregister() -> None:
    """Take it out."""
    bpy.types.LAPPET_PT_tissue.remove(draw_offer)
