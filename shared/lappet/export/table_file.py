"""`lappet export CACHE.usdc -o X.csv`: forces, landmarks and lengths, a row for each frame and units in the names."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Any

import numpy as np

from lappet.core.durable import write_whole
from lappet.drawing.skin_read import SkinCache
from lappet.export.export_request import ExportRequest
from lappet.export.exported_cache import exported_cache, exported_frames
from lappet.usd.stage import pxr

_SEAM = {
    "tension": "tension [N/mm]",
    "scarLength": "scar length [mm]",
    "openArea": "open area [mm2]",
    "startDogEar": "dog-ear at start [mm]",
    "endDogEar": "dog-ear at end [mm]",
}
_ACROSS = {"gap": "widest gap [mm]", "step": "greatest step-off [mm]", "mismatch": "greatest mismatch [mm]"}

Column = tuple[str, list[float | None]]


def write_table_file(request: ExportRequest) -> list[Path]:
    """Write a table as CSV; what is not known, or not there in a frame, is left empty.

    Parameters
    ----------
    request
        The cache, the file and the option `frames`.

    Returns
    -------
    list[Path]
        The file.

    Raises
    ------
    RefusedError
        If the cache cannot be read or has no such frame.
    OSError
        If the file cannot be written.
    """
    cache = exported_cache(request.caches[0], request.limits)
    frames = exported_frames(cache, request)
    columns = _columns(cache, frames)
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow([name for name, _ in columns])
    for row in zip(*(values for _, values in columns), strict=True):
        table.writerow(["" if value is None or not np.isfinite(value) else f"{value:.6g}" for value in row])
    write_whole(request.target, text.getvalue().encode())
    return [request.target]


def _columns(cache: SkinCache, frames: tuple[float, ...]) -> list[Column]:
    stage = pxr().Usd.Stage.Open(str(cache.path))
    seconds = [(time - cache.frames[0]) / cache.fps for time in frames]
    columns: list[Column] = [("time code", list(frames)), ("time [s]", list(seconds))]
    for kind, word in (("Sutures", "suture"), ("Hooks", "hook")):
        columns += _strands(_Table(stage, kind, frames), word)
    columns += _seams(_Table(stage, "Seams", frames))
    marks = _Table(stage, "Landmarks", frames)
    places = marks.array("points", 3)
    for k, name in enumerate(marks.names):
        for axis, letter in enumerate("xyz"):
            values = marks.where_active(k, [float(at[k, axis]) for at in places])
            columns.append((f"landmark {name} {letter} [mm]", values))
    return columns


def _strands(table: _Table, word: str) -> list[Column]:
    columns: list[Column] = []
    ends, vectors = table.array("points", 3), table.array("primvars:forceVector", 3)
    for k, name in enumerate(table.names):
        if vectors:
            size = [float(np.linalg.norm(each[k])) for each in vectors]
            columns.append((f"{word} {name} force [mN]", table.where_active(k, size)))
        apart = [float(np.linalg.norm(each[2 * k + 1] - each[2 * k])) for each in ends]
        columns.append((f"{word} {name} length [mm]", table.where_active(k, apart)))
    return columns


def _seams(table: _Table) -> list[Column]:
    columns: list[Column] = []
    whole = {name: table.array(f"primvars:{name}") for name in _SEAM}
    across = {name: table.array(f"primvars:{name}") for name in _ACROSS}
    for k, seam in enumerate(table.names):
        for name, words in _SEAM.items():
            if whole[name]:
                columns.append((f"seam {seam} {words}", table.where_active(k, [each[k] for each in whole[name]])))
        for name, words in _ACROSS.items():
            if across[name]:
                most = [float(each.reshape(len(table.names), -1)[k].max()) for each in across[name]]
                columns.append((f"seam {seam} {words}", table.where_active(k, most)))
    return columns


class _Table:
    """The rows of a prim of the cache in some frames."""

    def __init__(self, stage: Any, name: str, frames: tuple[float, ...]) -> None:
        self._prim, self._frames = stage.GetPrimAtPath(f"/Procedure/Skin/{name}"), frames
        labels = self._prim.GetAttribute("primvars:label").Get() if self._prim else None
        self.names = [str(each) for each in labels or ()]
        self._active = self.array("primvars:active")

    def array(self, attribute: str, width: int = 1) -> list[np.ndarray[Any, np.dtype[np.float64]]]:
        """The values of an attribute, an array for each frame; empty where the cache has none of them."""
        if not self.names:
            return []
        values = [self._prim.GetAttribute(attribute).Get(time) for time in self._frames]
        if any(each is None for each in values):
            return []
        arrays = [np.asarray(each, np.float64) for each in values]
        return [each.reshape(-1, width) for each in arrays] if width > 1 else arrays

    def where_active(self, row: int, values: list[float]) -> list[float | None]:
        """Values of a row, None in the frames in which it does not act."""
        if not values:
            return [None] * len(self._frames)
        if not self._active:
            return [float(value) for value in values]
        return [float(value) if active[row] else None for value, active in zip(values, self._active, strict=True)]
