"""Draw the annotations of the chosen panel over 3D viewports."""

from __future__ import annotations

from typing import Any

import blf
import bpy
import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader
from numpy.typing import NDArray

from ..model.plate_names import active_annotation, active_panel, active_plate
from ..tools.shown_surface import shown_surface
from ..tools.view_under_mouse import project
from .panel_view import panel_size, pixels_per_mm
from .preview_marks import PreviewMarks, PreviewPage, preview_marks

_LETTERS = 7.0 * 25.4 / 72.0  # mm: the size of a plate's texts
_INK, _CHOSEN, _PAPER, _FRAME = (0.05, 0.05, 0.05, 1.0), (0.85, 0.35, 0.0, 1.0), (1.0, 1.0, 1.0, 0.9), (1, 1, 1, 0.35)
_handlers: list[Any] = []


def register() -> None:
    """Draw from now on; without windows there is nothing to draw into."""
    if not bpy.app.background and not _handlers:
        _handlers.append(bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_PIXEL"))


def unregister() -> None:
    """Draw no more."""
    for each in _handlers:
        bpy.types.SpaceView3D.draw_handler_remove(each, "WINDOW")
    _handlers.clear()


def marks_in(
    scene: bpy.types.Scene, space: bpy.types.SpaceView3D | None, region: Any, data: bpy.types.RegionView3D
) -> PreviewMarks | None:
    """The marks of the chosen panel in a view; None where there is nothing to show."""
    plate, panel = active_plate(scene), active_panel(scene)
    surface = shown_surface(scene, space) if plate is not None and panel is not None else None
    if plate is None or panel is None or surface is None:
        return None
    size = (float(region.width), float(region.height))
    page = preview_page(plate, size)
    matrix = data.perspective_matrix
    return preview_marks(plate, panel.name, surface, lambda places: project(matrix, *size, places), page)


def preview_page(plate: Any, region: tuple[float, float]) -> PreviewPage:
    """The paper of a panel over a region of a width and height in pixels."""
    scale = pixels_per_mm(plate, region)
    half = 0.5 * scale * np.array(panel_size(plate))
    middle = 0.5 * np.array(region)
    letters = _LETTERS * scale
    blf.size(0, letters)
    return PreviewPage(
        scale, np.stack([middle - half, middle + half]), letters, lambda text: blf.dimensions(0, text)[0]
    )


def _draw() -> None:
    context = bpy.context
    scene, space, data = context.scene, context.space_data, context.region_data
    if space is None or data is None or not space.overlay.show_overlays or not scene.lappet.show_page:
        return
    marks = marks_in(scene, space, context.region, data)
    if marks is None:
        return
    note = active_annotation(scene)
    gpu.state.blend_set("ALPHA")
    (x0, y0), (x1, y1) = marks.frame
    _line(np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)]), _FRAME, 1.0)
    for line in marks.lines:
        _line(line, _PAPER, 4.0)
        _line(line, _INK, 1.5)
    for text in marks.texts:
        blf.size(0, marks.size)
        blf.enable(0, blf.SHADOW)
        blf.shadow(0, 5, *_PAPER)
        blf.color(0, *(_CHOSEN if note is not None and text.note == note.name else _INK))
        blf.position(0, float(text.place[0]), float(text.place[1]), 0.0)
        blf.draw(0, text.text)
        blf.disable(0, blf.SHADOW)
    gpu.state.blend_set("NONE")


def _line(points: NDArray[np.float64], color: tuple[float, ...], width: float) -> None:
    shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    shader.bind()
    shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
    shader.uniform_float("lineWidth", width * bpy.context.preferences.system.ui_scale)
    shader.uniform_float("color", color)
    flat = np.column_stack([points, np.zeros(len(points))]).astype(np.float32)
    batch_for_shader(shader, "LINE_STRIP", {"pos": flat}).draw(shader)
