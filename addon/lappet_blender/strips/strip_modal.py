"""Dragging strips with the mouse: a press on a strip, an end or the name of a step, moves, a release."""

from __future__ import annotations

from typing import Any, ClassVar

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode

from ..interface.header_texts import clear_texts
from ..interface.operator_base import OperatorBase
from ..interface.said import said
from .scene_strips import chosen_strips, copy_strips, move_step, move_strips, scene_steps, scene_strips, select_strips
from .strip import Part, Step, Strip, strips_of_step
from .strip_drag import dragged, grabbed_edges, snap_targets, snapped
from .strip_layout import Hit
from .strip_view import StripPreview, clear_preview, hit_at, show_preview, view_of

PARTS = (
    (Part.BODY.value, "Whole Strips", "Events move to other frames, with their targets' keyframes"),
    (Part.START.value, "Starts", "Events begin at other frames and end as before"),
    (Part.END.value, "Ends", "Events end at other frames: hooks let go, sutures are closed"),
    (Part.STEP.value, "Step", "A marker and all events that begin between it and the next one"),
)
_SNAP_PIXELS = 7.0
_CLICK_PIXELS = 3.0  # a mouse that moved less has clicked
_FINEST = 0.01  # frames: what is dragged without snapping goes to hundredths
running: list[LAPPET_OT_strips_move] = []


class LAPPET_OT_strips_move(OperatorBase, bpy.types.Operator):
    """Move the strips of events, or drag one of their ends. Ctrl moves without snapping"""

    bl_label = "Move Strips"
    bl_options: ClassVar[set[str]] = {"REGISTER", "UNDO", "BLOCKING"}

    # Each begins anew: Blender would remember that the last strips were copied.
    events: StringProperty(
        name="Events",
        description="Names or identifiers; if not given, the selected strips",
        options={"SKIP_SAVE"},
    )
    part: EnumProperty(name="Part", items=PARTS, default=Part.BODY.value, options={"SKIP_SAVE"})
    shift: FloatProperty(
        name="Shift",
        description="Number of frames later",
        default=0.0,
        precision=2,
        step=100,
        options={"SKIP_SAVE"},
    )
    copy: BoolProperty(
        name="Copy", description="Add copies there and leave the events where they are", options={"SKIP_SAVE"}
    )
    step: IntProperty(
        name="Step",
        description="Frame of the marker with which the step begins",
        options={"HIDDEN", "SKIP_SAVE"},
        default=1,
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.scene is not None and len(context.scene.lappet.events) > 0

    def run(self, context: bpy.types.Context) -> None:
        scene = context.scene
        if Part(self.part) is Part.STEP:
            move_step(scene, _step_at(scene, self.step), self.shift)
        elif self.copy:
            copy_strips(scene, chosen_strips(scene, self.events), self.shift)
        elif self.shift:
            move_strips(scene, chosen_strips(scene, self.events), Part(self.part), self.shift)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        found = hit_at(context, event)
        if found is None:
            return {"PASS_THROUGH"}  # Blender's own: keyframes, markers, the playhead
        scene = context.scene
        self._scene, self._held = scene.name, event.type == "LEFTMOUSE"
        if not self._take(scene, found, bool(event.shift) and self._held):
            return {"FINISHED"}
        self._from = (event.mouse_region_x, event.mouse_region_y)
        self._frame = view_of(scene, context.space_data, context.region).frame(event.mouse_region_x)
        self._moved = not self._held
        self.shift = 0.0
        context.window_manager.modal_handler_add(self)
        running.append(self)
        self._show(context, event)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        scene = context.scene
        if scene is None or scene.name != self._scene or context.region is None:
            return self._end(context, {"CANCELLED"})
        kind, value = event.type, event.value
        if kind in ("MOUSEMOVE", "INBETWEEN_MOUSEMOVE") or "CTRL" in kind:
            self._show(context, event)
        elif kind in ("ESC", "RIGHTMOUSE") and value == "PRESS":
            return self._end(context, {"CANCELLED"})
        elif (kind in ("RET", "NUMPAD_ENTER") and value == "PRESS") or (
            kind == "LEFTMOUSE" and value == ("RELEASE" if self._held else "PRESS")
        ):
            return self._end(context, None)
        elif kind.startswith(("WHEEL", "MIDDLEMOUSE", "TRACKPAD")):
            return {"PASS_THROUGH"}
        return {"RUNNING_MODAL"}

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender ends the drag: another file is opened, the window is closed."""
        self._end(context, {"CANCELLED"})

    def _take(self, scene: bpy.types.Scene, found: Hit, extend: bool) -> bool:
        """Select what was hit; whether it is dragged then."""
        self._strips = scene_strips(scene)
        self.part = found.part.value
        if found.step is not None:
            self.copy = False
            self.step = round(found.step.start)
            self._grabbed: Strip | None = None
            self._dragged = [s for s in self._strips if s.uid in strips_of_step(found.step, self._strips)]
            select_strips(scene, [strip.uid for strip in self._dragged], extend)
            return True
        hit_strip = next(strip for strip in self._strips if strip.uid == found.uid)
        if extend or not hit_strip.selected:
            select_strips(scene, [found.uid], extend)
        else:
            select_active(scene, found.uid)
        if extend:
            return False
        if self.copy:
            self.part = Part.BODY.value
        self._strips = scene_strips(scene)
        alone = self.part != Part.BODY
        self._dragged = [s for s in self._strips if (s.uid == found.uid if alone else s.selected)]
        self._grabbed = hit_strip
        self.events = " ".join(strip.uid for strip in self._dragged)
        return True

    def _show(self, context: bpy.types.Context, event: bpy.types.Event) -> None:
        """The drag as far as it is, in the editor and its header."""
        away = abs(event.mouse_region_x - self._from[0]) + abs(event.mouse_region_y - self._from[1])
        self._moved = self._moved or away > _CLICK_PIXELS
        if not self._moved:
            return
        scene = context.scene
        view = view_of(scene, context.space_data, context.region)
        by_mouse = view.frame(event.mouse_region_x) - self._frame
        part = Part(self.part)
        line = None
        if event.ctrl and part is not Part.STEP:
            self.shift = round(by_mouse / _FINEST) * _FINEST
        else:
            edges = grabbed_edges(self._grabbed, part) if self._grabbed else (float(self.step),)
            moving = () if self.copy else {strip.uid for strip in self._dragged}
            steps = () if part is Part.STEP else scene_steps(scene)
            own = (float(scene.frame_current), float(scene.frame_start), float(scene.frame_end))
            targets = snap_targets(self._strips, moving, steps, own)
            if part is Part.STEP:
                targets = tuple(each for each in targets if each.is_integer())
            self.shift, line = snapped(by_mouse, edges, targets, _SNAP_PIXELS * view.points / view.scale)
        spans = dragged(self._dragged, part, self.shift)
        step = _step_at(scene, self.step) if part is Part.STEP else None
        show_preview(StripPreview(scene.name, spans, self.copy, line, step, self.shift))
        if context.area is not None:
            context.area.header_text_set(self._said(spans))

    def _said(self, spans: dict[str, Any]) -> str:
        """What the header says."""
        count = len(self._dragged)
        what = said("Strips: {count}", count=count)
        if self._grabbed is not None:
            name, span = self._grabbed.name, spans[self._grabbed.uid]
            name = said("Copy of {name}", name=name) if self.copy else name
            what = f"{name}: {span.start:g} – {span.end:g}"
            what += " " + said("and {count} more", count=count - 1) if count > 1 else ""
        return f"{what}, {said('{shift} frames', shift=f'{self.shift:+g}')}  ({said('Ctrl: no snapping, Esc: cancel')})"

    def _end(self, context: bpy.types.Context, result: set[str] | None) -> set[str]:
        """Take the preview away; result None: do what it showed."""
        if self in running:
            running.remove(self)
        clear_preview()
        if context.area is not None:
            context.area.header_text_set(None)
        if result is not None:
            return result
        if not self._moved and self._grabbed is not None:
            select_strips(context.scene, [self._grabbed.uid])  # a click on one of several that are selected
        if not self._moved or (not self.shift and not self.copy):
            return {"FINISHED"}  # what is selected is a step of undo
        return self.execute(context)


def select_active(scene: bpy.types.Scene, uid: str) -> None:
    """Make an event the active one and leave what is selected."""
    scene.lappet.active_event = next(k for k, event in enumerate(scene.lappet.events) if event.uid == uid)


def end_running() -> None:
    """End every drag, before its class goes: Blender frees it without a word to it."""
    running.clear()
    clear_preview()
    clear_texts()


def _step_at(scene: bpy.types.Scene, frame: int) -> Step:
    """The step whose marker is on a frame. Raises RefusedError where none is."""
    for step in scene_steps(scene):
        if round(step.start) == frame:
            return step
    raise refused(ProblemCode.STEP_UNKNOWN, "", frame)


CLASSES = (LAPPET_OT_strips_move,)
