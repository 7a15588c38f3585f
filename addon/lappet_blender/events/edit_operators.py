"""Operators on an event that is there: remove, retime, rename, switch, select, jump to, duplicate."""

import bpy
from bpy.props import BoolProperty, FloatProperty, StringProperty

from lappet.core.problem import RefusedError

from ..model.changes import changed
from ..model.event_list import (
    add_event,
    event_index,
    event_time,
    find_event,
    move_event,
    remove_event,
    rename_event,
    set_points,
    target_name,
)
from ..model.event_target import copy_target, is_there
from ..model.event_values import event_value
from ..model.tissue_values import tissue_value
from .event_check import check_events
from .event_operator import SHOWN, UNDOABLE, attempt, named_event

_COPIED = (
    "enabled",
    "start",
    "end",
    "duration",
    "basis",
    "closed",
    "through",
    "depth",
    "kerf",
    "stiffness",
    "grip",
    "label",
)


class _OnEvent:
    """An operator on one event."""

    event: StringProperty(name="Event", description="Name or identifier; left out: the active one")

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return len(context.scene.lappet.events) > 0


class LAPPET_OT_event_remove(_OnEvent, bpy.types.Operator):
    """Takes an event out of the timeline, with the empty that was made for it"""

    bl_idname = "lappet.event_remove"
    bl_label = "Remove Event"
    bl_options = UNDOABLE

    def execute(self, context: bpy.types.Context) -> set[str]:
        return attempt(self, lambda: remove_event(context.scene, named_event(context.scene, self.event)))


class LAPPET_OT_event_retime(_OnEvent, bpy.types.Operator):
    """Moves an event to another frame, its release and its target's keyframes with it"""

    bl_idname = "lappet.event_retime"
    bl_label = "Retime Event"
    bl_options = UNDOABLE

    time: FloatProperty(name="Frame", description="To which frame")
    shift: FloatProperty(name="Shift", description="By how many frames, where no frame is given")

    def execute(self, context: bpy.types.Context) -> set[str]:
        scene = context.scene

        def act() -> None:
            event = named_event(scene, self.event)
            before = event_time(event)
            given = self.properties.is_property_set("time")
            move_event(scene, event, self.time if given else before + self.shift)
            try:
                if event.enabled and tissue_value(scene)[0] is not None:
                    check_events(scene, [event_value(scene, event)])
            except RefusedError:
                move_event(scene, event, before)
                raise

        return attempt(self, act)


class LAPPET_OT_event_rename(_OnEvent, bpy.types.Operator):
    """Renames an event; letters, digits and underscores are kept"""

    bl_idname = "lappet.event_rename"
    bl_label = "Rename Event"
    bl_options = UNDOABLE

    name: StringProperty(name="Name")

    def execute(self, context: bpy.types.Context) -> set[str]:
        def act() -> None:
            event = named_event(context.scene, self.event)
            got = rename_event(context.scene, event, self.name)
            if got != self.name:
                self.report({"INFO"}, f"It is named {got}: names are letters, digits and underscores, each given once.")

        return attempt(self, act)


class LAPPET_OT_event_enable(_OnEvent, bpy.types.Operator):
    """Switches an event on or off; one that is off stays in the timeline and does not take place"""

    bl_idname = "lappet.event_enable"
    bl_label = "Enable Event"
    bl_options = UNDOABLE

    enabled: BoolProperty(name="Enabled", default=True)

    def execute(self, context: bpy.types.Context) -> set[str]:
        def act() -> None:
            named_event(context.scene, self.event).enabled = self.enabled

        return attempt(self, act)


class LAPPET_OT_event_select(_OnEvent, bpy.types.Operator):
    """Makes an event the active one, and selects its empty"""

    bl_idname = "lappet.event_select"
    bl_label = "Select Event"
    bl_options = UNDOABLE

    def execute(self, context: bpy.types.Context) -> set[str]:
        scene = context.scene

        def act() -> None:
            event = named_event(scene, self.event)
            scene.lappet.active_event = event_index(scene, event.uid)
            layer = context.view_layer
            if is_there(scene, event.target) and layer.objects.get(event.target.name) is not None:
                for each in layer.objects.selected:
                    each.select_set(False, view_layer=layer)
                event.target.select_set(True, view_layer=layer)
                layer.objects.active = event.target

        return attempt(self, act)


class LAPPET_OT_event_jump(_OnEvent, bpy.types.Operator):
    """Goes to the frame of an event and makes it the active one"""

    bl_idname = "lappet.event_jump"
    bl_label = "Jump to Event"
    bl_options = SHOWN  # Blender's undo holds no frames

    def execute(self, context: bpy.types.Context) -> set[str]:
        scene = context.scene

        def act() -> None:
            event = named_event(scene, self.event)
            scene.lappet.active_event = event_index(scene, event.uid)
            time = event_time(event)
            scene.frame_set(int(time // 1), subframe=time % 1)

        return attempt(self, act)


class LAPPET_OT_event_duplicate(_OnEvent, bpy.types.Operator):
    """Adds a copy of an event, with an empty and keyframes of its own"""

    bl_idname = "lappet.event_duplicate"
    bl_label = "Duplicate Event"
    bl_options = UNDOABLE

    shift: FloatProperty(name="Shift", description="How many frames later", default=0.0)

    def execute(self, context: bpy.types.Context) -> set[str]:
        scene = context.scene

        def act() -> None:
            source = named_event(scene, self.event)
            uid, target = source.uid, source.target
            fields = {field: getattr(source, field) for field in _COPIED}
            points = [tuple(point.co) for point in source.points]
            named = not source.name.startswith(f"{source.kind.lower()}_")
            fresh = add_event(scene, source.kind, source.name if named else "", **fields)
            if fresh.kind == "LANDMARK":
                fresh.label = fresh.name  # reports tell landmarks apart by their labels
            set_points(fresh, points)
            if target is not None:
                fresh.target = copy_target(scene, target, fresh.uid)
                fresh.target.name = target_name(fresh.name)
            if self.shift:
                move_event(scene, fresh, event_time(find_event(scene, uid)) + self.shift)
            changed(scene)

        return attempt(self, act)


CLASSES = (
    LAPPET_OT_event_remove,
    LAPPET_OT_event_retime,
    LAPPET_OT_event_rename,
    LAPPET_OT_event_enable,
    LAPPET_OT_event_select,
    LAPPET_OT_event_jump,
    LAPPET_OT_event_duplicate,
)
