"""Operators that cut and mark: incision, excision, undermining, landmark."""

import bpy
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, FloatProperty, FloatVectorProperty, StringProperty

from lappet.procedure import Incision, Thin

from ..interface.operator_base import OperatorBase
from ..model.event_kinds import BASES, BASIS_OF
from ..model.event_properties import LappetPoint
from .add_events import add_excision, add_incision, add_landmark, add_thinning, add_undermining
from .operator_values import given, places


class LAPPET_OT_incision_add(OperatorBase, bpy.types.Operator):
    """Cut along a line on the skin"""

    bl_label = "Incision"

    points: CollectionProperty(name="Points", description="Points of the line at rest, in mm", type=LappetPoint)
    time: FloatProperty(name="Frame", description="When the cut is made; if not given, the current frame")
    through: BoolProperty(name="Through", description="Cut through the whole tissue", default=True)
    depth: FloatProperty(
        name="Depth", description="Depth of the cut in mm, unless it goes through", default=2.0, min=0.0
    )
    kerf: FloatProperty(name="Kerf", description="Width of the cut in mm", default=Incision.kerf, min=0.0, precision=3)
    basis: EnumProperty(name="Line", items=BASES, default="LINEAR")
    closed: BoolProperty(name="Closed", description="The line returns to its first point", default=False)
    name: StringProperty(name="Name", description="If not given, incision and a number")

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
    """Remove the piece of tissue at a point"""

    bl_label = "Excise"

    point: FloatVectorProperty(name="Point", description="A point of the piece at rest, in mm", size=3, precision=3)
    time: FloatProperty(name="Frame", description="When it is removed; if not given, the current frame")
    name: StringProperty(name="Name", description="If not given, excision and a number")

    def run(self, context: bpy.types.Context) -> None:
        add_excision(context.scene, self.point, given(self, "time", context.scene.frame_current), name=self.name)


class _OutlineAdd(OperatorBase):
    """What operators share that do something to the tissue inside a closed line."""

    points: CollectionProperty(name="Points", description="Outline of the area at rest, in mm", type=LappetPoint)
    time: FloatProperty(name="Frame", description="When it is done; if not given, the current frame")
    basis: EnumProperty(name="Line", items=BASES, default="LINEAR")
    name: StringProperty(name="Name", description="If not given, the event's kind and a number")


class LAPPET_OT_undermine_add(_OutlineAdd, bpy.types.Operator):
    """Free the skin inside a closed line from its bed"""

    bl_label = "Undermine"

    def run(self, context: bpy.types.Context) -> None:
        time = given(self, "time", context.scene.frame_current)
        add_undermining(context.scene, places(self.points), time, basis=BASIS_OF[self.basis], name=self.name)


class LAPPET_OT_thin_add(_OutlineAdd, bpy.types.Operator):
    """Take the deep tissue inside a closed line away, so that a flap is thinner"""

    bl_label = "Thin"

    thickness: FloatProperty(
        name="Thickness Left", description="What stays below the skin, skin included, in mm", default=2.0, min=0.0
    )
    dressing: FloatProperty(
        name="Dressing",
        description="Pressure of the dressing that lays the skin back on its bed, in kPa; 0 for none",
        default=Thin.dressing,
        min=0.0,
    )
    duration: FloatProperty(
        name="Duration", description="Number of frames until the dressing presses", default=Thin.duration, min=0.0
    )

    def run(self, context: bpy.types.Context) -> None:
        add_thinning(
            context.scene,
            places(self.points),
            given(self, "time", context.scene.frame_current),
            self.thickness,
            dressing=self.dressing,
            duration=self.duration,
            basis=BASIS_OF[self.basis],
            name=self.name,
        )


class LAPPET_OT_landmark_add(OperatorBase, bpy.types.Operator):
    """Mark a point on the skin to follow and measure"""

    bl_label = "Landmark"

    point: FloatVectorProperty(name="Point", description="At rest, in mm", size=3, precision=3)
    points: CollectionProperty(
        name="Points", description="Several points with one label, instead of one point", type=LappetPoint
    )
    label: StringProperty(name="Label", description="Name in reports; if not given, the landmark's name")
    name: StringProperty(name="Name", description="If not given, landmark and a number")

    def run(self, context: bpy.types.Context) -> None:
        points = places(self.points) or [self.point]
        add_landmark(context.scene, points, label=self.label, name=self.name)


CLASSES = (
    LAPPET_OT_incision_add,
    LAPPET_OT_excise,
    LAPPET_OT_undermine_add,
    LAPPET_OT_thin_add,
    LAPPET_OT_landmark_add,
)
