"""Operators on the points of an event: move, insert, remove."""

import bpy
from bpy.props import FloatVectorProperty, IntProperty, StringProperty

from ..interface.operator_base import OperatorBase
from .edit_points import insert_point, move_point, remove_point
from .operator_values import named_event


class _OnPoint(OperatorBase):
    """An operator on one point of an event."""

    event: StringProperty(name="Event", description="Name or identifier; if not given, the active event")
    index: IntProperty(name="Point", description="Counted from 0", default=0, min=0)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return len(context.scene.lappet.events) > 0


class LAPPET_OT_point_move(_OnPoint, bpy.types.Operator):
    """Move a point of an event"""

    bl_label = "Move Point"

    co: FloatVectorProperty(name="Position", description="At rest, in mm", size=3, precision=3)

    def run(self, context: bpy.types.Context) -> None:
        move_point(context.scene, named_event(context.scene, self.event), self.index, self.co)


class LAPPET_OT_point_insert(_OnPoint, bpy.types.Operator):
    """Insert a point into the line of an event, before the point of this index"""

    bl_label = "Insert Point"

    co: FloatVectorProperty(name="Position", description="At rest, in mm", size=3, precision=3)

    def run(self, context: bpy.types.Context) -> None:
        insert_point(context.scene, named_event(context.scene, self.event), self.index, self.co)


class LAPPET_OT_point_remove(_OnPoint, bpy.types.Operator):
    """Remove a point from the line of an event"""

    bl_label = "Remove Point"

    def run(self, context: bpy.types.Context) -> None:
        remove_point(context.scene, named_event(context.scene, self.event), self.index)


CLASSES = (LAPPET_OT_point_move, LAPPET_OT_point_insert, LAPPET_OT_point_remove)
