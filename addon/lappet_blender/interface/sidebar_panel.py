"""The base of Lappet's panels."""

from __future__ import annotations

from typing import Any

CLOSED = {"DEFAULT_CLOSED"}


class SidebarPanel:
    """Mixin of a panel in the tab "Lappet" of the 3D viewport's sidebar."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Lappet"
    bl_translation_context = "Lappet"  # Blender's own words mean something else: to solve, in tracking


def with_fields(layout: Any) -> Any:
    """Have a layout show the names of properties beside their fields, and return it."""
    layout.use_property_split = True
    layout.use_property_decorate = False
    return layout


def draw_presets(layout: Any, panel: str) -> None:
    """A button that opens the user's own presets: `panel` is the name of their panel (start/own_presets.py)."""
    row = layout.row()
    row.emboss = "NONE"
    row.popover(panel, icon="PRESET", text="")
