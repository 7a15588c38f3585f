"""Operators on the points of an event: move, insert, remove."""

from typing import Any

import bpy
from bpy.props import FloatVectorProperty, IntProperty, StringProperty

from lappet.core.problem import RefusedError

from ..model.changes import changed
from ..model.event_list import set_points
from ..model.event_values import event_value
from .event_check import check_events
from .event_operator import UNDOABLE, attempt, named_event

_LEAST = {"INCISION": 2, "UNDERMINE": 3, "EXCISION": 1, "LANDMARK": 1}  # hooks and sutures keep the number they have


class _OnPoint:
    """An operator on one point of an event."""

    event: StringProperty(name="Event", description="Name or identifier; left out: the active one")
    index: IntProperty(name="Point", description="Counted from 0", default=0, min=0)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return len(context.scene.lappet.events) > 0

    def change(self, scene: bpy.types.Scene, places: list[tuple[float, ...]], event: Any) -> None:
        """Gives the event other points, or leaves it as it was and raises why not."""
        before = [tuple(point.co) for point in event.points]
        set_points(event, places)
        try:
            check_events(scene, [event_value(scene, event)])
        except RefusedError:
            set_points(event, before)
            raise
        changed(scene)

    def found(self, scene: bpy.types.Scene, beyond: int = 0) -> tuple[Any, list[tuple[float, ...]]]:
        """The event and its points; raises RefusedError for an index that it has not."""
        event = named_event(scene, self.event)
        places = [tuple(point.co) for point in event.points]
        if self.index >= len(places) + beyond:
            raise RefusedError(f"{event.name} has no point {self.index}; it has {len(places)}, counted from 0.")
        return event, places


class LAPPET_OT_point_move(_OnPoint, bpy.types.Operator):
    """Moves a point of an event"""

    bl_idname = "lappet.point_move"
    bl_label = "Move Point"
    bl_options = UNDOABLE

    co: FloatVectorProperty(name="Position", description="In mm at rest", size=3, precision=3)

    def execute(self, context: bpy.types.Context) -> set[str]:
        def act() -> None:
            event, places = self.found(context.scene)
            places[self.index] = tuple(self.co)
            self.change(context.scene, places, event)

        return attempt(self, act)


class LAPPET_OT_point_insert(_OnPoint, bpy.types.Operator):
    """Puts a point into the line of an event, before the one of this index"""

    bl_idname = "lappet.point_insert"
    bl_label = "Insert Point"
    bl_options = UNDOABLE

    co: FloatVectorProperty(name="Position", description="In mm at rest", size=3, precision=3)

    def execute(self, context: bpy.types.Context) -> set[str]:
        def act() -> None:
            event, places = self.found(context.scene, beyond=1)
            if event.kind not in _LEAST:
                raise RefusedError(f"{event.name} has its {len(places)} points and takes no more; add another event.")
            places.insert(self.index, tuple(self.co))
            self.change(context.scene, places, event)

        return attempt(self, act)


class LAPPET_OT_point_remove(_OnPoint, bpy.types.Operator):
    """Takes a point out of the line of an event"""

    bl_idname = "lappet.point_remove"
    bl_label = "Remove Point"
    bl_options = UNDOABLE

    def execute(self, context: bpy.types.Context) -> set[str]:
        def act() -> None:
            event, places = self.found(context.scene)
            least = _LEAST.get(event.kind, len(places))
            if len(places) <= least:
                raise RefusedError(f"{event.name} needs its {len(places)} points; remove the event instead.")
            del places[self.index]
            self.change(context.scene, places, event)

        return attempt(self, act)


CLASSES = (LAPPET_OT_point_move, LAPPET_OT_point_insert, LAPPET_OT_point_remove)
