"""Operators that cut and mark: incision, excision, undermining, landmark."""

import bpy
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, FloatProperty, FloatVectorProperty, StringProperty

from lappet.procedure import Excision, Incision, Landmark, Undermine

from ..model.event_properties import BASES, LappetPoint
from ..model.event_values import BASIS_OF, add_value, free_name
from .event_check import check_events
from .event_operator import UNDOABLE, attempt, given, places


class LAPPET_OT_incision_add(bpy.types.Operator):
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

    def execute(self, context: bpy.types.Context) -> set[str]:
        scene = context.scene
        time = given(self, "time", scene.frame_current)

        def act() -> None:
            value = Incision(
                free_name(scene, "INCISION", self.name),
                time,
                tuple(places(self.points)),
                None if self.through else self.depth,
                self.kerf,
                BASIS_OF[self.basis],
                self.closed,
            )
            check_events(scene, [value])
            add_value(scene, value)

        return attempt(self, act)


class LAPPET_OT_excise(bpy.types.Operator):
    """Takes the piece of tissue at a point away"""

    bl_idname = "lappet.excise"
    bl_label = "Excise"
    bl_options = UNDOABLE

    point: FloatVectorProperty(name="Point", description="Of the piece, in mm at rest", size=3, precision=3)
    time: FloatProperty(name="Frame", description="When it is taken away; left out: the scene's frame")
    name: StringProperty(name="Name", description="Left out: excision and a number")

    def execute(self, context: bpy.types.Context) -> set[str]:
        scene = context.scene
        time = given(self, "time", scene.frame_current)

        def act() -> None:
            value = Excision(free_name(scene, "EXCISION", self.name), time, (tuple(self.point),))
            check_events(scene, [value])
            add_value(scene, value)

        return attempt(self, act)


class LAPPET_OT_undermine_add(bpy.types.Operator):
    """Frees the skin inside a closed line from its bed"""

    bl_idname = "lappet.undermine_add"
    bl_label = "Undermine"
    bl_options = UNDOABLE

    points: CollectionProperty(name="Points", description="Around the area, in mm at rest", type=LappetPoint)
    time: FloatProperty(name="Frame", description="When it is freed; left out: the scene's frame")
    basis: EnumProperty(name="Line", items=BASES, default="LINEAR")
    name: StringProperty(name="Name", description="Left out: undermine and a number")

    def execute(self, context: bpy.types.Context) -> set[str]:
        scene = context.scene
        time = given(self, "time", scene.frame_current)

        def act() -> None:
            name = free_name(scene, "UNDERMINE", self.name)
            value = Undermine(name, time, tuple(places(self.points)), BASIS_OF[self.basis])
            check_events(scene, [value])
            add_value(scene, value)

        return attempt(self, act)


class LAPPET_OT_landmark_add(bpy.types.Operator):
    """Marks a point of the skin to follow and measure"""

    bl_idname = "lappet.landmark_add"
    bl_label = "Landmark"
    bl_options = UNDOABLE

    point: FloatVectorProperty(name="Point", description="In mm at rest", size=3, precision=3)
    points: CollectionProperty(name="Points", description="Several of one label, instead of one", type=LappetPoint)
    label: StringProperty(name="Label", description="What reports call it; left out: its name")
    name: StringProperty(name="Name", description="Left out: landmark and a number")

    def execute(self, context: bpy.types.Context) -> set[str]:
        scene = context.scene

        def act() -> None:
            name = free_name(scene, "LANDMARK", self.name)
            points = tuple(places(self.points)) or (tuple(self.point),)
            value = Landmark(name, points, self.label or name)
            check_events(scene, [value])
            add_value(scene, value)

        return attempt(self, act)


CLASSES = (LAPPET_OT_incision_add, LAPPET_OT_excise, LAPPET_OT_undermine_add, LAPPET_OT_landmark_add)
