"""Operators of the panel *Plate*: lists, the panel's camera, annotations."""

from __future__ import annotations

import bpy
from bpy.props import CollectionProperty, EnumProperty, FloatVectorProperty, IntProperty, StringProperty

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.plates.plate_templates import TEMPLATES

from ..interface.operator_base import OperatorBase
from ..model.event_properties import LappetPoint
from ..model.plate_names import active_plate
from ..model.plate_properties import KINDS, STEPS
from ..tools.shown_surface import ShownSurface, shown_surface
from .panel_frame import panel_frame
from .panel_view import look_through, panel_view, take_view
from .plate_edits import (
    add_annotation,
    add_panel,
    add_plate,
    chosen_panel,
    chosen_plate,
    move_item,
    place_annotation,
    remove_item,
)

_LISTS = (("panels", "Panels", ""), ("annotations", "Annotations", ""))
_ACTIVE = {"panels": "active_panel", "annotations": "active_annotation"}


class LAPPET_OT_plate_add(OperatorBase, bpy.types.Operator):
    """Add a plate: a page for print, from a template"""

    bl_label = "Add Plate"

    template: EnumProperty(name="Template", items=tuple((name, name.capitalize(), "") for name in TEMPLATES))

    def run(self, context: bpy.types.Context) -> None:
        add_plate(context.scene, self.template)


class LAPPET_OT_plate_remove(OperatorBase, bpy.types.Operator):
    """Remove the chosen plate"""

    bl_label = "Remove Plate"

    def run(self, context: bpy.types.Context) -> None:
        chosen_plate(context.scene)
        remove_item(context.scene.lappet, "pages", "active_page")


class LAPPET_OT_plate_panel_add(OperatorBase, bpy.types.Operator):
    """Add a panel behind the chosen one: a step of the operation, or the current frame"""

    bl_label = "Add Panel"

    step: EnumProperty(name="Step", items=STEPS, default="FRAME")

    def run(self, context: bpy.types.Context) -> None:
        add_panel(context.scene, self.step, float(context.scene.frame_current))


class LAPPET_OT_plate_item_remove(OperatorBase, bpy.types.Operator):
    """Remove the chosen panel or annotation"""

    bl_label = "Remove"

    which: EnumProperty(name="List", items=_LISTS)

    def run(self, context: bpy.types.Context) -> None:
        remove_item(chosen_plate(context.scene), self.which, _ACTIVE[self.which])


class LAPPET_OT_plate_item_move(OperatorBase, bpy.types.Operator):
    """Move the chosen panel or annotation up or down"""

    bl_label = "Move"

    which: EnumProperty(name="List", items=_LISTS)
    by: IntProperty(name="By", default=1, min=-1, max=1)

    def run(self, context: bpy.types.Context) -> None:
        move_item(chosen_plate(context.scene), self.which, _ACTIVE[self.which], self.by)


class LAPPET_OT_plate_panel_from_view(OperatorBase, bpy.types.Operator):
    """Give the panel the camera of this view: its direction, and what of the tissue its frame shows"""

    bl_label = "From View"

    def run(self, context: bpy.types.Context) -> None:
        panel = chosen_panel(context.scene)
        take_view(context.scene, panel, _region_data(context), _surface(context))


class LAPPET_OT_plate_panel_look(OperatorBase, bpy.types.Operator):
    """Go to the panel's frame and look at the tissue as its camera does"""

    bl_label = "Look Through"

    def run(self, context: bpy.types.Context) -> None:
        scene, panel = context.scene, chosen_panel(context.scene)
        data = _region_data(context)
        scene.frame_set(panel_frame(scene, panel))
        look_through(scene, data, panel_view(scene, active_plate(scene), panel, _surface(context)))


class LAPPET_OT_annotation_put(OperatorBase, bpy.types.Operator):
    """Add an annotation at points of the skin"""

    bl_label = "Put Annotation"

    kind: EnumProperty(name="Kind", items=KINDS)
    text: StringProperty(name="Text", description="Empty: a measure says its value, a label its name")
    points: CollectionProperty(type=LappetPoint, options={"SKIP_SAVE"})

    def run(self, context: bpy.types.Context) -> None:
        points = [tuple(point.co) for point in self.points]
        add_annotation(context.scene, self.kind, points, self.text)


class LAPPET_OT_annotation_place(OperatorBase, bpy.types.Operator):
    """Put the text of an annotation somewhere on paper"""

    bl_label = "Place Annotation"

    annotation: StringProperty(name="Annotation")
    offset: FloatVectorProperty(name="Offset", description="mm to the right and down", size=2)

    def run(self, context: bpy.types.Context) -> None:
        place_annotation(context.scene, self.annotation, self.offset)


def _region_data(context: bpy.types.Context) -> bpy.types.RegionView3D:
    """The view of the 3D viewport in which the operator was started; raises RefusedError elsewhere."""
    space = context.space_data
    if space is None or space.type != "VIEW_3D" or space.region_3d is None:
        raise refused(ProblemCode.TOOL_NOT_IN_VIEWPORT, "", "A panel's camera")
    return context.region_data or space.region_3d


def _surface(context: bpy.types.Context) -> ShownSurface:
    """The surface that is shown; raises RefusedError where there is none."""
    surface = shown_surface(context.scene)
    if surface is None:
        raise refused(ProblemCode.TISSUE_NONE)
    return surface


CLASSES = (
    LAPPET_OT_plate_add,
    LAPPET_OT_plate_remove,
    LAPPET_OT_plate_panel_add,
    LAPPET_OT_plate_item_remove,
    LAPPET_OT_plate_item_move,
    LAPPET_OT_plate_panel_from_view,
    LAPPET_OT_plate_panel_look,
    LAPPET_OT_annotation_put,
    LAPPET_OT_annotation_place,
)
