"""The tools Incision, Undermine and Thin: a line clicked or drawn on the skin."""

from typing import Any, ClassVar

import bpy
import numpy as np
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, FloatProperty

from lappet.procedure import Incision

from ..events.add_events import add_incision, add_thinning, add_undermining
from ..events.operator_values import given, places
from ..interface.said import said
from ..model.event_kinds import BASES, BASIS_OF
from ..model.event_properties import LappetPoint
from .drawing import LineDrawing, Point
from .handles import event_points
from .preview import Preview, show_preview
from .rest_line import line_length
from .shown_surface import shown_surface
from .skin_modal import Result, SkinModal, check_tissue
from .view_under_mouse import View

SNAP_PIXELS = 12.0
_HINTS = (
    ("MOUSE_LMB", "Add point"),
    ("MOUSE_LMB_DRAG", "Draw freehand"),
    ("EVENT_CTRL", "Snap to incisions"),
    ("EVENT_BACKSPACE", "Undo last"),
)
_END_HINTS = (("EVENT_RETURN", "Finish"), ("MOUSE_RMB", "Finish"), ("EVENT_ESC", "Cancel"))

LINES = (
    ("STRAIGHT", "Straight", "Straight from click to click"),
    ("SMOOTH", "Smooth", "A smooth curve through the clicks"),
)


class _LineTool(SkinModal):
    """What the tools share: `self.drawing` is the state machine, snapping is here since it is in pixels.

    settings: properties of the tool's own, shown for the last operation.
    """

    kind: ClassVar[str] = "INCISION"
    must_close: ClassVar[bool] = False
    settings: ClassVar[tuple[str, ...]] = ()

    layout: Any
    points: CollectionProperty(type=LappetPoint, options={"HIDDEN", "SKIP_SAVE"})
    time: FloatProperty(name="Frame", description="The frame of the cut", options={"SKIP_SAVE"})
    basis: EnumProperty(name="Curve", items=BASES, options={"HIDDEN", "SKIP_SAVE"})
    closed: BoolProperty(name="Closed", options={"HIDDEN", "SKIP_SAVE"})
    line: EnumProperty(name="Line", description="Shape of the line between clicked points", items=LINES)
    tolerance: FloatProperty(
        name="Smoothing",
        description="Largest distance between the line and a freehand stroke, in mm",
        default=0.4,
        min=0.01,
        soft_max=3.0,
    )

    def begin(self, context: bpy.types.Context) -> None:
        self.drawing = LineDrawing(self.line == "SMOOTH", self.must_close, self.tolerance)
        self.snap: Point | None = None
        self._said = ""

    def _place(self, context: bpy.types.Context, view: View | None) -> Point | None:
        """The rest point under the mouse, snapped."""
        self.snap = None
        if view is None:
            return None
        targets: list[Point] = []
        if len(self.drawing.points) >= 3 and not self.drawing.dragging:
            targets.append(self.drawing.points[0])
        if self.ctrl:
            targets += incision_ends(context.scene)
        surface = shown_surface(context.scene, view.space)
        if targets and surface is not None:
            pixels = view.project(surface.carry(surface.rest.locate(np.array(targets))))
            away = np.nan_to_num(np.linalg.norm(pixels - view.mouse, axis=1), nan=np.inf)
            nearest = int(away.argmin())
            if away[nearest] <= SNAP_PIXELS * context.preferences.system.ui_scale:
                self.snap = targets[nearest]
                return self.snap
        hit = view.pick(context.scene)
        return None if hit is None else hit.rest

    def pressed(self, context: bpy.types.Context, view: View) -> Result | None:
        place = self._place(context, view)
        points = self.drawing.points
        if self.snap is not None and len(points) >= 3 and self.snap == points[0]:
            self.drawing.close()
            return self.confirmed(context)
        self._said = "" if self.drawing.press(place, view.mouse) else "The mouse is not on the skin. "
        self._show(context)
        return None

    def moved(self, context: bpy.types.Context, view: View | None) -> Result | None:
        if view is not None:
            self.drawing.move(self._place(context, view), view.mouse)
        self._show(context)
        return None

    def released(self, context: bpy.types.Context, view: View | None) -> Result | None:
        self.drawing.release()
        self._show(context)
        return None

    def double_clicked(self, context: bpy.types.Context, view: View) -> Result | None:
        return self.confirmed(context)

    def key(self, context: bpy.types.Context, key: str) -> Result | None:
        if key == "BACK_SPACE":
            return None if self.drawing.back() else {"CANCELLED"}
        if key == "C":
            if self.drawing.close():
                return self.confirmed(context)
            self._said = "A closed line needs three points. "
        return None

    def confirmed(self, context: bpy.types.Context) -> Result | None:
        line = self.drawing.finish()
        if line is None:
            self._said = self.drawing.problem() + " "
            self.drawing.closed = False
            return None if self.drawing.points else {"CANCELLED"}
        self.points.clear()
        for point in line.points:
            self.points.add().co = point
        self.basis, self.closed = line.basis, line.closed
        self.time = context.scene.frame_current
        return self.execute(context)

    def text(self, context: bpy.types.Context) -> str:
        line, surface = self.drawing.preview(), shown_surface(context.scene, context.space_data)
        if line is None or surface is None:
            return said("{tool}: {note}click on the skin, or draw", tool=said(self.title), note=self._said)
        length = line_length(surface.rest, line.points, line.basis, line.closed) if len(line.points) > 1 else 0.0
        count = len(self.drawing.points)
        frame = context.scene.frame_current
        pattern, values = (
            "{tool} at frame {frame}: {note}{length} mm, points: {count}",
            {"frame": frame, "count": count},
        )
        return said(pattern, tool=said(self.title), note=self._said, length=f"{length:.1f}", **values)

    def run(self, context: bpy.types.Context) -> None:
        check_tissue(context)
        self.cut(context.scene, places(self.points), given(self, "time", context.scene.frame_current))

    def cut(self, scene: bpy.types.Scene, points: list[Point], time: float) -> None:
        """Add the event of the line, points at rest in mm."""
        raise NotImplementedError

    def draw(self, _context: bpy.types.Context) -> None:
        self.layout.use_property_split = True
        for name in ("time", *self.settings):
            self.layout.prop(self, name)

    def _show(self, context: bpy.types.Context) -> None:
        line = self.drawing.preview()
        dots = [] if self.drawing.dragging else self.drawing.points
        preview = Preview(context.scene.name, lines=[line] if line else [], dots=list(dots), snap=self.snap)
        preview.kind = self.kind
        show_preview(preview)


def incision_ends(scene: bpy.types.Scene) -> list[Point]:
    """The first and last points of a scene's open incisions, at rest in mm."""
    ends: list[Point] = []
    for event in scene.lappet.events:
        if event.kind == "INCISION" and not event.closed and len(event.points) > 1:
            for x, y, z in event_points(event)[[0, -1]].tolist():
                ends.append((x, y, z))
    return ends


class LAPPET_OT_draw_incision(_LineTool, bpy.types.Operator):
    """Draw an incision: click points on the skin, or draw with the button held"""

    bl_label = "Draw Incision"
    title, kind = "Incision", "INCISION"
    hints = (*_HINTS, ("EVENT_C", "Close"), *_END_HINTS)

    through: BoolProperty(name="Through", description="Cut through the whole tissue", default=True)
    depth: FloatProperty(
        name="Depth", description="Depth of the cut below the skin, in mm", default=2.0, min=0.01, soft_max=20.0
    )
    kerf: FloatProperty(
        name="Kerf", description="Width of the cut in mm", default=Incision.kerf, min=0.001, soft_max=1.0, precision=3
    )

    def cut(self, scene: bpy.types.Scene, points: list[Point], time: float) -> None:
        depth, basis = None if self.through else self.depth, BASIS_OF[self.basis]
        add_incision(scene, points, time, depth=depth, kerf=self.kerf, basis=basis, closed=self.closed)

    def draw(self, context: bpy.types.Context) -> None:
        super().draw(context)
        draw_incision_settings(self.layout, self)


class _OutlineTool(_LineTool):
    """Tools whose line goes around an area."""

    hints = (*_HINTS, ("EVENT_C", "Close and finish"), *_END_HINTS)
    must_close = True


class LAPPET_OT_draw_undermining(_OutlineTool, bpy.types.Operator):
    """Draw the outline of an area to free from its bed"""

    bl_label = "Draw Undermining"
    title, kind = "Undermine", "UNDERMINE"

    def cut(self, scene: bpy.types.Scene, points: list[Point], time: float) -> None:
        add_undermining(scene, points, time, basis=BASIS_OF[self.basis])


class LAPPET_OT_draw_thinning(_OutlineTool, bpy.types.Operator):
    """Draw the outline of an area whose deep tissue is taken away"""

    bl_label = "Draw Thinning"
    title, kind, settings = "Thin", "THIN", ("thickness",)

    thickness: FloatProperty(
        name="Thickness Left",
        description="What stays below the skin, skin included, in mm",
        default=2.0,
        min=0.01,
        soft_max=20.0,
    )

    def cut(self, scene: bpy.types.Scene, points: list[Point], time: float) -> None:
        add_thinning(scene, points, time, self.thickness, basis=BASIS_OF[self.basis])


def draw_incision_settings(layout: bpy.types.UILayout, owner: Any) -> None:
    """Depth and kerf of an incision, in a header or a panel."""
    layout.prop(owner, "through")
    row = layout.row()
    row.enabled = not owner.through
    row.prop(owner, "depth")
    layout.prop(owner, "kerf")


CLASSES = (LAPPET_OT_draw_incision, LAPPET_OT_draw_undermining, LAPPET_OT_draw_thinning)
