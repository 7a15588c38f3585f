"""Open a skin cache that is to be exported."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from lappet.core.problem import Problem, problem, refused
from lappet.core.problem_code import ProblemCode
from lappet.drawing.skin_read import SkinCache
from lappet.drawing.skin_source import FigureError
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


def note_missing_frames(cache: SkinCache, note: Callable[[Problem], None]) -> None:
    """Warn of frames that are missing between others.

    Parameters
    ----------
    cache
        The cache.
    note
        Is told of them.
    """
    frames = np.array(cache.frames)
    gaps = np.diff(frames)
    if not len(gaps):
        return
    step = float(np.median(gaps))
    for k in np.flatnonzero(gaps > 1.5 * step):
        missing = f"{frames[k] + step:g} to {frames[k + 1] - step:g}"
        note(problem(ProblemCode.EXPORT_FRAMES_MISSING, cache.path, missing))
