"""Property groups of the timeline: one `LappetEvent` per event, in `scene.lappet.events`.

Points are material (rest) coordinates in mm, whatever the scene's unit. Times are frames of the scene.
"""

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    StringProperty,
)

from lappet.procedure import Hook, Incision, Suture, SutureRun, Thin

from .changes import property_changed
from .event_kinds import BASES, KINDS, ORDERS, PATTERNS, SUTURE_MODES, THREAD_ITEMS
from .event_list import move_event, rename_event
from .suture_layers import LAYER_CHOICES, set_sewn_in, sewn_in
from .tracked_properties import choice, count, flag, number, pointer, text, vector


class LappetPoint(bpy.types.PropertyGroup):
    """A point of an event."""

    co: vector(name="Position", description="Where the point lies on the tissue at rest, in mm", size=3, precision=3)


class LappetRunCorner(bpy.types.PropertyGroup):
    """Points of both edges of a suture run that meet, by their numbers."""

    first: count(name="First", description="Number of the point of the first edge", default=0, min=0)
    second: count(name="Second", description="Number of the point of the second edge", default=0, min=0)
    told: flag(name="Told", description="It is said below where the tissue of the corner lies", default=False)
    first_inside: vector(name="First Inside", description="Toward this, at rest, in mm", size=3, precision=3)
    second_inside: vector(name="Second Inside", description="Toward this, at rest, in mm", size=3, precision=3)


class LappetSutureLayer(bpy.types.PropertyGroup):
    """A layer of a suture run; `name` is PropertyGroup's own."""

    depth: number(name="Depth", description="Depth of its stitches below the skin, in mm", default=0.0, min=0.0)
    between: flag(
        name="Between",
        description="Its stitches lie between those of the other layers",
        default=False,
    )


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
    selected: BoolProperty(name="Selected", description="Its strip is selected on the strip timeline")
    start: number(name="Frame", description="The frame at which it happens or starts", default=1.0)
    end: number(name="Release", description="The frame at which the hook or retractor lets go", default=25.0)
    duration: FloatProperty(
        name="Duration",
        description="Number of frames until the suture is closed, or a thinned flap's dressing presses",
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
    thickness: number(
        name="Thickness Left", description="What stays below the skin, skin included, in mm", default=2.0, min=0.0
    )
    dressing: number(
        name="Dressing",
        description="Pressure of the dressing that lays the skin back on its bed, in kPa; 0 for none",
        default=Thin.dressing,
        min=0.0,
    )
    direction: FloatVectorProperty(
        name="Direction",
        description="Direction in which the blade goes into the tissue; zero to cut square to the skin everywhere",
        size=3,
        update=property_changed,
    )
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
    # Of a suture run: both edges are in `points`, first those of the first.
    second_from: count(name="Second Edge From", description="Number of points of the first edge", default=0, min=0)
    first_left: flag(
        name="First Edge Left",
        description="The tissue of the first edge lies to the left of its direction",
        default=True,
    )
    second_left: flag(
        name="Second Edge Left",
        description="The tissue of the second edge lies to the left of its direction",
        default=False,
    )
    spacing: FloatProperty(
        name="Spacing",
        description="Distance from stitch to stitch at least, in mm; those nearer than the lattice carries are merged",
        default=SutureRun.spacing,
        min=0.01,
        soft_min=0.5,
        soft_max=20.0,
        step=10,
        update=property_changed,
    )
    margin: number(
        name="Margin",
        description="Distance from ends and corners to the next stitch, in mm; -1 for half a distance between stitches",
        default=-1.0,
        min=-1.0,
    )
    bite: number(
        name="Bite",
        description="Distance of the bites from the edges, in mm; -1 for what is usual of the pattern",
        default=-1.0,
        min=-1.0,
        precision=3,
    )
    corners: CollectionProperty(type=LappetRunCorner)
    layers: CollectionProperty(type=LappetSutureLayer)
    sewn_in: EnumProperty(
        name="Layers",
        description="In which layers the run is sewn",
        items=LAYER_CHOICES,
        get=sewn_in,
        set=set_sewn_in,
    )
    pattern: choice(name="Pattern", description="What each stitch does", items=PATTERNS, default="INTERRUPTED")
    pass_depth: number(
        name="Pass Depth",
        description="Depth in which the thread of a pattern crosses the wound, in mm",
        default=SutureRun.pass_depth,
        min=0.0,
    )
    order: choice(name="Order", description="In which order the stitches are made", items=ORDERS, default="HALVING")
    drawn: number(
        name="Drawn",
        description="Share of the length at which the edges just meet to which threads are drawn",
        default=SutureRun.drawn,
        min=0.0,
        soft_max=1.5,
    )
    target: pointer(
        name="Target",
        description="The empty whose location (hook) or motion (retractor) is followed; keyframe it like any object",
        type=bpy.types.Object,
    )
    grip: text(name="Grip", description="The group of faces that the retractor holds")
    flap: StringProperty(options={"HIDDEN"})  # the laid flap that it belongs to (laid_flaps.py)
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


CLASSES = (LappetPoint, LappetRunCorner, LappetSutureLayer, LappetEvent)
