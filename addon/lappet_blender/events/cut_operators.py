"""Operators that cut and mark: incision, excision, undermining, landmark."""

import bpy
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, FloatProperty, FloatVectorProperty, StringProperty

from ..interface.operator_base import UNDOABLE, OperatorBase
from ..model.event_kinds import BASES, BASIS_OF
from ..model.event_properties import LappetPoint
from .add_events import add_excision, add_incision, add_landmark, add_undermining
from .operator_values import given, places


class LAPPET_OT_incision_add(OperatorBase, bpy.types.Operator):
    """Cuts along a line on the skin"""

    bl_idname = "lappet.incision_add"
    bl_label = "Incision"
    bl_options = UNDOABLE

    points: CollectionProperty(name="Points", description="Of the line, in mm at rest", type=LappetPoint)
    time: FloatProperty(name="Frame", description="When the cut is made; left out: the scene's frame")
    through: BoolProperty(name="Through", description="Cut through the whole tissue", default=True)
    depth: FloatProperty(name="Depth", description="How deep, in mm, if not through", default=2.0, min=0.0)
    kerf: FloatProperty(name="Kerf", description="How wide, in mm", default=0.05, min=0.0, precision=3)
    basis: EnumProperty(name="Line", items=BASES, default="LINEAR")
    closed: BoolProperty(name="Closed", description="The line returns to its first point", default=False)
    name: StringProperty(name="Name", description="Left out: incision and a number")

    def run(self, context: bpy.types.Context) -> None:
        add_incision(
            context.scene,
            places(self.points),
            given(self, "time", context.scene.frame_current),
            depth=None if self.through else self.depth,
            kerf=self.kerf,
            basis=BASIS_OF[self.basis],
            closed=self.closed,
            name=self.name,
        )


class LAPPET_OT_excise(OperatorBase, bpy.types.Operator):
    """Takes the piece of tissue at a point away"""

    bl_idname = "lappet.excise"
    bl_label = "Excise"
    bl_options = UNDOABLE

    point: FloatVectorProperty(name="Point", description="Of the piece, in mm at rest", size=3, precision=3)
    time: FloatProperty(name="Frame", description="When it is taken away; left out: the scene's frame")
    name: StringProperty(name="Name", description="Left out: excision and a number")

    def run(self, context: bpy.types.Context) -> None:
        add_excision(context.scene, self.point, given(self, "time", context.scene.frame_current), name=self.name)


class LAPPET_OT_undermine_add(OperatorBase, bpy.types.Operator):
    """Frees the skin inside a closed line from its bed"""

    bl_idname = "lappet.undermine_add"
    bl_label = "Undermine"
    bl_options = UNDOABLE

    points: CollectionProperty(name="Points", description="Around the area, in mm at rest", type=LappetPoint)
    time: FloatProperty(name="Frame", description="When it is freed; left out: the scene's frame")
    basis: EnumProperty(name="Line", items=BASES, default="LINEAR")
    name: StringProperty(name="Name", description="Left out: undermine and a number")

    def run(self, context: bpy.types.Context) -> None:
        time = given(self, "time", context.scene.frame_current)
        add_undermining(context.scene, places(self.points), time, basis=BASIS_OF[self.basis], name=self.name)


class LAPPET_OT_landmark_add(OperatorBase, bpy.types.Operator):
    """Marks a point of the skin to follow and measure"""

    bl_idname = "lappet.landmark_add"
    bl_label = "Landmark"
    bl_options = UNDOABLE

    point: FloatVectorProperty(name="Point", description="In mm at rest", size=3, precision=3)
    points: CollectionProperty(name="Points", description="Several of one label, instead of one", type=LappetPoint)
    label: StringProperty(name="Label", description="What reports call it; left out: its name")
    name: StringProperty(name="Name", description="Left out: landmark and a number")

    def run(self, context: bpy.types.Context) -> None:
        points = places(self.points) or [self.point]
        add_landmark(context.scene, points, label=self.label, name=self.name)


CLASSES = (LAPPET_OT_incision_add, LAPPET_OT_excise, LAPPET_OT_undermine_add, LAPPET_OT_landmark_add)
