"""Draw over the viewport: the lattice's cells, and where the tissue is wrong."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ..model.decimals import decimal
from ..model.tissue_size import tissue_size
from ..model.tissue_values import tissue_is_ready, tissue_value
from ..model.units import mm_per_unit
from .lattice_lines import lattice_lines
from .tissue_check import last_check

_LATTICE = (0.35, 0.75, 1.0, 0.35)
_ERROR, _WARNING = (1.0, 0.15, 0.1, 1.0), (1.0, 0.7, 0.1, 1.0)
_FACE_ALPHA = 0.45

_handle: Any = None
_batches: dict[str, tuple[Any, list[tuple[str, tuple[float, ...], Any]]]] = {}


def lattice_of(scene: bpy.types.Scene) -> NDArray[np.float32]:
    """The lines (k, 2, 3), mm, of the scene's lattice; none where there is no tissue to be read."""
    tissue, _ = tissue_value(scene)
    if tissue is None:
        return np.zeros((0, 2, 3), np.float32)
    size = tissue_size(tissue)
    return lattice_lines(size.points, size.triangles, decimal(scene.lappet.tissue.spacing))


def register() -> None:
    """Draw in every 3D viewport from now on; not without a window."""
    global _handle
    if not bpy.app.background and _handle is None:
        _handle = bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_VIEW")


def unregister() -> None:
    """Draw no more."""
    global _handle
    if _handle is not None:
        bpy.types.SpaceView3D.draw_handler_remove(_handle, "WINDOW")
        _handle = None
    _batches.clear()


def _draw() -> None:
    context = bpy.context
    scene = context.scene
    if scene is None or scene.lappet.tissue.object is None or not context.space_data.overlay.show_overlays:
        return
    scale = mm_per_unit(scene)
    if scene.lappet.look.show_lattice and scene.lappet.tissue.object.mode != "EDIT" and tissue_is_ready(scene):
        tissue, _ = tissue_value(scene)
        _draw_kept(f"lattice {scene.session_uid}", (tissue, scale), lambda: _lattice_batches(scene, scale))
    found = last_check(scene)
    if found is not None:
        _draw_kept(f"problems {scene.session_uid}", (found, scale), lambda: _problem_batches(found, scale))


def _draw_kept(key: str, made_of: tuple[Any, ...], make: Any) -> None:
    kept = _batches.get(key)
    if kept is None or any(a is not b and a != b for a, b in zip(kept[0], made_of, strict=True)):
        kept = (made_of, make())
        _batches[key] = kept
    import gpu

    gpu.state.blend_set("ALPHA")
    gpu.state.depth_test_set("LESS_EQUAL")
    region = bpy.context.region
    for name, color, batch in kept[1]:
        shader = gpu.shader.from_builtin(name)
        shader.bind()
        shader.uniform_float("color", color)
        if name.startswith("POLYLINE"):
            shader.uniform_float("viewportSize", (region.width, region.height))
            shader.uniform_float("lineWidth", 3.0)
        # Problems show through the mesh: what lies on it would flicker.
        gpu.state.depth_test_set("LESS_EQUAL" if name == "UNIFORM_COLOR" and color == _LATTICE else "NONE")
        gpu.state.point_size_set(8.0)
        batch.draw(shader)
    gpu.state.depth_test_set("NONE")
    gpu.state.blend_set("NONE")


def _lattice_batches(scene: bpy.types.Scene, scale: float) -> list[tuple[str, tuple[float, ...], Any]]:
    lines = lattice_of(scene)
    return [_batch("UNIFORM_COLOR", "LINES", _LATTICE, lines, scale)] if len(lines) else []


def _problem_batches(found: Any, scale: float) -> list[tuple[str, tuple[float, ...], Any]]:
    batches = []
    for each in found.places:
        color = _ERROR if each.problem.severity == "error" else _WARNING
        if len(each.triangles):
            pale = (*color[:3], _FACE_ALPHA)
            batches.append(_batch("UNIFORM_COLOR", "TRIS", pale, each.triangles, scale))
        if len(each.lines):
            batches.append(_batch("POLYLINE_UNIFORM_COLOR", "LINES", color, each.lines, scale))
        if len(each.points):
            batches.append(_batch("UNIFORM_COLOR", "POINTS", color, each.points, scale))
    return batches


def _batch(
    name: str, kind: str, color: tuple[float, ...], places: NDArray, scale: float
) -> tuple[str, tuple[float, ...], Any]:
    import gpu
    from gpu_extras.batch import batch_for_shader

    shader = gpu.shader.from_builtin(name)
    points = np.ascontiguousarray(places.reshape(-1, 3) / scale, np.float32)
    return name, color, batch_for_shader(shader, kind, {"pos": points})
