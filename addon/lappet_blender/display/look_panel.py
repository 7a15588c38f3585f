"""The panels Look and Compare."""

import bpy

from ..interface.said import said
from ..interface.sidebar_panel import CLOSED, SidebarPanel, draw_presets
from .look_materials import quantity_of


class LAPPET_PT_look(SidebarPanel, bpy.types.Panel):
    """How the solved skin is shown."""

    bl_label = "Look"
    bl_order = 40
    bl_options = CLOSED

    def draw_header_preset(self, _context: bpy.types.Context) -> None:
        """The user's own presets."""
        draw_presets(self.layout, "LAPPET_PT_look_presets")

    def draw(self, context: bpy.types.Context) -> None:
        """Color, parts, stage."""
        layout, scene = self.layout, context.scene
        look = scene.lappet.look
        layout.operator_menu_enum("lappet.look_preset", "preset", text="Preset")
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(look, "show_solved")
        layout.prop(look, "color")
        parts = layout.column(heading="Show")
        parts.active = look.show_solved
        for name in ("show_walls", "show_sutures", "show_hooks", "show_landmarks", "show_plan"):
            parts.prop(look, name)
        if scene.lappet.vessels:
            parts.prop(look, "show_vessels")
            parts.prop(look, "show_through")
        if scene.lappet.bones:
            parts.prop(look, "show_bone")
        if quantity_of(look) is not None:
            parts.prop(look, "show_legend")
        row = layout.row(align=True)
        row.operator("lappet.set_stage", icon="CAMERA_DATA")
        row.operator("lappet.clear_stage", text="", icon="X")


class LAPPET_PT_compare(SidebarPanel, bpy.types.Panel):
    """Two procedures side by side."""

    bl_label = "Compare"
    bl_order = 50
    bl_options = CLOSED

    def draw(self, context: bpy.types.Context) -> None:
        """The other scene, the gap, and a new variant."""
        layout, lappet = self.layout, context.scene.lappet
        layout.operator("lappet.variant_new", icon="DUPLICATE")
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(lappet, "compare_with")
        other = lappet.compare_with
        if other is None:
            return
        layout.prop(lappet, "compare_gap")
        if other == context.scene:
            layout.label(text="A scene cannot be compared with itself", icon="ERROR")
        elif other.lappet.tissue.object is None:
            layout.label(text=said("{name} has no tissue", name=other.name), icon="ERROR")


CLASSES = (LAPPET_PT_look, LAPPET_PT_compare)
