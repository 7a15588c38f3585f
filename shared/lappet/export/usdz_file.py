"""`lappet export CACHE.usdc -o X.usdz`: for augmented reality, where neither morph targets nor time samples play.

The motion is that of bones: a skinning decomposition of the solved frames, and the error of it is measured in the file.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lappet.core.durable import check_space, draft_folder, replace_durably
from lappet.core.problem import problem, refused
from lappet.core.problem_code import ProblemCode
from lappet.drawing.skin_read import SkinCache
from lappet.drawing.skin_source import FigureError
from lappet.export.export_request import ExportRequest
from lappet.export.exported_cache import exported_cache, exported_frames
from lappet.export.moving_shape import MovingShape
from lappet.export.moving_skin import bed_shape, scenery_shapes, skin_shapes
from lappet.export.moving_tubes import instrument_shapes, vessel_shapes
from lappet.export.play_times import play_times
from lappet.export.simplified_cache import fitting_triangles, simplified
from lappet.export.size_limit import MOST_BONES, check_size
from lappet.export.skeleton_error import SkeletonError, skeleton_error
from lappet.export.skeleton_stage import TEXTURE, write_stage
from lappet.export.skin_tile import write_skin_tile
from lappet.export.skinned_shape import SkinnedShape, skinned_surface, skinned_tubes
from lappet.output.named_steps import operation_steps
from lappet.usd.stage import pxr

TOLERANCE = 0.5  # mm
PAUSE = 1.0  # seconds
MOST_VERTICES = 120_000
MOST_BYTES = 10_000_000


def write_usdz(request: ExportRequest) -> list[Path]:
    """Write a solved procedure as a package for augmented reality.

    Parameters
    ----------
    request
        The cache, the file and the options `frames`, `simplify`, `tolerance_mm`, `bones`, `pause`, `instruments` and
        `max_size`.

    Returns
    -------
    list[Path]
        The file.

    Raises
    ------
    RefusedError
        If the cache cannot be read or shown, has no such frame, is too large, or the bones do not suffice.
    OSError
        If the file cannot be written.
    """
    options = request.options
    tolerance = float(options.get("tolerance_mm", TOLERANCE))
    most_bones = int(options.get("bones", MOST_BONES))
    cache = exported_cache(request.caches[0], request.limits)
    frames = exported_frames(cache, request)
    cache = simplified(cache, frames, request)
    _check_size(cache, frames)
    try:
        surfaces = skin_shapes(cache, frames)
        bed = bed_shape(cache, frames)
        surfaces += [bed] if bed else []
        tubes = vessel_shapes(cache, frames)
        if options.get("instruments", True):
            tubes = instrument_shapes(cache, frames) + tubes
        still = scenery_shapes(cache, frames[-1:])
        steps = {step.frame for step in operation_steps(cache)}
    except FigureError as error:
        raise refused(ProblemCode.EXPORT_CACHE, cache.path, reason=str(error)) from error
    stand = _stand(surfaces)
    skinned = [skinned_surface(_on_table(each, stand), tolerance, most_bones) for each in surfaces]
    skinned += [skinned_tubes(_on_table(each, stand), tolerance, most_bones) for each in tubes]
    _check_error(skinned, tolerance, most_bones, request.target)
    times = play_times(frames, steps, float(options.get("pause", PAUSE)) * cache.fps)
    target = request.target.resolve()
    with draft_folder(target) as folder:
        layer, package = folder / "operation.usdc", folder / target.name
        write_skin_tile(folder / TEXTURE)
        write_stage(str(layer), skinned, [_on_table(each, stand) for each in still], times, cache.fps)
        if not pxr().UsdUtils.CreateNewUsdzPackage(str(layer), str(package)):
            check_space(folder, target)
            raise refused(ProblemCode.FILE_NOT_WRITTEN, request.target, "USD gives no reason", folder=target.parent)
        found = skeleton_error(package, skinned, times)
        if found.greatest > tolerance:
            raise refused(
                ProblemCode.EXPORT_BONES, request.target, most_bones, reached=found.greatest, tolerance=tolerance
            )
        check_size(request, package.stat().st_size)
        replace_durably(package, target)
    _tell(request, found, skinned)
    return [request.target]


def _check_size(cache: SkinCache, frames: Sequence[float]) -> None:
    used = [epoch for epoch in cache.epochs if set(epoch.frames) & set(frames)]
    count = sum(len(np.unique(epoch.triangles)) for epoch in used)
    if count > MOST_VERTICES:
        times = (count / MOST_VERTICES) ** 0.5
        fits = fitting_triangles(MOST_VERTICES / len(used))
        raise refused(ProblemCode.EXPORT_AR_SIZE, cache.path, f"{count}", most=MOST_VERTICES, times=times, fits=fits)


def _check_error(shapes: Sequence[SkinnedShape], tolerance: float, most_bones: int, target: Path) -> None:
    reached = max(each.error for each in shapes)
    if reached > tolerance:
        raise refused(ProblemCode.EXPORT_BONES, target, most_bones, reached=reached, tolerance=tolerance)


def _stand(shapes: Sequence[MovingShape]) -> NDArray[np.float64]:
    """What of the tissue comes to the origin, in mm: the middle of its lowest plane, as it is in its first frame."""
    first = shapes[0].positions[0].astype(np.float64)
    low, high = first.min(axis=0), first.max(axis=0)
    return np.array([0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), low[2]])


def _on_table(shape: MovingShape, stand: NDArray[np.float64]) -> MovingShape:
    """A shape standing at the origin, with Y up."""
    positions = (shape.positions - stand)[..., [0, 2, 1]] * (1.0, 1.0, -1.0)
    normals = shape.normals[..., [0, 2, 1]] * np.array([1.0, 1.0, -1.0], np.float32)
    return replace(shape, positions=positions.astype(np.float32), normals=normals)


def _tell(request: ExportRequest, error: SkeletonError, shapes: Sequence[SkinnedShape]) -> None:
    bones = sum(own.skinning.rotation.shape[1] for each in shapes for own in each.sets)
    greatest, rms = f"{error.greatest:.3f}", error.rms
    request.note(problem(ProblemCode.EXPORT_BONES_ERROR, request.target, greatest, rms=rms, bones=bones))
    size = request.target.stat().st_size
    if size > MOST_BYTES:
        request.note(problem(ProblemCode.EXPORT_AR_BYTES, request.target, f"{size / 1e6:.1f}", most=MOST_BYTES / 1e6))
