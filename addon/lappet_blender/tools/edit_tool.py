"""The tool Select/Edit: takes hold of what was placed, moves it along the skin, inserts and removes points."""

import bpy
import numpy as np
from bpy.props import BoolProperty
from mathutils import Vector

from ..events.edit_events import jump_to_event
from ..events.edit_points import MIN_POINTS, remove_point
from ..events.operator_values import named_event
from ..interface.operator_base import NO_UNDO, OperatorBase
from ..interface.said import said
from ..model.event_list import find_event, remove_event
from .drawing import DrawnLine, Point
from .handles import (
    LINE_KINDS,
    SKIN_KINDS,
    TARGET,
    Handle,
    event_points,
    handles_of,
    indices_at,
    is_closed,
    nearest_handle,
    nearest_line,
)
from .point_edit import distinct_points, insert_nearest, move_points, remove_points
from .preview import Preview, redraw, show_preview
from .shown_surface import shown_surface
from .skin_modal import Result, SkinModal
from .view_under_mouse import View, view_under

RADIUS = 12.0


class HeldHandle:
    """The handle that was clicked last: what Delete and G act on. Of the session, not of the file."""

    uid = ""
    index = 0

    @classmethod
    def hold(cls, uid: str, index: int) -> None:
        cls.uid, cls.index = uid, index

    @classmethod
    def of(cls, scene: bpy.types.Scene) -> tuple[bpy.types.PropertyGroup, int] | None:
        """The event and the index, if they are still there and the event is the active one."""
        events = scene.lappet.events
        active = scene.lappet.active_event
        if not 0 <= active < len(events) or events[active].uid != cls.uid:
            return None
        there = cls.index == TARGET or cls.index < len(events[active].points)
        return (events[active], cls.index) if there else None


def handle_under(context: bpy.types.Context, view: View) -> Handle | None:
    """The handle under the mouse; of two as near the active event's."""
    scene = context.scene
    active = scene.lappet.active_event
    prefer = scene.lappet.events[active].uid if 0 <= active < len(scene.lappet.events) else ""
    radius = RADIUS * context.preferences.system.ui_scale
    handles = [each for each in handles_of(scene, scene.frame_current, view.space) if each.faces(*view.viewer)]
    return nearest_handle(handles, view.project, view.mouse, radius, prefer)


def select(context: bpy.types.Context, uid: str, index: int) -> None:
    """Make an event the active one and hold one of its handles; a target becomes the selected object."""
    scene = context.scene
    scene.lappet.active_event = next(k for k, event in enumerate(scene.lappet.events) if event.uid == uid)
    HeldHandle.hold(uid, index)
    event = find_event(scene, uid)
    if index == TARGET and event is not None and event.target.name in context.view_layer.objects:
        for each in context.selected_objects:
            each.select_set(False)
        event.target.select_set(True)
        context.view_layer.objects.active = event.target


class LAPPET_OT_edit_plan(SkinModal, bpy.types.Operator):
    """Select an event by its points or line and drag its points along the skin. Ctrl-click a line to insert a point"""

    bl_label = "Edit Plan"
    title = "Edit"
    hints = (
        ("MOUSE_LMB_DRAG", "Move along the skin"),
        ("MOUSE_MOVE", "Target: in the view"),
        ("EVENT_RETURN", "Finish"),
        ("EVENT_ESC", "Cancel"),
    )

    grab: BoolProperty(options={"HIDDEN", "SKIP_SAVE"})
    insert: BoolProperty(options={"HIDDEN", "SKIP_SAVE"})
    extend: BoolProperty(options={"HIDDEN", "SKIP_SAVE"})

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> Result:
        view = view_under(context, (event.mouse_x, event.mouse_y))
        if view is None:
            return {"CANCELLED", "PASS_THROUGH"}
        self.uid, self.index = "", 0
        self.rest: Point | None = None
        self.base: Vector | None = None
        self.place: Vector | None = None
        self.changed = False
        self._moved = False
        if self.grab:
            held = HeldHandle.of(context.scene)
            if held is None:
                return {"CANCELLED", "PASS_THROUGH"}
            self.uid, self.index = held[0].uid, held[1]
        elif not self._take(context, view):  # a click beside the plan selects objects, as in Blender's own tools
            how = {"toggle": True} if self.extend else {"deselect_all": True}
            chosen = "FINISHED" in bpy.ops.view3d.select("INVOKE_DEFAULT", **how)
            return {"FINISHED"} if chosen else {"CANCELLED"}
        event_held = find_event(context.scene, self.uid)
        if self.index == TARGET and event_held is not None:
            self.base = event_held.target.matrix_world.translation.copy()
        self._mouse = view.mouse
        return SkinModal.invoke(self, context, event)

    def _take(self, context: bpy.types.Context, view: View) -> bool:
        """Take hold of what is under the mouse; whether there is anything."""
        scene = context.scene
        handle = None if self.insert else handle_under(context, view)
        if handle is not None:
            self.uid, self.index = handle.event_uid, handle.index
            select(context, self.uid, self.index)
            return True
        surface = shown_surface(scene, view.space)
        radius = RADIUS * context.preferences.system.ui_scale
        uid = None if surface is None else nearest_line(scene, surface, view.project, view.mouse, radius)
        event = find_event(scene, uid or "")
        if event is None:
            return False
        index = 0
        hit = view.pick(scene, any_face=True)
        if self.insert and event.kind in LINE_KINDS and hit is not None:
            index = self._insert(event, hit.rest)
        self.uid, self.index = event.uid, max(index, 0) if self.insert else -2
        select(context, self.uid, max(index, 0))
        return True

    def _insert(self, event: bpy.types.PropertyGroup, rest: Point) -> int:
        """Insert a point into a line; -1 where that is refused."""
        inserted: list[int] = []
        self.changed = self.attempt(lambda: inserted.append(insert_nearest(event, rest)))
        return inserted[0] if self.changed else -1

    def pressed(self, context: bpy.types.Context, view: View) -> Result | None:
        return self._finish(context) if self.grab else None

    def moved(self, context: bpy.types.Context, view: View | None) -> Result | None:
        event = find_event(context.scene, self.uid)
        if event is None:
            return {"CANCELLED"}
        away = 0.0 if view is None else float(np.hypot(*np.subtract(view.mouse, self._mouse)))
        if view is None or self.index < TARGET or not (self._moved or self.grab or away > 3.0):
            return None
        self._moved = True
        if self.index == TARGET and self.base is not None:
            self.place = view.on_plane_through(self.base)
            _put(event.target, self.place)
            redraw()
            return None
        hit = view.pick(context.scene, any_face=event.kind not in SKIN_KINDS)
        if hit is not None:
            self.rest = hit.rest
            show_preview(self._preview(context, event))
        return None

    def _preview(self, context: bpy.types.Context, event: bpy.types.PropertyGroup) -> Preview:
        points = event_points(event)
        points[indices_at(event, self.index)] = self.rest
        places = tuple((float(x), float(y), float(z)) for x, y, z in points)
        preview = Preview(context.scene.name, dots=list(places), snap=self.rest, hides=event.uid, kind=event.kind)
        if event.kind in LINE_KINDS:
            preview.lines = [DrawnLine(places, event.basis, is_closed(event))]
        elif event.kind == "SUTURE":
            preview.lines = [DrawnLine(places, "LINEAR", False)]
        elif event.kind == "SUTURE_RUN":
            edges = places[: event.second_from], places[event.second_from :]
            preview.lines = [DrawnLine(edge, "LINEAR", False) for edge in edges if len(edge) > 1]
        return preview

    def released(self, context: bpy.types.Context, view: View | None) -> Result | None:
        return None if self.grab else self._finish(context)

    def confirmed(self, context: bpy.types.Context) -> Result | None:
        return self._finish(context)

    def _finish(self, context: bpy.types.Context) -> Result:
        event = find_event(context.scene, self.uid)
        if event is None:
            return {"CANCELLED"}
        if self.index == TARGET and self._moved:
            key_here(event.target, context.scene.frame_current)
        elif self.rest is not None:
            rest = self.rest
            if not self.attempt(lambda: move_points(event, self.index, rest)):
                return {"CANCELLED"}
        return {"FINISHED"}  # a click that only selects is a step of undo too, as selecting objects is

    def abandoned(self, context: bpy.types.Context) -> None:
        event = find_event(context.scene, self.uid)
        if event is None:
            return
        if self.base is not None and event.target is not None:
            _put(event.target, self.base)
        if self.changed:
            self.attempt(lambda: remove_point(context.scene, event, self.index))

    def text(self, context: bpy.types.Context) -> str:
        event = find_event(context.scene, self.uid)
        return said(self.title) if event is None else said("Edit {event}: drag along the skin", event=event.name)


class LAPPET_OT_edit_delete(OperatorBase, bpy.types.Operator):
    """Remove the last point clicked, or its event"""

    bl_label = "Delete Point or Event"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        scene = context.scene
        return scene is not None and 0 <= scene.lappet.active_event < len(scene.lappet.events)

    def run(self, context: bpy.types.Context) -> None:
        scene = context.scene
        active = scene.lappet.events[scene.lappet.active_event]
        held = HeldHandle.of(scene)
        try:
            if held is not None and held[1] >= 0 and distinct_points(active) > MIN_POINTS.get(active.kind, 99):
                remove_points(active, held[1])
            else:
                remove_event(scene, active)
        finally:
            redraw()


class LAPPET_OT_edit_jump(OperatorBase, bpy.types.Operator):
    """Go to the frame of the event under the mouse"""

    bl_label = "Jump to Event"
    bl_options = NO_UNDO

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> Result:
        view = view_under(context, (event.mouse_x, event.mouse_y))
        handle = handle_under(context, view) if view is not None else None
        surface = shown_surface(context.scene, view.space) if view is not None else None
        uid = handle.event_uid if handle is not None else None
        if uid is None and view is not None and surface is not None:
            radius = RADIUS * context.preferences.system.ui_scale
            uid = nearest_line(context.scene, surface, view.project, view.mouse, radius)
        if uid is None:
            return {"CANCELLED", "PASS_THROUGH"}
        select(context, uid, handle.index if handle is not None else 0)
        return self.execute(context)

    def run(self, context: bpy.types.Context) -> None:
        jump_to_event(context.scene, named_event(context.scene, ""))


def key_here(empty: bpy.types.Object, frame: float) -> None:
    """Keep the place of an empty that is keyframed: a key at this frame, so that the next frame does not take it."""
    data = empty.animation_data
    if data is not None and data.action is not None:
        empty.keyframe_insert("location", frame=frame)


def _put(target: bpy.types.Object, place: Vector) -> None:
    """Move an object to a place in the world, whatever it is parented to."""
    matrix = target.matrix_world.copy()
    matrix.translation = place
    target.matrix_world = matrix


CLASSES = (LAPPET_OT_edit_plan, LAPPET_OT_edit_delete, LAPPET_OT_edit_jump)
