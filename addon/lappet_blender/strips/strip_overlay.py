"""Draw the strips and the steps over the Timeline and the Dope Sheet."""

from __future__ import annotations

from typing import Any

import blf
import bpy
import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader
from numpy.typing import NDArray

from . import strip_view
from .strip_layout import NAMED, StripBox, StripPicture
from .strip_view import picture_in, shows_strips, view_of

Color = tuple[float, float, float, float]
LANE_COLORS: tuple[Color, ...] = ((0.78, 0.33, 0.29, 1.0), (0.30, 0.52, 0.80, 1.0), (0.36, 0.62, 0.36, 1.0))
_GROUND: Color = (0.09, 0.09, 0.10, 0.82)
_BANDS: tuple[Color, ...] = ((1.0, 1.0, 1.0, 0.05), (1.0, 1.0, 1.0, 0.10))
_STEP_NAME: Color = (0.90, 0.88, 0.80, 1.0)
_NAME: Color = (1.0, 1.0, 1.0, 1.0)
_CHOSEN, _ACTIVE, _OUTLINE = (1.0, 0.62, 0.15, 1.0), (1.0, 1.0, 1.0, 1.0), (0.0, 0.0, 0.0, 0.5)
_SNAP: Color = (1.0, 0.85, 0.2, 0.9)
_MUTED = 0.35  # share of its color that a strip keeps whose event is off
_LETTERS = 11.0
_handlers: list[Any] = []


def register() -> None:
    """Draw from now on; without windows there is nothing to draw into."""
    if not bpy.app.background and not _handlers:
        _handlers.append(bpy.types.SpaceDopeSheetEditor.draw_handler_add(_draw, (), "WINDOW", "POST_PIXEL"))


def unregister() -> None:
    """Draw no more."""
    for each in _handlers:
        bpy.types.SpaceDopeSheetEditor.draw_handler_remove(each, "WINDOW")
    _handlers.clear()
    strip_view.clear_preview()


def _draw() -> None:
    context = bpy.context
    scene, space, region = context.scene, context.space_data, context.region
    if region is None or not shows_strips(scene, space):
        return
    view = view_of(scene, space, region)
    picture = picture_in(scene, space, region)
    gpu.state.blend_set("ALPHA")
    gpu.state.scissor_test_set(True)
    x, y, _, _ = gpu.state.scissor_get()
    before = gpu.state.scissor_get()
    low = round(max(view.bottom, min(picture.bottom, view.top)))
    gpu.state.scissor_set(x, y + low, region.width, max(round(view.top) - low, 1))
    try:
        _draw_rectangles(rectangles(picture, region.width, view.top, strip_view.preview.line, view.x))
        _draw_names(picture, view.points, float(region.width))
    finally:
        gpu.state.scissor_set(*before)
        gpu.state.blend_set("NONE")


def rectangles(
    picture: StripPicture, width: float, top: float, line: float | None, x: Any
) -> list[tuple[float, float, float, float, Color]]:
    """What is drawn below the names, from back to front: (x0, y0, x1, y1, color)."""
    found: list[tuple[float, float, float, float, Color]] = [(0.0, picture.bottom, width, top, _GROUND)]
    for index, band in enumerate(picture.steps):
        found.append((band.x0, picture.bottom, band.x1, band.y1, _BANDS[index % 2]))
        found.append((band.x0, picture.bottom, band.x0 + 1.0, band.y1, (1.0, 1.0, 1.0, 0.25)))
    for box in picture.boxes:
        found += _strip_rectangles(box)
    if line is not None:
        found.append((x(line) - 1.0, picture.bottom, x(line) + 1.0, top, _SNAP))
    return found


def _strip_rectangles(box: StripBox) -> list[tuple[float, float, float, float, Color]]:
    strip = box.strip
    red, green, blue, _ = LANE_COLORS[strip.lane]
    fill: Color = (red, green, blue, 1.0)
    if not strip.enabled:
        fill = (0.3 + _MUTED * (red - 0.3), 0.3 + _MUTED * (green - 0.3), 0.3 + _MUTED * (blue - 0.3), 0.75)
    outline = _ACTIVE if strip.active else _CHOSEN if strip.selected else _OUTLINE
    edge = 2.0 if strip.selected or strip.active else 1.0
    found = [
        (box.x0 - edge, box.y0 - edge, box.x1 + edge, box.y1 + edge, _CHOSEN if strip.selected else outline),
        (box.x0, box.y0, box.x1, box.y1, fill),
    ]
    if strip.active and strip.selected:
        found.insert(1, (box.x0 - 1.0, box.y0 - 1.0, box.x1 + 1.0, box.y1 + 1.0, _ACTIVE))
    if strip.has_end and box.x1 - box.x0 > 12.0:  # the ends that can be dragged
        grip: Color = (0.0, 0.0, 0.0, 0.28)
        found += [(box.x0, box.y0, box.x0 + 3.0, box.y1, grip), (box.x1 - 3.0, box.y0, box.x1, box.y1, grip)]
    if not strip.enabled:
        middle = 0.5 * (box.y0 + box.y1)
        found.append((box.x0, middle - 0.5, box.x1, middle + 0.5, (0.0, 0.0, 0.0, 0.6)))
    return found


def _draw_rectangles(found: list[tuple[float, float, float, float, Color]]) -> None:
    """All of them at once, in their order."""
    corners = np.array([each[:4] for each in found], np.float32)
    positions = corners[:, [[0, 1], [2, 1], [2, 3], [0, 1], [2, 3], [0, 3]]].reshape(-1, 2)
    colors: NDArray[np.float32] = np.repeat(np.array([each[4] for each in found], np.float32), 6, axis=0)
    shader = gpu.shader.from_builtin("FLAT_COLOR")
    flat = np.column_stack([positions, np.zeros(len(positions), np.float32)])
    batch_for_shader(shader, "TRIS", {"pos": flat, "color": colors}).draw(shader)


def _draw_names(picture: StripPicture, points: float, width: float) -> None:
    blf.size(0, _LETTERS * points)
    for band in picture.steps:
        if band.x1 > 0.0:
            _name(band.step.name, max(band.x0, 0.0) + 5.0 * points, band.x1, 0.5 * (band.y0 + band.y1), _STEP_NAME)
    if picture.row_height < NAMED * points:
        return
    for box in picture.boxes:
        inside = box.after <= box.x1 + 0.5
        left = (max(box.x0, 0.0) if inside else box.x1) + 5.0 * points
        if 0.0 <= left < width:
            color = _NAME if box.strip.enabled else (0.6, 0.6, 0.6, 1.0)
            _name(box.strip.name, left, box.x1 if inside else width, 0.5 * (box.y0 + box.y1), color)


def _name(text: str, left: float, right: float, middle: float, color: Color) -> None:
    """A name from a pixel on, cut off where it has no room."""
    half = 0.5 * blf.dimensions(0, "x")[1]
    blf.enable(0, blf.CLIPPING)
    blf.clipping(0, left, -1e5, max(right - 2.0, left), 1e5)
    blf.color(0, *color)
    blf.position(0, left, middle - half, 0.0)
    blf.draw(0, text)
    blf.disable(0, blf.CLIPPING)
