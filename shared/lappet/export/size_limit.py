"""A file that may not be larger than so much: `lappet export --max-size`.

Before work starts the size is estimated by the format's own writer: it writes a few of the frames, and once more with
the frame behind each of them, into a folder that is then deleted. What such a frame adds stands for what every frame
adds. A .usdz, whose frames take little, is estimated with one bone for everything, which it cannot be smaller than.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lappet.core.problem import RefusedError, refused
from lappet.core.problem_code import ProblemCode
from lappet.drawing.skin_read import SkinCache
from lappet.export.export_request import ExportFunction, ExportRequest
from lappet.export.exported_cache import chosen_frames, exported_cache
from lappet.export.simplify_target import LEAST, SimplifyTarget

ESTIMATE_ERROR = 0.15  # of the size, by which an estimate may be off
_UNITS = {"B": 1, "kB": 10**3, "MB": 10**6, "GB": 10**9}
_SAMPLES = 4
_WORTH = 6  # times as many frames as a sample has are worth an estimate: with fewer the file itself is made as fast
_COARSER = 0.4  # of the triangles: a skin by which it is found what one triangle takes
_SPARE = 0.92  # of the allowed size, that a remedy aims at
MOST_BONES = 200  # that each part of a .usdz may have if nothing else is said
_BONE_BYTES = 28  # of a bone in a frame: where it is, and a quaternion
_ONE_BONE: Mapping[str, Any] = {"bones": 1, "tolerance_mm": 1e9}


class TooLargeError(Exception):
    """A file that is written, but not yet in its place, is larger than it may be.

    Parameters
    ----------
    size
        Its size in bytes.
    """

    def __init__(self, size: int) -> None:
        super().__init__(size)
        self.size = size


@dataclass(frozen=True)
class SizeEstimate:
    """How large a file will be.

    Parameters
    ----------
    total
        Its size in bytes.
    frame
        What one frame adds to it in bytes.
    """

    total: float
    frame: float


def bytes_of(text: str) -> int:
    """Read a size that a user wrote.

    Parameters
    ----------
    text
        Such as "5MB" or "800 kB"; a kB has a thousand bytes.

    Returns
    -------
    int
        The bytes.

    Raises
    ------
    RefusedError
        If it is no size.
    """
    found = re.fullmatch(r"\s*(\d+(?:\.\d+)?)\s*(B|kB|MB|GB)\s*", text)
    size = round(float(found[1]) * _UNITS[found[2]]) if found else 0
    if size <= 0:
        raise refused(ProblemCode.EXPORT_MAX_SIZE_TARGET, "--max-size", text)
    return size


def check_size(request: ExportRequest, size: int) -> None:
    """Refuse a file that is larger than it may be, before it has its place.

    Parameters
    ----------
    request
        May have the option `max_size`, in bytes.
    size
        Size of the file in bytes.

    Raises
    ------
    TooLargeError
        If the file is larger.
    """
    most = request.options.get("max_size")
    if most is not None and size > most:
        raise TooLargeError(size)


def write_within(write: ExportFunction, request: ExportRequest) -> list[Path]:
    """Write a file unless it is larger than a request allows.

    Parameters
    ----------
    write
        Writes files of this format, and calls `check_size`.
    request
        What to export, with the option `max_size`, in bytes.

    Returns
    -------
    list[Path]
        The file.

    Raises
    ------
    RefusedError
        If the file would be too large, or cannot be written for another reason; nothing is written then.
    OSError
        If the file cannot be written.
    """
    most = int(request.options["max_size"])
    cache = exported_cache(request.caches[0], request.limits)
    frames = chosen_frames(cache, request.options.get("frames"))
    found = estimated_size(write, request, cache, frames)
    if found is not None and found.total * (1.0 - ESTIMATE_ERROR) > most:
        raise _refusal(write, request, cache, frames, found)
    try:
        return write(request)
    except TooLargeError as error:
        frame = 0.0 if found is None else found.frame
        raise _refusal(write, request, cache, frames, SizeEstimate(error.size, frame), known=True) from error


def estimated_size(
    write: ExportFunction, request: ExportRequest, cache: SkinCache, frames: Sequence[float], **more: Any
) -> SizeEstimate | None:
    """Estimate the size of a file by some of its frames.

    Parameters
    ----------
    write
        Writes files of this format.
    request
        What to export.
    cache
        The first of its caches.
    frames
        Time codes of the frames that are exported, ascending.
    **more
        Options in place of the request's.

    Returns
    -------
    SizeEstimate or None
        The size; None where writing the file takes hardly longer than finding that, or there are two caches.

    Raises
    ------
    RefusedError
        If these frames cannot be written.
    OSError
        If there is no space for them.
    """
    options = {name: value for name, value in {**request.options, **more}.items() if name != "max_size"}
    few, all_few = _samples(cache, frames)
    if len(request.caches) > 1:
        return None
    if _by_bones(request):
        return SizeEstimate(_trial(write, request, {**options, **_ONE_BONE, "frames": few}), 0.0)
    if len(frames) < _WORTH * len(all_few):
        return None
    small = _trial(write, request, {**options, "frames": few})
    frame = (_trial(write, request, {**options, "frames": all_few}) - small) / (len(all_few) - len(few))
    return SizeEstimate(small + frame * (len(frames) - len(few)), frame)


def _samples(cache: SkinCache, frames: Sequence[float]) -> tuple[list[float], list[float]]:
    """Some frames, the last of each epoch among them, of which others are told; and these with some behind them."""
    lasts = {max(own) for each in cache.epochs if (own := set(each.frames) & set(frames))}
    starts = [int((k + 0.5) * (len(frames) - 1) / _SAMPLES) for k in range(_SAMPLES)]
    few = lasts | {frames[k] for k in starts}
    behind = {next((time for time in frames[k:] if time not in few), frames[0]) for k in starts}
    return sorted(few), sorted(few | behind)


def _trial(write: ExportFunction, request: ExportRequest, options: Mapping[str, Any]) -> int:
    """The size of a file that is written and deleted."""
    with tempfile.TemporaryDirectory(prefix="lappet-") as folder:
        target = Path(folder) / request.target.name
        write(ExportRequest(request.caches, target, options, request.limits))
        return target.stat().st_size


def _refusal(
    write: ExportFunction,
    request: ExportRequest,
    cache: SkinCache,
    frames: Sequence[float],
    found: SizeEstimate,
    known: bool = False,
) -> RefusedError:
    """What is said of a file that is too large, with what would fit."""
    most = int(request.options["max_size"])
    told: dict[str, Any] = {
        "about": "takes" if known else "would take at least" if _by_bones(request) else "would take about",
        "most": _megabytes(most),
    }
    value = _megabytes(found.total)
    triangles = _fitting_triangles(write, request, cache, frames, found, known)
    if triangles is not None:
        return refused(ProblemCode.EXPORT_MAX_SIZE, request.target, value, fits=triangles, **told)
    if found.frame > 0.0:
        fit = len(frames) - int((found.total - _SPARE * most) / found.frame) - 1
        if fit >= 2:
            return refused(ProblemCode.EXPORT_MAX_SIZE_FRAMES, request.target, value, frames=fit, **told)
    return refused(ProblemCode.EXPORT_MAX_SIZE_LEAST, request.target, value, **told)


def _fitting_triangles(
    write: ExportFunction,
    request: ExportRequest,
    cache: SkinCache,
    frames: Sequence[float],
    found: SizeEstimate,
    known: bool,
) -> int | None:
    """How many triangles the skin may have for the file to fit; None where leaving triangles out does not do it."""
    asked: SimplifyTarget | None = request.options.get("simplify")
    shown = [each for each in cache.epochs if set(each.frames) & set(frames)]
    whole = max(len(each.triangles) for each in shown)
    if asked is not None:
        whole = min(whole, asked.triangles or whole)
    coarser = int(_COARSER * whole)
    if coarser < LEAST or len(request.caches) > 1:
        return None
    one_bone = _by_bones(request)
    try:
        coarse = _size(write, request, cache, frames, simplify=SimplifyTarget(triangles=coarser))
        same = _size(write, request, cache, frames) if known and one_bone else found.total
    except RefusedError:  # its edges need more triangles, or meshoptimizer is not there
        return None
    aim = _SPARE * int(request.options["max_size"])
    if one_bone and not known:  # all the bones that it may have are not in the estimate
        aim -= _BONE_BYTES * len(frames) * len(shown) * int(request.options.get("bones", MOST_BONES))
    slope = (same - coarse) / (whole - coarser)
    fits = whole - (found.total - aim) / slope if slope > 0.0 else 0.0
    if fits < LEAST:
        return None
    digit = 10 ** (len(str(int(fits))) - 2)
    return int(fits) // digit * digit


def _by_bones(request: ExportRequest) -> bool:
    return request.target.suffix.lower() == ".usdz"


def _size(
    write: ExportFunction, request: ExportRequest, cache: SkinCache, frames: Sequence[float], **more: Any
) -> float:
    """The size of a file, estimated where that is worth it."""
    found = estimated_size(write, request, cache, frames, **more)
    if found is not None:
        return found.total
    options = {name: value for name, value in {**request.options, **more}.items() if name != "max_size"}
    return _trial(write, request, options)


def _megabytes(size: float) -> str:
    return f"{size / 1e6:.3g}"
