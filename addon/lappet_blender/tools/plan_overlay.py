"""Draw the plan over the skin in 3D viewports, with the handles of the active event and what a tool shows."""

from __future__ import annotations

import math
from typing import Any

import blf
import bpy
import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader
from numpy.typing import NDArray

from lappet.geometry.triangles import area_normals, directions

from .edit_tool import HeldHandle
from .handles import handles_of
from .plan_lines import (
    EVENT_COLORS,
    HALO,
    STEEL,
    THREAD,
    Color,
    LineSet,
    add_event_lines,
    add_preview_lines,
    add_skin_lines,
    add_vessels,
    arrow,
    event_color,
    plan_key,
)
from .preview import Preview, preview_of, redraw
from .shown_surface import ShownSurface, shown_surface
from .view_under_mouse import project, viewer_of

EDIT_TOOL = "lappet.edit"
_WHITE: Color = (1.0, 1.0, 1.0, 1.0)
_TINT: Color = (1.0, 0.45, 0.2, 0.35)
_POLL = 0.1  # seconds
_handlers: list[Any] = []
_kept: dict[str, tuple[Any, LineSet]] = {}


def register() -> None:
    """Draw from now on; without windows there is nothing to draw into."""
    if not bpy.app.background and not _handlers:
        add = bpy.types.SpaceView3D.draw_handler_add
        _handlers.append(add(_draw_lines, (), "WINDOW", "POST_VIEW"))
        _handlers.append(add(_draw_points, (), "WINDOW", "POST_PIXEL"))


def unregister() -> None:
    """Draw no more."""
    for each in _handlers:
        bpy.types.SpaceView3D.draw_handler_remove(each, "WINDOW")
    _handlers.clear()
    _kept.clear()
    if bpy.app.timers.is_registered(_once_ready):
        bpy.app.timers.unregister(_once_ready)


def plan_lines(scene: bpy.types.Scene, surface: ShownSurface, hides: str = "", done: bool = True) -> LineSet:
    """The lines of all events as they are shown now; kept until something changes.

    hides: the uid of one left out. done: also of those that have begun, which the solved skin shows itself.
    """
    time = scene.frame_current_final
    key = (surface.key, plan_key(scene), time, hides, done)
    known = _kept.get(scene.name)
    if known is not None and known[0] == key:
        return known[1]
    line_set = LineSet()
    if done:  # whoever only looks at a solved skin wants no plan over it
        add_skin_lines(line_set, surface, scene)
        add_vessels(line_set, surface, scene)
    for index, event in enumerate(scene.lappet.events):
        active = index == scene.lappet.active_event
        seen = surface.solved and event.kind not in ("LANDMARK", "RETRACTOR") and event.start <= time
        if event.uid != hides and (done or active or not seen):
            add_event_lines(line_set, surface, event, time, active)
    _kept[scene.name] = (key, line_set)
    return line_set


def _shows(context: bpy.types.Context) -> bool:
    space = context.space_data
    return bool(space is not None and space.type == "VIEW_3D" and space.overlay.show_overlays)


def _plans(context: bpy.types.Context) -> bool:
    """Whether one of Lappet's tools is in hand: somebody plans, and does not only look."""
    tool = context.workspace.tools.from_space_view3d_mode("OBJECT", create=False)
    return tool is not None and tool.idname.startswith("lappet.") and not context.screen.is_animation_playing


def _surface(scene: bpy.types.Scene, viewport: bpy.types.SpaceView3D) -> ShownSurface | None:
    """The surface that is drawn on; None too while its searches are made, and then views are drawn anew."""
    surface = shown_surface(scene, viewport)
    if surface is None or surface.rest.is_ready:
        return surface
    if not bpy.app.timers.is_registered(_once_ready):
        bpy.app.timers.register(_once_ready, first_interval=_POLL)
    return None


def _once_ready() -> float | None:
    """Draw views anew once the surface of the scene that they show is ready."""
    surface = shown_surface(bpy.context.scene)
    if surface is not None and not surface.rest.is_ready:
        return _POLL
    redraw()
    return None


def _draw_lines() -> None:
    context = bpy.context
    scene = context.scene
    preview = preview_of(scene)
    if not _shows(context) or not (scene.lappet.look.show_plan or preview):
        return
    surface = _surface(scene, context.space_data)
    if surface is None:
        return
    gpu.state.blend_set("ALPHA")
    gpu.state.depth_test_set("LESS_EQUAL")
    if scene.lappet.look.show_plan:
        _draw_line_set(plan_lines(scene, surface, preview.hides if preview else "", _plans(context)))
    if preview is not None:
        _draw_preview(surface, preview)
    gpu.state.depth_test_set("NONE")
    gpu.state.blend_set("NONE")


def _draw_preview(surface: ShownSurface, preview: Preview) -> None:
    if preview.faces is not None and len(preview.faces):
        corners = preview.faces
        lifted = corners + directions(area_normals(corners))[:, None] * (0.15 / surface.mm)
        shader = gpu.shader.from_builtin("UNIFORM_COLOR")
        shader.uniform_float("color", _TINT)
        batch_for_shader(shader, "TRIS", {"pos": lifted.reshape(-1, 3).astype(np.float32)}).draw(shader)
    line_set = LineSet()
    for line in preview.lines:
        add_preview_lines(line_set, surface, line, EVENT_COLORS[preview.kind])
    gpu.state.depth_test_set("NONE")
    for a, b in preview.threads:
        line_set.line(np.array([a, b], np.float64), THREAD)
    for a, b in preview.arrows:
        for part in arrow(np.array(a, np.float64), np.array(b, np.float64)):
            line_set.line(part, STEEL)
    _draw_line_set(line_set)


def _draw_line_set(line_set: LineSet) -> None:
    shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    shader.bind()
    shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
    scale = bpy.context.preferences.system.ui_scale
    for (color, width), pieces in sorted(line_set.segments.items(), key=lambda item: -item[0][1]):  # halos lie below
        shader.uniform_float("lineWidth", width * scale)
        shader.uniform_float("color", color)
        points = np.concatenate(pieces).astype(np.float32)
        batch_for_shader(shader, "LINES", {"pos": points}).draw(shader)


def _draw_points() -> None:
    context = bpy.context
    scene, data, region = context.scene, context.region_data, context.region
    preview = preview_of(scene)
    if not _shows(context) or data is None or not (scene.lappet.look.show_plan or preview):
        return
    surface = _surface(scene, context.space_data)
    if surface is None:
        return
    size = (region.width, region.height)
    scale = context.preferences.system.ui_scale
    gpu.state.blend_set("ALPHA")
    if scene.lappet.look.show_plan:
        if not context.screen.is_animation_playing:
            _draw_handles(context, size, scale)
        for place, text, color in plan_lines(scene, surface, preview.hides if preview else "", _plans(context)).labels:
            (x, y) = project(data.perspective_matrix, *size, place)[0]
            if math.isfinite(x):
                _label(x + 8.0 * scale, y + 6.0 * scale, text, color, scale)
    if preview is not None and (preview.dots or preview.snap):
        places = surface.carry(
            surface.rest.locate(np.array([*preview.dots, *([preview.snap] if preview.snap else [])]))
        )
        pixels = project(data.perspective_matrix, *size, places)
        for k, pixel in enumerate(pixels):
            snapped = preview.snap is not None and k == len(pixels) - 1
            _disc(pixel, (8.0 if snapped else 5.0) * scale, HALO if snapped else _WHITE)
            _disc(pixel, 3.5 * scale, EVENT_COLORS[preview.kind])
    gpu.state.blend_set("NONE")


def _draw_handles(context: bpy.types.Context, size: tuple[int, int], scale: float) -> None:
    """The active event's points; with the tool Select/Edit in hand those of all events."""
    scene, data = context.scene, context.region_data
    events = scene.lappet.events
    active = events[scene.lappet.active_event].uid if 0 <= scene.lappet.active_event < len(events) else ""
    tool = context.workspace.tools.from_space_view3d_mode("OBJECT", create=False)
    editing = tool is not None and tool.idname == EDIT_TOOL
    if not (active or editing):
        return
    colors = {event.uid: event_color(event) for event in events}
    viewer = viewer_of(data)
    for handle in handles_of(scene, scene.frame_current_final, context.space_data):
        mine = handle.event_uid == active
        if (mine or editing) and handle.faces(*viewer):
            (pixel,) = project(data.perspective_matrix, *size, handle.world)
            held = mine and HeldHandle.uid == active and HeldHandle.index == handle.index
            _disc(pixel, (6.0 if mine else 4.0) * scale, HALO if held else _WHITE)
            _disc(pixel, (4.0 if mine else 2.5) * scale, colors[handle.event_uid])


def _disc(center: NDArray[np.float64], radius: float, color: Color) -> None:
    if not np.isfinite(center).all():
        return
    angle = np.linspace(0.0, 2.0 * np.pi, 17)
    rim = center + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    corners = np.stack([np.broadcast_to(center, rim[1:].shape), rim[:-1], rim[1:]], axis=1).reshape(-1, 2)
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    shader.uniform_float("color", color)
    flat = np.column_stack([corners, np.zeros(len(corners))]).astype(np.float32)
    batch_for_shader(shader, "TRIS", {"pos": flat}).draw(shader)


def _label(x: float, y: float, text: str, color: Color, scale: float) -> None:
    blf.size(0, 13.0 * scale)
    blf.enable(0, blf.SHADOW)
    blf.shadow(0, 5, 1.0, 1.0, 1.0, 0.9)
    blf.color(0, *color)
    blf.position(0, x, y, 0.0)
    blf.draw(0, text)
    blf.disable(0, blf.SHADOW)
