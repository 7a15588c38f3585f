"""The panel "Materials": what the tissue and its regions are made of, with the source of every preset's numbers."""

import bpy

from lappet.tissue.presets import PRESETS

from ..interface.sentence_lines import draw_sentence
from ..interface.sidebar_panel import CLOSED, SidebarPanel, draw_presets, with_fields
from .tissue_operators import PRESET_ITEMS


class LAPPET_UL_materials(bpy.types.UIList):
    """Materials"""

    def draw_item(self, context, layout, _data, item, _icon, _active_data, _active_property, _index=0, _flag=0):  # type: ignore[no-untyped-def]
        used = context.scene.lappet.tissue.material == item.name
        layout.label(text=item.name, icon="MATERIAL" if used else "DOT")
        layout.label(text=f"{item.youngs_modulus:.4g} kPa")


class LAPPET_MT_presets(bpy.types.Menu):
    """Give the material the values of a preset"""

    bl_label = "Preset"

    def draw(self, context: bpy.types.Context) -> None:
        procedure = context.scene.lappet
        material = procedure.materials[procedure.active_material]
        for key, label, _ in PRESET_ITEMS:
            button = self.layout.operator("lappet.material_preset", text=label)
            button.name, button.preset = material.name, key


class LAPPET_PT_materials(SidebarPanel, bpy.types.Panel):
    """What the tissue is made of"""

    bl_label = "Materials"
    bl_order = 12
    bl_options = CLOSED

    def draw_header_preset(self, _context: bpy.types.Context) -> None:
        """The user's own presets."""
        draw_presets(self.layout, "LAPPET_PT_skin_presets")

    def draw(self, context: bpy.types.Context) -> None:
        layout, procedure = with_fields(self.layout), context.scene.lappet
        layout.prop_search(procedure.tissue, "material", procedure, "materials", text="Tissue", icon="MATERIAL")
        row = layout.row()
        row.template_list("LAPPET_UL_materials", "", procedure, "materials", procedure, "active_material", rows=3)
        side = row.column(align=True)
        side.operator_menu_enum("lappet.material_add", "preset", text="", icon="ADD")
        if 0 <= procedure.active_material < len(procedure.materials):
            material = procedure.materials[procedure.active_material]
            side.operator("lappet.material_remove", text="", icon="REMOVE").name = material.name
            side.operator("lappet.material_rename", text="", icon="GREASEPENCIL").name = material.name
            _material(layout, context, material)
        _regions(layout, procedure)


def _material(layout: bpy.types.UILayout, context: bpy.types.Context, material: bpy.types.PropertyGroup) -> None:
    layout.menu("LAPPET_MT_presets", icon="PRESET")
    column = layout.column(align=True)
    for name in ("model", "youngs_modulus", "poissons_ratio", "density"):
        column.prop(material, name)
    if material.model == "mooneyRivlin":
        column.prop(material, "mooney_ratio")
    column = layout.column(align=True)
    column.prop(material, "fiber_k1")
    if material.fiber_k1 > 0.0:
        column.prop(material, "fiber_k2")
        column.prop(material, "fiber_dispersion")
        column.prop(material, "fiber_slack")
    column.prop(material, "muscle_stress")
    if material.muscle_stress > 0.0:
        row = column.row()
        row.use_property_decorate = True
        row.prop(material, "activation", slider=True)
    if material.fiber_k1 > 0.0 or material.muscle_stress > 0.0:
        column.prop(material, "fiber_angle")
    column.prop(material, "prestretch")
    column.prop(material, "fiber_direction")
    preset = PRESETS.get(material.name)
    if preset is not None:
        name = preset.material.name.capitalize().replace("_", " ")
        draw_sentence(layout.box(), context, f"{name} as preset: {preset.source}")


def _regions(layout: bpy.types.UILayout, procedure: bpy.types.PropertyGroup) -> None:
    layout.label(text="Regions")
    for region in procedure.regions:
        box = layout.box()
        row = box.row(align=True)
        row.label(text=region.name, icon="FACESEL")
        row.operator("lappet.region_remove", text="", icon="X").group = region.name
        box.prop_search(region, "material", procedure, "materials", icon="MATERIAL")
        column = box.column(align=True)
        column.prop(region, "depth_from")
        column.prop(region, "to_bottom")
        if not region.to_bottom:
            column.prop(region, "depth_to")
    layout.operator("lappet.region_add", text="Add Region", icon="ADD")


CLASSES = (LAPPET_UL_materials, LAPPET_MT_presets, LAPPET_PT_materials)
