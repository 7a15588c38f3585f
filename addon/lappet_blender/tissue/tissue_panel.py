"""The panel "Tissue": what is operated on, how it is held, its lattice, and what is wrong with it."""

import bpy

from lappet.core.problem import Problem

from ..interface.duration_text import duration_text
from ..interface.repair_button import draw_repair
from ..interface.said import said
from ..interface.sentence_lines import draw_sentence
from ..interface.sidebar_panel import CLOSED, SidebarPanel, with_fields
from ..model.scene_procedure import SceneReading, read_scene
from ..model.tissue_values import tissue_is_ready
from .expected_time import cell_count, expected_seconds
from .face_groups import group_counts
from .tissue_check import last_check

_HELD = (("fixed", "LOCKED"), ("bed", "LINKED"))


class LAPPET_PT_tissue(SidebarPanel, bpy.types.Panel):
    """The tissue of the scene"""

    bl_label = "Tissue"
    bl_order = 10

    def draw(self, context: bpy.types.Context) -> None:
        layout, scene = with_fields(self.layout), context.scene
        settings = scene.lappet.tissue
        if settings.object is None:
            active = context.view_layer.objects.active if context.view_layer is not None else None
            is_mesh = active is not None and active.type == "MESH"
            draw_sentence(
                layout, context, "Select a mesh: closed, or the open surface of the skin." if not is_mesh else ""
            )
            label = (
                said("Make {name} the Tissue", name=active.name) if active is not None and is_mesh else "Make Tissue"
            )
            layout.operator("lappet.tissue_set", text=label)
            layout.operator("lappet.tissue_take_field", text="Take Skin Around 3D Cursor", icon="CURSOR")
            taken = layout.operator("lappet.tissue_take_field", text="Take Selected Skin", icon="FACESEL")
            taken.selection = True
            return
        row = layout.row(align=True)
        row.prop(settings, "object", text="Mesh")
        row.operator("lappet.tissue_clear", text="", icon="X")
        column = layout.column(align=True)
        column.prop(settings, "thicken")
        if settings.thicken:
            column.prop(settings, "thickness")
        if settings.object.type != "MESH":
            _problem(layout, context, read_scene(scene).problems[0])
            return
        _lattice(layout, scene)
        _problems(layout, context)


class _Part(SidebarPanel):
    """A part of the panel that may be folded away, where there is a tissue."""

    bl_parent_id = "LAPPET_PT_tissue"
    bl_options = CLOSED

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = context.scene.lappet.tissue.object
        return obj is not None and obj.type == "MESH"


class LAPPET_PT_tissue_faces(_Part, bpy.types.Panel):
    """Groups of faces: which are held, which lie on the bed, which retractors grip"""

    bl_label = "Faces"

    def draw(self, context: bpy.types.Context) -> None:
        _groups(self.layout, context.scene)


class LAPPET_PT_tissue_surroundings(_Part, bpy.types.Panel):
    """What the tissue lies on: bones, its bed, gravity"""

    bl_label = "Bones, Bed and Gravity"

    def draw(self, context: bpy.types.Context) -> None:
        layout, scene = with_fields(self.layout), context.scene
        settings = scene.lappet.tissue
        _bones(layout, scene)
        column = layout.column(align=True)
        column.prop(settings, "bed_stiffness")
        column.prop(settings, "bed_shear")
        row = column.row(heading="Gravity")
        row.prop(settings, "use_gravity", text="")
        sub = row.row()
        sub.active = settings.use_gravity
        sub.prop(settings, "gravity", text="")
        if settings.use_gravity:
            column.prop(settings, "position")
            if settings.position == "CUSTOM":
                column.prop(settings, "gravity_direction")


class LAPPET_PT_tissue_skin_lines(_Part, bpy.types.Panel):
    """Lines along which the fibers of the skin run and its tension is greatest"""

    bl_label = "Skin Lines"

    def draw(self, context: bpy.types.Context) -> None:
        layout = with_fields(self.layout)
        for line in context.scene.lappet.skin_lines:
            column = layout.column(align=True)
            row = column.row(align=True)
            row.prop(line, "use_tension", text=line.name)
            row.operator("lappet.skin_line_remove", text="", icon="X").name = line.name
            if line.use_tension:
                column.row(align=True).prop(line, "tension", text="")
        layout.operator("lappet.skin_lines_add", icon="CURVE_DATA")


class LAPPET_PT_tissue_vessels(_Part, bpy.types.Panel):
    """Vessels and nerves, which move with the tissue and are divided where incisions cross them"""

    bl_label = "Vessels"

    def draw(self, context: bpy.types.Context) -> None:
        layout = with_fields(self.layout)
        for vessel in context.scene.lappet.vessels:
            column = layout.column(align=True)
            row = column.row(align=True)
            row.prop(vessel, "kind", text=vessel.name)
            row.operator("lappet.vessel_remove", text="", icon="X").name = vessel.name
            column.prop(vessel, "label")
            column.prop(vessel, "radius")
            column.prop(vessel, "typical_course")
        layout.operator("lappet.vessels_add", icon="CURVE_DATA")


def _groups(layout: bpy.types.UILayout, scene: bpy.types.Scene) -> None:
    obj = scene.lappet.tissue.object
    counts = dict(group_counts(obj))
    box = layout.column(align=True)
    names = [name for name, _ in _HELD] + [name for name in counts if name not in dict(_HELD)]
    for name in names:
        row = box.row(align=True)
        row.label(text=f"{name}: {counts.get(name, 0)}", icon=dict(_HELD).get(name, "FACESEL"))
        row = row.row(align=True)
        assign = row.operator("lappet.faces_assign", text="", icon="ADD")
        assign.group, assign.action = name, "ADD"
        row = row.row(align=True)
        row.enabled = name in counts
        take = row.operator("lappet.faces_assign", text="", icon="REMOVE")
        take.group, take.action = name, "REMOVE"
        row.operator("lappet.faces_select", text="", icon="RESTRICT_SELECT_OFF").group = name
        row.operator("lappet.faces_clear", text="", icon="X").group = name
    if scene.lappet.tissue.thicken:
        box.label(text="The rim is fixed; the underside is the bed.", icon="INFO")
    box.operator("lappet.faces_new", text="New Group from Selection", icon="ADD")


def _lattice(layout: bpy.types.UILayout, scene: bpy.types.Scene) -> None:
    column = layout.column(align=True)
    row = column.row(align=True)
    row.prop(scene.lappet.tissue, "spacing")
    row.prop(scene.lappet.look, "show_lattice", text="", icon="MESH_GRID")
    if scene.lappet.tissue.object.mode == "EDIT":
        return
    if not tissue_is_ready(scene):
        column.label(text="Making the sheet…")
        return
    cells, seconds = cell_count(scene), expected_seconds(scene)
    if cells is not None and seconds is not None:
        frames = scene.frame_end - scene.frame_start + 1
        pattern, count = "About {cells} cells; {frames} frames: {duration}", f"{round(cells, -2):,.0f}"
        text = said(pattern, cells=count, frames=frames, duration=duration_text(seconds))
        column.label(text=text)


def _bones(layout: bpy.types.UILayout, scene: bpy.types.Scene) -> None:
    column = layout.column(align=True)
    for bone in scene.lappet.bones:
        row = column.row(align=True)
        row.prop(bone, "object", text=bone.name or "Bone")
        row.operator("lappet.bone_remove", text="", icon="X").object = bone.object.name if bone.object else bone.name
    column.operator("lappet.bone_add", text="Add Active Object as Bone", icon="ADD")


def _problems(layout: bpy.types.UILayout, context: bpy.types.Context) -> None:
    layout.operator("lappet.tissue_check", icon="VIEWZOOM")
    scene = context.scene
    found = last_check(scene)
    if found is not None:
        for index, each in enumerate(found.places):
            _problem(layout, context, each.problem, index if each.middle() is not None else -1)
        if not found.places:
            layout.label(text="No problems found.", icon="CHECKMARK")
    elif scene.lappet.tissue.object.mode != "EDIT" and tissue_is_ready(scene):
        for problem in reading_problems(read_scene(scene)):
            _problem(layout, context, problem)


def reading_problems(reading: SceneReading) -> tuple[Problem, ...]:
    """The problems of reading a scene, errors first."""
    return tuple(sorted(reading.problems, key=lambda each: each.severity != "error"))


def _problem(layout: bpy.types.UILayout, context: bpy.types.Context, problem: Problem, index: int = -1) -> None:
    box = layout.box()
    draw_sentence(box, context, problem.message, "ERROR" if problem.severity == "error" else "INFO")
    row = box.row(align=True)
    if not draw_repair(row, problem):
        draw_sentence(box, context, problem.remedy)
    if index >= 0:
        row.operator("lappet.tissue_show_problem", text="", icon="ZOOM_SELECTED").index = index


CLASSES = (
    LAPPET_PT_tissue,
    LAPPET_PT_tissue_faces,
    LAPPET_PT_tissue_surroundings,
    LAPPET_PT_tissue_skin_lines,
    LAPPET_PT_tissue_vessels,
)
