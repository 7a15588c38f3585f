"""Where plates, films and exports are in Blender's menus: Render > Lappet and File > Export > Lappet."""

from __future__ import annotations

from typing import Any

import bpy

from lappet.export.formats import EXPORTERS


class LAPPET_MT_export(bpy.types.Menu):
    """The formats of the solved frames."""

    bl_label = "Lappet"

    def draw(self, _context: bpy.types.Context) -> None:
        self.layout.operator_context = "INVOKE_DEFAULT"
        for each in EXPORTERS:
            short = each.what.partition(":")[0].partition(",")[0]
            entry = self.layout.operator("lappet.export_result", text=f"{short[0].upper()}{short[1:]} ({each.suffix})")
            entry.suffix = each.suffix


class LAPPET_MT_render(bpy.types.Menu):
    """What is drawn of the solved frames."""

    bl_label = "Lappet"

    def draw(self, _context: bpy.types.Context) -> None:
        self.layout.operator_context = "INVOKE_DEFAULT"
        self.layout.operator("lappet.plate_write", text="Write Plate…", icon="IMAGE_DATA")
        self.layout.operator("lappet.film_write", text="Write Film…", icon="RENDER_ANIMATION")


def _export_entry(menu: Any, _context: bpy.types.Context) -> None:
    menu.layout.menu("LAPPET_MT_export", text="Lappet")


def _render_entry(menu: Any, _context: bpy.types.Context) -> None:
    menu.layout.separator()
    menu.layout.menu("LAPPET_MT_render", text="Lappet")


def register() -> None:
    """Add the entries."""
    bpy.types.TOPBAR_MT_file_export.append(_export_entry)
    bpy.types.TOPBAR_MT_render.append(_render_entry)


def unregister() -> None:
    """Take them away."""
    bpy.types.TOPBAR_MT_render.remove(_render_entry)
    bpy.types.TOPBAR_MT_file_export.remove(_export_entry)


CLASSES = (LAPPET_MT_export, LAPPET_MT_render)
