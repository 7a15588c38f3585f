"""Open a skin cache that is to be exported."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from lappet.core.problem import problem, refused
from lappet.core.problem_code import ProblemCode
from lappet.drawing.skin_read import SkinCache
from lappet.drawing.skin_source import FigureError
from lappet.export.export_request import ExportRequest
from lappet.foreign.limits import DEFAULT_LIMITS, ReadLimits
from lappet.foreign.reading_process import ReadingProcess
from lappet.usd.procedure_file import CHILD
from lappet.usd.stage_contents import ValueSizes


def exported_cache(path: Path, limits: ReadLimits = DEFAULT_LIMITS) -> SkinCache:
    """Open a skin cache.

    Parameters
    ----------
    path
        The cache, as `lappet solve` wrote it.
    limits
        What reading may take.

    Returns
    -------
    SkinCache
        The cache.

    Raises
    ------
    RefusedError
        If the file cannot be read or is no skin cache.
    """
    with ReadingProcess(CHILD, "values", path, limits) as look:
        look.result(ValueSizes)
    try:
        return SkinCache(path)
    except FigureError as error:
        raise refused(ProblemCode.EXPORT_CACHE, path, reason=str(error)) from error


def chosen_frames(cache: SkinCache, frames: tuple[float, ...] | None) -> tuple[float, ...]:
    """Choose the frames of a cache that are exported.

    Parameters
    ----------
    cache
        The cache.
    frames
        Time codes; None for all.

    Returns
    -------
    tuple[float, ...]
        The time codes, ascending.

    Raises
    ------
    RefusedError
        If a frame is not in the cache.
    """
    if frames is None:
        return cache.frames
    for time in frames:
        if time not in cache.frames:
            first, last = cache.frames[0], cache.frames[-1]
            raise refused(ProblemCode.EXPORT_FRAME, cache.path, f"{time:g}", first=first, last=last)
    return tuple(sorted(set(frames)))


def exported_frames(cache: SkinCache, request: ExportRequest) -> tuple[float, ...]:
    """Choose the frames that a request asks for, and tell of those that the cache should hold and does not.

    Parameters
    ----------
    cache
        The cache.
    request
        Has the option `frames`, time codes; without it all frames are chosen.

    Returns
    -------
    tuple[float, ...]
        The time codes, ascending.

    Raises
    ------
    RefusedError
        If a frame is not in the cache.
    """
    frames = request.options.get("frames")
    if frames is not None:
        return chosen_frames(cache, tuple(frames))
    missing = missing_frames(cache.frames)
    if missing:
        spans = [f"{low:g}" if low == high else f"{low:g} to {high:g}" for low, high in missing]
        request.note(problem(ProblemCode.EXPORT_FRAMES_MISSING, cache.path, ", ".join(spans)))
    return cache.frames


def missing_frames(frames: Sequence[float]) -> list[tuple[float, float]]:
    """Find frames that are missing between others: where frames are farther apart than most are.

    Parameters
    ----------
    frames
        Time codes, ascending.

    Returns
    -------
    list[tuple[float, float]]
        The first and the last frame of each gap, by the distance that occurs most often (the smallest of several).
    """
    gaps = np.round(np.diff(np.asarray(frames, np.float64)), 6)
    if not len(gaps):
        return []
    steps, counts = np.unique(gaps, return_counts=True)
    step = float(steps[counts.argmax()])
    return [(float(frames[k]) + step, float(frames[k + 1]) - step) for k in np.flatnonzero(gaps > 1.5 * step)]
