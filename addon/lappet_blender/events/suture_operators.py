"""Operators that suture: two points, or a run of evenly spaced sutures."""

import bpy
from bpy.props import BoolProperty, CollectionProperty, FloatProperty, FloatVectorProperty, IntProperty, StringProperty

from ..interface.operator_base import UNDOABLE, OperatorBase
from ..model.event_properties import LappetPoint
from .add_sutures import Spacing, SutureTimes, add_suture, add_suture_run, ends_across, ends_between
from .operator_values import given, places


class LAPPET_OT_suture_add(OperatorBase, bpy.types.Operator):
    """Draws two points together and holds them"""

    bl_idname = "lappet.suture_add"
    bl_label = "Suture"
    bl_options = UNDOABLE

    first: FloatVectorProperty(name="From", description="In mm at rest", size=3, precision=3)
    second: FloatVectorProperty(name="To", description="In mm at rest", size=3, precision=3)
    start: FloatProperty(name="Frame", description="When it is placed; left out: the scene's frame")
    duration: FloatProperty(name="Duration", description="Frames that it takes to close", default=1.0, min=0.0)
    stiffness: FloatProperty(name="Stiffness", description="mN/mm", default=1000.0, min=0.0)
    depth: FloatProperty(name="Depth", description="Of both ends below the skin, in mm", default=0.0, min=0.0)
    name: StringProperty(name="Name", description="Left out: suture and a number")

    def run(self, context: bpy.types.Context) -> None:
        times = SutureTimes(given(self, "start", context.scene.frame_current), self.duration, self.stiffness)
        add_suture(context.scene, self.first, self.second, times, depth=self.depth, name=self.name)


class LAPPET_OT_suture_run(OperatorBase, bpy.types.Operator):
    """Places evenly spaced sutures between two wound edges, or across an incision"""

    bl_idname = "lappet.suture_run"
    bl_label = "Run of Sutures"
    bl_options = UNDOABLE

    first_edge: CollectionProperty(name="First edge", description="In mm at rest", type=LappetPoint)
    second_edge: CollectionProperty(
        name="Second edge", description="In mm at rest; its first point meets the first edge's", type=LappetPoint
    )
    flip: BoolProperty(name="Flip", description="The second edge runs the other way", default=False)
    incision: StringProperty(name="Incision", description="Suture across this incision, instead of between two edges")
    bite: FloatProperty(
        name="Bite",
        description="From the middle of the incision to an anchor, in mm; 0 = at the wound's edge",
        default=0.0,
        min=0.0,
    )
    depth: FloatProperty(
        name="Depth",
        description="Of the anchors below the skin, in mm: a buried row holds the walls of the wound together",
        default=0.0,
        min=0.0,
    )
    count: IntProperty(name="Sutures", description="How many; 0 = as many as the spacing gives", default=0, min=0)
    spacing: FloatProperty(name="Spacing", description="From suture to suture, in mm", default=4.0, min=0.01)
    inset_start: FloatProperty(
        name="First",
        description="Share of the edge before the first suture; left out: half a distance",
        min=0.0,
        max=1.0,
    )
    inset_end: FloatProperty(
        name="Last", description="Share of the edge after the last suture; left out: half a distance", min=0.0, max=1.0
    )
    start: FloatProperty(name="Frame", description="When they are placed; left out: the scene's frame")
    duration: FloatProperty(name="Duration", description="Frames that they take to close", default=8.0, min=0.0)
    stiffness: FloatProperty(name="Stiffness", description="mN/mm", default=1000.0, min=0.0)
    name: StringProperty(name="Name", description="Of the first; the others are counted up. Left out: suture")

    def run(self, context: bpy.types.Context) -> None:
        times = SutureTimes(given(self, "start", context.scene.frame_current), self.duration, self.stiffness)
        insets = (
            getattr(self, name) if self.properties.is_property_set(name) else None
            for name in ("inset_start", "inset_end")
        )
        spacing = Spacing(self.count, self.spacing, *insets)
        if self.incision:
            ends = ends_across(context.scene, self.incision, self.bite, spacing)
        else:
            ends = ends_between(places(self.first_edge), places(self.second_edge), self.flip, spacing)
        add_suture_run(context.scene, ends, times, depth=self.depth, name=self.name)


CLASSES = (LAPPET_OT_suture_add, LAPPET_OT_suture_run)
