"""Operators that suture: two points, or a run along two edges."""

import bpy
import numpy as np
from bpy.props import BoolProperty, CollectionProperty, FloatProperty, FloatVectorProperty, IntProperty, StringProperty

from lappet.procedure import Suture

from ..interface.operator_base import OperatorBase
from ..model.event_kinds import ORDER_OF
from ..model.event_properties import LappetPoint
from .add_suture_run import add_suture_run, edges_along, edges_between
from .add_sutures import (
    Spacing,
    SutureTimes,
    add_single_sutures,
    add_stitches,
    add_suture,
    ends_across,
    ends_between,
)
from .operator_values import given, places
from .stitch_properties import drawn_property, order_property, shape_property, single_property
from .stitch_shapes import Shape


class LAPPET_OT_suture_add(OperatorBase, bpy.types.Operator):
    """Draw two points together and hold them"""

    bl_label = "Suture"

    first: FloatVectorProperty(name="From", description="At rest, in mm", size=3, precision=3)
    second: FloatVectorProperty(name="To", description="At rest, in mm", size=3, precision=3)
    start: FloatProperty(name="Frame", description="When it is placed; if not given, the current frame")
    duration: FloatProperty(
        name="Duration", description="Number of frames until it is closed", default=Suture.duration, min=0.0
    )
    stiffness: FloatProperty(name="Stiffness", description="mN/mm", default=Suture.stiffness, min=0.0)
    shape: shape_property()
    bite: FloatProperty(
        name="Bite",
        description="Of a shape: distance of its bites from the points, which are the wound's edges, in mm; 0 = as is "
        "usual",
        default=0.0,
        min=0.0,
    )
    drawn: drawn_property()
    depth: FloatProperty(
        name="Depth",
        description="Depth of both ends, or of a shape's bites, below the skin, in mm",
        default=0.0,
        min=0.0,
    )
    name: StringProperty(name="Name", description="If not given, suture and a number")

    def run(self, context: bpy.types.Context) -> None:
        times = SutureTimes(given(self, "start", context.scene.frame_current), self.duration, self.stiffness)
        shape = Shape(self.shape, self.bite, self.depth, self.drawn)
        if shape.is_loop:
            ends = (np.array([self.first]), np.array([self.second]))
            add_stitches(context.scene, ends, times, shape, name=self.name, numbered=False)
            return
        add_suture(context.scene, self.first, self.second, times, depth=self.depth, name=self.name)


class LAPPET_OT_suture_run(OperatorBase, bpy.types.Operator):
    """Sew two wound edges, or both walls of an incision, with evenly spaced stitches"""

    bl_label = "Run of Sutures"

    first_edge: CollectionProperty(name="First edge", description="At rest, in mm", type=LappetPoint)
    second_edge: CollectionProperty(
        name="Second edge",
        description="At rest, in mm; its first point meets the first point of the first edge",
        type=LappetPoint,
    )
    flip: BoolProperty(name="Flip", description="Reverse the second edge", default=False)
    incision: StringProperty(name="Incision", description="Suture across this incision instead of between two edges")
    bite: FloatProperty(
        name="Bite",
        description="Distance from the middle of the incision to an anchor, in mm; 0 = at the wound edge. Of a shape: "
        "from the wound edge; 0 = as is usual",
        default=0.0,
        min=0.0,
    )
    shape: shape_property()
    drawn: drawn_property()
    depth: FloatProperty(
        name="Depth",
        description="Depth of the anchors below the skin, in mm: a buried row holds the wound walls together",
        default=0.0,
        min=0.0,
    )
    count: IntProperty(name="Sutures", description="Number of sutures; 0 = from the spacing", default=0, min=0)
    spacing: FloatProperty(name="Spacing", description="Distance between sutures, in mm", default=4.0, min=0.01)
    inset_start: FloatProperty(
        name="First",
        description="Fraction of the edge before the first suture; if not given, half a distance",
        min=0.0,
        max=1.0,
    )
    inset_end: FloatProperty(
        name="Last",
        description="Fraction of the edge after the last suture; if not given, half a distance",
        min=0.0,
        max=1.0,
    )
    start: FloatProperty(name="Frame", description="When they are placed; if not given, the current frame")
    duration: FloatProperty(name="Duration", description="Number of frames until they are closed", default=8.0, min=0.0)
    stiffness: FloatProperty(name="Stiffness", description="mN/mm", default=Suture.stiffness, min=0.0)
    order: order_property()
    single: single_property()
    name: StringProperty(
        name="Name",
        description="Name of the run, or of the first of single sutures; others are numbered. If not given, its kind",
    )

    def run(self, context: bpy.types.Context) -> None:
        times = SutureTimes(given(self, "start", context.scene.frame_current), self.duration, self.stiffness)
        insets = (
            getattr(self, name) if self.properties.is_property_set(name) else None
            for name in ("inset_start", "inset_end")
        )
        spacing = Spacing(self.count, self.spacing, *insets)
        shape = Shape(self.shape, self.bite, self.depth, self.drawn)
        if not self.single:
            if self.incision:
                edges = edges_along(context.scene, self.incision, self.bite, shape)
            else:
                first, second = places(self.first_edge), places(self.second_edge)
                edges = edges_between(context.scene, first, second, self.flip, shape)
            add_suture_run(context.scene, edges, times, shape, spacing, order=ORDER_OF[self.order], name=self.name)
            return
        if self.incision:
            ends = ends_across(context.scene, self.incision, 0.0 if shape.is_loop else self.bite, spacing)
        else:
            ends = ends_between(places(self.first_edge), places(self.second_edge), self.flip, spacing)
        if shape.is_loop:
            add_stitches(context.scene, ends, times, shape, name=self.name)
            return
        add_single_sutures(context.scene, ends, times, depth=self.depth, name=self.name)


CLASSES = (LAPPET_OT_suture_add, LAPPET_OT_suture_run)
