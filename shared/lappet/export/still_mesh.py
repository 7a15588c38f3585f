"""`lappet export CACHE.usdc -o X.stl` (`.obj`, `.ply`, `.3mf`): the tissue's surface in one frame, in mm, Z up."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.core.durable import write_whole
from lappet.core.problem import problem, refused
from lappet.core.problem_code import ProblemCode
from lappet.drawing.skin_read import SkinCache
from lappet.drawing.skin_source import FigureError
from lappet.drawing.surface_look import SurfaceLook, face_looks
from lappet.export.export_request import ExportRequest
from lappet.export.exported_cache import exported_cache, exported_frames
from lappet.export.simplified_cache import simplified
from lappet.export.threemf_package import threemf_package
from lappet.geometry.surface_check import unpaired_edges
from lappet.output.named_steps import operation_steps


def write_meshes(request: ExportRequest) -> list[Path]:
    """Write the surface of the tissue in one frame, the last one if none is chosen, or a file for each of several.

    Parameters
    ----------
    request
        The cache, the file and the options `frames`, `step`, `every_frame` and `simplify`. Files of several
        frames have the time code before their suffix, such as `flap_0012.stl`.

    Returns
    -------
    list[Path]
        The files.

    Raises
    ------
    RefusedError
        If the cache cannot be read or shown, or has no such frame or step.
    OSError
        If a file cannot be written.
    """
    chosen = [f"--{name.replace('_', '-')}" for name in ("frames", "step", "every_frame") if name in request.options]
    if len(chosen) > 1:
        raise refused(ProblemCode.EXPORT_TWO_CHOICES, request.target, " and ".join(chosen))
    cache = exported_cache(request.caches[0], request.limits)
    frames = _frames(cache, request)
    cache = simplified(cache, frames, request)
    target = request.target
    paths = []
    for time in frames:
        path = target if len(frames) == 1 else target.with_name(f"{target.stem}_{time:04g}{target.suffix}")
        triangles, points, looks, of_face = frame_surface(cache, time)
        _write(path, triangles, points, looks, of_face)
        # An STL has triangles without vertices: whoever reads it joins those at one place.
        joined = _joined(points)[triangles] if path.suffix.lower() == ".stl" else triangles
        loose = open_edges(joined)
        if loose:
            request.note(problem(ProblemCode.EXPORT_OPEN_SURFACE, path, loose))
        paths.append(path)
    return paths


def frame_surface(
    cache: SkinCache, time: float
) -> tuple[NDArray[np.int32], NDArray[np.float32], list[SurfaceLook], NDArray[np.int64]]:
    """Read the tissue's surface in a frame.

    Parameters
    ----------
    cache
        The skin cache.
    time
        Time code of the frame.

    Returns
    -------
    tuple[NDArray[np.int32], NDArray[np.float32], list[SurfaceLook], NDArray[np.int64]]
        Triangles, shape (m, 3), outward; vertices in mm, shape (n, 3); what faces look like, and for each face the
        index of its look, shape (m,).

    Raises
    ------
    RefusedError
        If the frame cannot be shown.
    """
    try:
        epoch = cache.epoch_at(time)
        points, depth = cache.positions(epoch, time), cache.depth(epoch)
    except FigureError as error:
        raise refused(ProblemCode.EXPORT_CACHE, cache.path, reason=str(error)) from error
    depths = depth[epoch.triangles].mean(axis=1)
    looks, of_face = face_looks(cache.layers, epoch.origin, cache.column(epoch), depths, bool(cache.scenery))
    return epoch.triangles, points, looks, of_face


def open_edges(triangles: NDArray[np.integer]) -> int:
    """Count the edges of a surface that do not join exactly two triangles of one orientation.

    Parameters
    ----------
    triangles
        Vertex indices, shape (m, 3).

    Returns
    -------
    int
        The number; 0 for a watertight surface.
    """
    return len(unpaired_edges(triangles))


def _joined(points: NDArray[np.float32]) -> NDArray[np.int64]:
    """For each vertex the number of its place, to 10 nm."""
    places = np.round(points.astype(np.float64), 5) + 0.0  # no negative zeros
    return np.unique(places, axis=0, return_inverse=True)[1].reshape(-1)


def _frames(cache: SkinCache, request: ExportRequest) -> tuple[float, ...]:
    if "frames" in request.options or request.options.get("every_frame"):
        return exported_frames(cache, request)
    if "step" not in request.options:
        return cache.frames[-1:]
    wanted = str(request.options["step"]).strip()
    try:
        steps = operation_steps(cache)
    except FigureError as error:
        raise refused(ProblemCode.EXPORT_CACHE, cache.path, reason=str(error)) from error
    for number, step in enumerate(steps, start=1):
        if wanted.lower() in (str(number), step.caption.lower()):
            return (step.frame,)
    known = ", ".join(f"{number} ({step.caption})" for number, step in enumerate(steps, start=1))
    raise refused(ProblemCode.EXPORT_STEP, cache.path, wanted, known=known)


def _write(
    path: Path,
    triangles: NDArray[np.int32],
    points: NDArray[np.float32],
    looks: list[SurfaceLook],
    of_face: NDArray[np.int64],
) -> None:
    """Write a file; it appears whole or not at all."""
    suffix = path.suffix.lower()
    if suffix == ".3mf":
        data = threemf_package(triangles, points, looks, of_face)
    else:
        data = _by_trimesh(suffix[1:], triangles, points, looks, of_face)
    write_whole(path, data)


def _by_trimesh(
    kind: str,
    triangles: NDArray[np.int32],
    points: NDArray[np.float32],
    looks: list[SurfaceLook],
    of_face: NDArray[np.int64],
) -> bytes:
    import trimesh

    mesh = trimesh.Trimesh(points.astype(np.float64), triangles, process=False)
    colors = np.array([look.display_color for look in looks], np.uint8)[of_face]
    options: dict[str, Any] = {}
    if kind == "ply":
        mesh.visual.face_colors = np.column_stack([colors, np.full(len(colors), 255, np.uint8)])
    elif kind == "obj":
        # Its materials belong to groups of faces; the colors of vertices are what most programs read.
        total = np.zeros((len(points), 3))
        for axis in range(3):
            total[:, axis] = np.bincount(triangles.ravel(), np.repeat(colors[:, axis], 3), len(points))
        shared = np.maximum(np.bincount(triangles.ravel(), minlength=len(points)), 1)
        mesh.visual.vertex_colors = np.rint(total / shared[:, None]).astype(np.uint8)
        options = {"digits": 6, "header": "Lappet: millimetres, Z up"}
    data = mesh.export(file_type=kind, **options)
    return data.encode() if isinstance(data, str) else bytes(data)
