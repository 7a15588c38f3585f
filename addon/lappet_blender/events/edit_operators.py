"""Operators on an event that is there: remove, retime, rename, switch, select, jump to, duplicate."""

import bpy
from bpy.props import BoolProperty, FloatProperty, StringProperty

from ..interface.operator_base import NO_UNDO, OperatorBase
from ..model.event_list import event_time, remove_event, rename_event
from .edit_events import duplicate_event, jump_to_event, retime_event, select_event
from .operator_values import named_event


class _OnEvent(OperatorBase):
    """An operator on one event."""

    event: StringProperty(name="Event", description="Name or identifier; if not given, the active event")

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return len(context.scene.lappet.events) > 0


class LAPPET_OT_event_remove(_OnEvent, bpy.types.Operator):
    """Remove an event from the timeline, with the empty that was made for it"""

    bl_label = "Remove Event"

    def run(self, context: bpy.types.Context) -> None:
        remove_event(context.scene, named_event(context.scene, self.event))


class LAPPET_OT_event_retime(_OnEvent, bpy.types.Operator):
    """Move an event to another frame, together with its release and its target's keyframes"""

    bl_label = "Retime Event"

    time: FloatProperty(name="Frame", description="The new frame")
    shift: FloatProperty(name="Shift", description="Number of frames to move by, if no frame is given")

    def run(self, context: bpy.types.Context) -> None:
        event = named_event(context.scene, self.event)
        given = self.properties.is_property_set("time")
        retime_event(context.scene, event, self.time if given else event_time(event) + self.shift)


class LAPPET_OT_event_rename(_OnEvent, bpy.types.Operator):
    """Rename an event; only letters, digits and underscores are kept"""

    bl_label = "Rename Event"

    name: StringProperty(name="Name")

    def run(self, context: bpy.types.Context) -> str | None:
        got = rename_event(context.scene, named_event(context.scene, self.event), self.name)
        if got == self.name:
            return None
        return f"It is named {got}: names are letters, digits and underscores, each given once."


class LAPPET_OT_event_enable(_OnEvent, bpy.types.Operator):
    """Turn an event on or off; an event that is off stays in the timeline but does not happen"""

    bl_label = "Enable Event"

    enabled: BoolProperty(name="Enabled", default=True)

    def run(self, context: bpy.types.Context) -> None:
        named_event(context.scene, self.event).enabled = self.enabled


class LAPPET_OT_event_select(_OnEvent, bpy.types.Operator):
    """Make an event active and select its empty"""

    bl_label = "Select Event"

    def run(self, context: bpy.types.Context) -> None:
        select_event(context.scene, context.view_layer, named_event(context.scene, self.event))


class LAPPET_OT_event_jump(_OnEvent, bpy.types.Operator):
    """Go to the frame of an event and make it active"""

    bl_label = "Jump to Event"
    bl_options = NO_UNDO  # Blender's undo holds no frames

    def run(self, context: bpy.types.Context) -> None:
        jump_to_event(context.scene, named_event(context.scene, self.event))


class LAPPET_OT_event_duplicate(_OnEvent, bpy.types.Operator):
    """Add a copy of an event with its own empty and keyframes"""

    bl_label = "Duplicate Event"

    shift: FloatProperty(name="Shift", description="Number of frames later", default=0.0)

    def run(self, context: bpy.types.Context) -> None:
        duplicate_event(context.scene, named_event(context.scene, self.event), self.shift)


CLASSES = (
    LAPPET_OT_event_remove,
    LAPPET_OT_event_retime,
    LAPPET_OT_event_rename,
    LAPPET_OT_event_enable,
    LAPPET_OT_event_select,
    LAPPET_OT_event_jump,
    LAPPET_OT_event_duplicate,
)
