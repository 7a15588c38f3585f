"""The tool Suture: click the two edges of a wound, or sew a run along them."""

import bpy
import numpy as np
from bpy.props import CollectionProperty, EnumProperty, FloatProperty, IntProperty, StringProperty
from mathutils import Vector

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Suture

from ..events.add_suture_run import add_suture_run, edges_along, edges_between
from ..events.add_sutures import (
    Spacing,
    SutureTimes,
    add_single_sutures,
    add_stitches,
    add_suture,
    ends_across,
    ends_between,
)
from ..events.operator_values import given, places
from ..events.stitch_properties import drawn_property, order_property, shape_property, single_property
from ..events.stitch_shapes import Shape
from ..interface.said import said
from ..model.event_kinds import ORDER_OF
from ..model.event_properties import LappetPoint
from .drawing import DrawnLine, Point
from .handles import nearest_line
from .preview import Preview, show_preview
from .shown_surface import shown_surface
from .skin_modal import Result, SkinModal, check_tissue
from .view_under_mouse import View

MODES = (
    ("ONE", "One", "One suture: click one edge of the wound, then the other"),
    ("RUN", "Run", "Evenly spaced sutures: click along one edge, Return, then along the other"),
    ("INCISION", "Incision", "Evenly spaced sutures along an incision that is clicked"),
)


class LAPPET_OT_place_suture(SkinModal, bpy.types.Operator):
    """Place a suture: click one edge of the wound, then the other"""

    bl_label = "Place Suture"
    title = "Suture"
    hints = (
        ("MOUSE_LMB", "Click the edges"),
        ("EVENT_SHIFT", "Start a run"),
        ("EVENT_RETURN", "Next edge, finish"),
        ("EVENT_BACKSPACE", "Undo last"),
        ("EVENT_ESC", "Cancel"),
    )

    mode: EnumProperty(name="Mode", items=MODES)
    first: CollectionProperty(type=LappetPoint, options={"HIDDEN", "SKIP_SAVE"})
    second: CollectionProperty(type=LappetPoint, options={"HIDDEN", "SKIP_SAVE"})
    incision: StringProperty(name="Incision", options={"HIDDEN", "SKIP_SAVE"})
    time: FloatProperty(name="Frame", description="The frame at which it starts to close", options={"SKIP_SAVE"})
    spacing: FloatProperty(
        name="Spacing", description="Distance between the sutures of a run, in mm", default=4.0, min=0.2, soft_max=30.0
    )
    count: IntProperty(
        name="Count", description="Number of sutures in the run; 0 = from the spacing", default=0, min=0, max=500
    )
    duration: FloatProperty(name="Duration", description="Number of frames until it is closed", default=12.0, min=0.0)
    stiffness: FloatProperty(
        name="Stiffness", description="In mN/mm", default=Suture.stiffness, min=0.001, soft_max=5000.0
    )
    bite: FloatProperty(
        name="Bite",
        description="Distance from the middle of the incision to an anchor, in mm; 0 = at the wound edge. Of a shape: "
        "from the wound edge; 0 = as is usual",
        default=0.0,
        min=0.0,
    )
    order: order_property()
    single: single_property()
    shape: shape_property()
    drawn: drawn_property()
    depth: FloatProperty(
        name="Depth",
        description="Depth of the anchors below the skin, in mm: a buried row holds the wound walls together",
        default=0.0,
        min=0.0,
        soft_max=10.0,
    )

    def begin(self, context: bpy.types.Context) -> None:
        self.edges: list[list[Point]] = [[], []]
        self.on_second = False
        self.is_run = self.mode == "RUN"
        self.hover: Point | None = None
        self._said = ""

    def pressed(self, context: bpy.types.Context, view: View) -> Result | None:
        if self.mode == "INCISION":
            return self._suture_incision(context, view)
        hit = view.pick(context.scene, any_face=True)
        if hit is None:
            self._said = "the mouse is not on the tissue; "
            return self.moved(context, view)
        self._said = ""
        self.is_run = self.is_run or (self.shift and not self.on_second)
        self.edges[self.on_second].append(hit.rest)
        if not self.is_run:
            if self.on_second:
                return self._place_sutures(context)
            self.on_second = True
        return self.moved(context, view)

    def moved(self, context: bpy.types.Context, view: View | None) -> Result | None:
        if view is None:
            return None
        hit = view.pick(context.scene, any_face=True)
        self.hover = None if hit is None else hit.rest
        preview = Preview(context.scene.name, dots=[*self.edges[0], *self.edges[1]], kind="SUTURE")
        for index, edge in enumerate(self.edges):
            live = [*edge, *([self.hover] if self.is_run and self.hover and index == self.on_second else [])]
            if len(live) > 1:
                preview.lines.append(DrawnLine(tuple(live), "LINEAR", False))
        surface = shown_surface(context.scene, view.space)
        if surface is not None and not self.is_run and self.edges[0]:
            start = surface.carry(surface.rest.locate(np.array(self.edges[0]), skin_only=False))[0]
            end = hit.world if hit is not None else view.on_plane_through(Vector(start.tolist()))
            preview.threads.append((Vector(start.tolist()), end))
        show_preview(preview)
        return None

    def confirmed(self, context: bpy.types.Context) -> Result | None:
        if not self.edges[0]:
            return {"CANCELLED"}
        if not self.is_run:
            self._said = "click the other edge; "
            return None
        if len(self.edges[self.on_second]) < 2:
            self._said = "an edge needs two points; "
            return None
        if self.on_second:
            return self._place_sutures(context)
        self.on_second = True
        return None

    def double_clicked(self, context: bpy.types.Context, view: View) -> Result | None:
        return self.confirmed(context) if self.is_run else self.pressed(context, view)

    def key(self, context: bpy.types.Context, key: str) -> Result | None:
        if key == "BACK_SPACE":
            if not self.edges[self.on_second]:
                if not self.on_second:
                    return {"CANCELLED"}
                self.on_second = False
            self.edges[self.on_second].pop()
        return None

    def text(self, context: bpy.types.Context) -> str:
        if self.mode == "INCISION":
            pattern = "{tool} at frame {frame}: {note}click an incision to sew it"
        elif self.is_run and self.on_second:
            pattern = "Run of sutures at frame {frame}: {note}click along the second edge, then Return"
        elif self.is_run:
            pattern = "Run of sutures at frame {frame}: {note}click along the first edge, then Return"
        elif self.on_second:
            pattern = "{tool} at frame {frame}: {note}click the second edge of the wound"
        else:
            pattern = "{tool} at frame {frame}: {note}click the first edge of the wound"
        return said(pattern, tool=said(self.title), frame=context.scene.frame_current, note=self._said)

    def _suture_incision(self, context: bpy.types.Context, view: View) -> Result | None:
        surface = shown_surface(context.scene, view.space)
        radius = 20.0 * context.preferences.system.ui_scale
        uid = surface and nearest_line(context.scene, surface, view.project, view.mouse, radius, ("INCISION",))
        event = next((e for e in context.scene.lappet.events if e.uid == uid), None)
        if surface is None or event is None:
            self._said = "no incision is near the mouse; "
            return None
        self.incision = event.name
        return self._place_sutures(context)

    def _place_sutures(self, context: bpy.types.Context) -> Result:
        for collection, edge in ((self.first, self.edges[0]), (self.second, self.edges[1])):
            collection.clear()
            for point in edge:
                collection.add().co = point
        self.time = context.scene.frame_current
        return self.execute(context)

    def run(self, context: bpy.types.Context) -> None:
        scene = context.scene
        check_tissue(context)
        if not self.incision and not (self.first and self.second):
            raise refused(ProblemCode.SUTURE_NO_EDGES)
        times = SutureTimes(given(self, "time", scene.frame_current), self.duration, self.stiffness)
        shape = Shape(self.shape, self.bite, self.depth, self.drawn)
        if len(self.first) == len(self.second) == 1:
            if shape.is_loop:
                add_stitches(scene, (np.array(places(self.first)), np.array(places(self.second))), times, shape)
                return
            add_suture(scene, self.first[0].co, self.second[0].co, times, depth=self.depth)
            return
        spacing = Spacing(self.count, self.spacing)
        if not self.single:
            if self.incision:
                edges = edges_along(scene, self.incision, self.bite, shape)
            else:
                back = _runs_back(self.first, self.second)
                edges = edges_between(scene, places(self.first), places(self.second), back, shape)
            add_suture_run(scene, edges, times, shape, spacing, order=ORDER_OF[self.order])
            return
        if self.incision:
            ends = ends_across(scene, self.incision, 0.0 if shape.is_loop else self.bite, spacing)
        else:
            back = _runs_back(self.first, self.second)
            ends = ends_between(places(self.first), places(self.second), back, spacing)
        if shape.is_loop:
            add_stitches(scene, ends, times, shape)
            return
        add_single_sutures(scene, ends, times, depth=self.depth)

    def draw(self, _context: bpy.types.Context) -> None:
        self.layout.use_property_split = True
        self.layout.prop(self, "time")
        if self.incision or len(self.first) > 1:
            self.layout.prop(self, "count")
            self.layout.prop(self, "spacing")
            self.layout.prop(self, "single")
            if not self.single:
                self.layout.prop(self, "order")
        self.layout.prop(self, "shape")
        if self.shape != "POINTS":
            self.layout.prop(self, "bite")
            self.layout.prop(self, "drawn")
        self.layout.prop(self, "depth")
        self.layout.prop(self, "duration")
        self.layout.prop(self, "stiffness")


def _runs_back(first: bpy.types.Collection, second: bpy.types.Collection) -> bool:
    """Whether the second edge was clicked the other way round: its last point is the one beside the first's first."""
    a, b = ([Vector(edge[k].co) for k in (0, -1)] for edge in (first, second))
    return bool((a[0] - b[1]).length + (a[1] - b[0]).length < (a[0] - b[0]).length + (a[1] - b[1]).length)


CLASSES = (LAPPET_OT_place_suture,)
