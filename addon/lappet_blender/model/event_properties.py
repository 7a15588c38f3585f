"""Property groups of the timeline: one `LappetEvent` per event, in `scene.lappet.events`.

Points are material (rest) coordinates in mm, whatever the scene's unit. Times are frames of the scene.
"""

import bpy
from bpy.props import (
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    StringProperty,
)

from lappet.procedure import Hook, Incision, Suture

from .changes import property_changed
from .event_kinds import BASES, KINDS, SUTURE_MODES, THREAD_ITEMS
from .event_list import move_event, rename_event
from .tracked_properties import choice, flag, number, pointer, text, vector


class LappetPoint(bpy.types.PropertyGroup):
    """A point of an event."""

    co: vector(name="Position", description="Where the point lies on the tissue at rest, in mm", size=3, precision=3)


def _title(event: "LappetEvent") -> str:
    return str(event.name)


def _set_title(event: "LappetEvent", title: str) -> None:
    rename_event(event.id_data, event, title)


def _moment(event: "LappetEvent") -> float:
    return float(event.start)


def _set_moment(event: "LappetEvent", start: float) -> None:
    move_event(event.id_data, event, start)


class LappetEvent(bpy.types.PropertyGroup):
    """An event; which of the fields count depends on its kind."""

    uid: StringProperty(name="Identifier", description="Unique, and never changes", options={"HIDDEN"})
    # `name` is PropertyGroup's own: the name of the prim, a USD identifier, unique in the scene (operators see to it).
    kind: EnumProperty(name="Kind", items=KINDS)
    enabled: flag(
        name="Enabled", description="Whether the event happens; an event that is off stays in the list", default=True
    )
    start: number(name="Frame", description="The frame at which it happens or starts", default=1.0)
    end: number(name="Release", description="The frame at which the hook or retractor lets go", default=25.0)
    duration: FloatProperty(
        name="Duration",
        description="Number of frames until the suture is closed",
        default=1.0,
        min=0.0,
        update=property_changed,
    )
    points: CollectionProperty(type=LappetPoint)
    basis: choice(name="Line", items=BASES, default="LINEAR")
    closed: flag(name="Closed", description="The line returns to its first point", default=False)
    through: flag(name="Through", description="Cut through the whole tissue", default=True)
    depth: number(name="Depth", description="Depth of the cut below the skin, in mm", default=2.0, min=0.0)
    kerf: number(name="Kerf", description="Width of the cut in mm", default=Incision.kerf, min=0.0, precision=3)
    stiffness: FloatProperty(
        name="Stiffness",
        description="Stiffness of the hook or suture, in mN/mm",
        default=Hook.stiffness,
        min=0.0,
        update=property_changed,
    )
    mode: choice(name="Hold", items=SUTURE_MODES, default="EXACT")
    thread: choice(
        name="Thread", description="A kind of thread, or the stiffness below", items=THREAD_ITEMS, default="NONE"
    )
    length: number(
        name="Length", description="Length to which the thread is drawn, in mm", default=Suture.length, min=0.0
    )
    tension: number(
        name="Tension",
        description="Tension with which the thread is drawn at most, in mN; 0 for as much as it takes",
        default=Suture.tension,
        min=0.0,
    )
    pull_through: number(
        name="Pull-through",
        description="Tension at which the thread cuts through the tissue, in mN; 0 for that of the thread",
        default=Suture.pull_through,
        min=0.0,
    )
    target: pointer(
        name="Target",
        description="The empty whose location (hook) or motion (retractor) is followed; keyframe it like any object",
        type=bpy.types.Object,
    )
    grip: text(name="Grip", description="The group of faces that the retractor holds")
    label: text(name="Label", description="Name of the landmark in reports")
    # What the interface edits in place of `name` and `start`: the name stays one that USD takes and nothing else has,
    # and the release and the target's keyframes move with the start.
    title: StringProperty(
        name="Name", description="Name of the event; double-click to rename", get=_title, set=_set_title
    )
    moment: FloatProperty(
        name="Frame",
        description="The frame at which it happens or starts; its end and its target's keyframes move with it",
        precision=2,
        step=100,
        get=_moment,
        set=_set_moment,
    )


CLASSES = (LappetPoint, LappetEvent)
