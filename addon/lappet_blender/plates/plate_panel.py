"""The panel *Plate*: the page, its panels and the annotations of the chosen one, and what is being written."""

from __future__ import annotations

from typing import Any

import bpy

from ..interface.said import said
from ..interface.sentence_lines import draw_sentence
from ..interface.sidebar_panel import CLOSED, SidebarPanel, draw_presets, with_fields
from ..model.plate_names import active_annotation, active_panel, active_plate
from .output_jobs import last_job, state_line

_KINDS = {
    "label": "FONT_DATA",
    "length": "DRIVER_DISTANCE",
    "distance": "ARROW_LEFTRIGHT",
    "angle": "DRIVER_ROTATIONAL_DIFFERENCE",
    "arrow": "FORWARD",
    "pivot": "PIVOT_CURSOR",
}
_SHOWN = (("labels", "letters", "arrows"), ("measures", "instruments", "skin_lines"), ("hatched",))


class LAPPET_UL_plate_panels(bpy.types.UIList):
    """The panels of a plate."""

    def draw_item(
        self,
        _context: Any,
        layout: Any,
        _data: Any,
        item: Any,
        _icon: int,
        _active_data: Any,
        _active_property: str,
        _index: int = 0,
        _flag: int = 0,
    ) -> None:
        row = layout.row(align=True)
        row.prop(item, "title", text="", emboss=False, icon="IMAGE_PLANE" if not item.inset_of else "ZOOM_IN")
        if item.step == "FRAME":
            row.label(text=said("frame {frame}", frame=f"{item.time:g}"))
        elif item.step != item.name:  # a panel is called after its step until it is renamed
            row.label(text=item.step)


class LAPPET_UL_plate_annotations(bpy.types.UIList):
    """The annotations of a plate, and whether they stand on the chosen panel."""

    def draw_item(
        self,
        _context: Any,
        layout: Any,
        _data: Any,
        item: Any,
        _icon: int,
        _active_data: Any,
        _active_property: str,
        _index: int = 0,
        _flag: int = 0,
    ) -> None:
        row = layout.row(align=True)
        row.active = item.enabled
        row.prop(item, "shown", text="")
        row.prop(item, "title", text="", emboss=False, icon=_KINDS[item.kind])
        row.prop(item, "text", text="", emboss=False)


class LAPPET_MT_plate_add(bpy.types.Menu):
    """Add a plate from a template."""

    bl_label = "Add Plate"

    def draw(self, _context: bpy.types.Context) -> None:
        self.layout.operator_enum("lappet.plate_add", "template")


class LAPPET_MT_plate_panel_add(bpy.types.Menu):
    """Add a panel."""

    bl_label = "Add Panel"

    def draw(self, _context: bpy.types.Context) -> None:
        self.layout.operator_enum("lappet.plate_panel_add", "step")


class LAPPET_MT_annotation_add(bpy.types.Menu):
    """Add an annotation."""

    bl_label = "Add Annotation"

    def draw(self, _context: bpy.types.Context) -> None:
        self.layout.operator_context = "INVOKE_DEFAULT"
        for kind, icon in _KINDS.items():
            self.layout.operator("lappet.annotation_add", text=kind.capitalize(), icon=icon).kind = kind


class LAPPET_PT_plate(SidebarPanel, bpy.types.Panel):
    """A page for print."""

    bl_label = "Plate"
    bl_order = 50
    bl_options = CLOSED

    def draw_header_preset(self, _context: bpy.types.Context) -> None:
        """The user's own presets."""
        draw_presets(self.layout, "LAPPET_PT_plate_presets")

    def draw(self, context: bpy.types.Context) -> None:
        layout, data = self.layout, context.scene.lappet
        row = layout.row()
        row.template_list("UI_UL_list", "lappet_pages", data, "pages", data, "active_page", rows=2)
        side = row.column(align=True)
        side.menu("LAPPET_MT_plate_add", text="", icon="ADD")
        side.operator("lappet.plate_remove", text="", icon="REMOVE")
        plate = active_plate(context.scene)
        if plate is None:
            draw_sentence(layout, context, "Add a plate: a page for print of the operation.", "INFO")
            return
        fields = with_fields(layout.column())
        for name in ("title", "style", "view", "language"):
            fields.prop(plate, name)
        flags = layout.column(align=True)
        for names in _SHOWN:
            row = flags.row(align=True)
            for name in names:
                row.prop(plate, name, toggle=True)


class LAPPET_PT_plate_page(SidebarPanel, bpy.types.Panel):
    """What seldom changes: size, publisher, maps, marks, sections."""

    bl_label = "Page"
    bl_parent_id = "LAPPET_PT_plate"
    bl_options = CLOSED

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return active_plate(context.scene) is not None

    def draw(self, context: bpy.types.Context) -> None:
        plate = active_plate(context.scene)
        if plate is None:
            return
        fields = with_fields(self.layout.column())
        for name in ("tone", "width", "columns", "text", "journal", "quantity", "plan_pen", "marks"):
            fields.prop(plate, name)
        if plate.marks != "NONE":
            fields.prop(plate, "marks_spacing")
        fields.prop(plate, "sectioned")
        if plate.sectioned:
            fields.prop(plate, "section_at")
            fields.prop(plate, "section_normal")


class LAPPET_PT_plate_panels(SidebarPanel, bpy.types.Panel):
    """The panels of the plate."""

    bl_label = "Panels"
    bl_parent_id = "LAPPET_PT_plate"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return active_plate(context.scene) is not None

    def draw(self, context: bpy.types.Context) -> None:
        layout, plate = self.layout, active_plate(context.scene)
        if plate is None:
            return
        _list(layout, plate, "panels", "active_panel", "LAPPET_MT_plate_panel_add")
        panel = active_panel(context.scene)
        if panel is None:
            draw_sentence(layout, context, "Without panels the plate shows the steps of the operation.", "INFO")
            return
        row = layout.row(align=True)
        row.operator("lappet.plate_panel_from_view", icon="VIEW_CAMERA")
        row.operator("lappet.plate_panel_look", icon="HIDE_OFF")
        row.prop(context.scene.lappet, "show_page", text="", icon="OVERLAY")
        fields = with_fields(layout.column())
        fields.prop(panel, "step")
        if panel.step == "FRAME":
            fields.prop(panel, "time")
        for name in ("caption", "view", "ghost"):
            fields.prop(panel, name)
        if panel.ghost != "NONE":
            fields.prop(panel, "ghost_filled")
        fields.prop_search(panel, "inset_of", plate, "panels")
        fields.prop(panel, "cropped")
        if panel.cropped:
            fields.prop(panel, "at")
            fields.prop(panel, "across")
        fields.prop(panel, "sectioned")
        if panel.sectioned:
            fields.prop(panel, "section_at")
            fields.prop(panel, "section_normal")


class LAPPET_PT_plate_annotations(SidebarPanel, bpy.types.Panel):
    """What is written and drawn on the plate."""

    bl_label = "Annotations"
    bl_parent_id = "LAPPET_PT_plate"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return active_plate(context.scene) is not None

    def draw(self, context: bpy.types.Context) -> None:
        layout, plate = self.layout, active_plate(context.scene)
        if plate is None:
            return
        _list(layout, plate, "annotations", "active_annotation", "LAPPET_MT_annotation_add")
        layout.operator_context = "INVOKE_DEFAULT"
        layout.operator("lappet.annotation_drag", icon="VIEW_PAN")
        note = active_annotation(context.scene)
        if note is None:
            return
        fields = with_fields(layout.column())
        for name in ("kind", "text", "when_excised", "placed"):
            fields.prop(note, name)
        if note.placed:
            fields.prop(note, "offset")


class LAPPET_PT_plate_output(SidebarPanel, bpy.types.Panel):
    """Write the plate, and a film."""

    bl_label = "Output"
    bl_parent_id = "LAPPET_PT_plate"

    def draw(self, context: bpy.types.Context) -> None:
        layout, job = self.layout, last_job()
        layout.operator_context = "INVOKE_DEFAULT"
        row = layout.row(align=True)
        if job is not None and job.running:
            row.operator("lappet.output_cancel", icon="CANCEL")
        else:
            row.operator("lappet.plate_write", text="Write Plate…", icon="IMAGE_DATA")
            row.operator("lappet.film_write", text="Write Film…", icon="RENDER_ANIMATION")
        line = state_line()
        if line:
            failed = job is not None and job.state == "failed"
            draw_sentence(layout, context, line, "ERROR" if failed else "INFO")


def _list(layout: Any, plate: Any, items: str, active: str, menu: str) -> None:
    """A list with its buttons."""
    row = layout.row()
    row.template_list(f"LAPPET_UL_plate_{items}", "", plate, items, plate, active, rows=4)
    side = row.column(align=True)
    side.menu(menu, text="", icon="ADD")
    side.operator("lappet.plate_item_remove", text="", icon="REMOVE").which = items
    side.separator()
    for icon, by in (("TRIA_UP", -1), ("TRIA_DOWN", 1)):
        step = side.operator("lappet.plate_item_move", text="", icon=icon)
        step.which, step.by = items, by


CLASSES = (
    LAPPET_UL_plate_panels,
    LAPPET_UL_plate_annotations,
    LAPPET_MT_plate_add,
    LAPPET_MT_plate_panel_add,
    LAPPET_MT_annotation_add,
    LAPPET_PT_plate,
    LAPPET_PT_plate_page,
    LAPPET_PT_plate_panels,
    LAPPET_PT_plate_annotations,
    LAPPET_PT_plate_output,
)
