"""The skin of a lesson: the surface of each epoch as a browser draws it, and how it moves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.drawing.quantity_scale import UNITS, frame_peak, full_value
from lappet.drawing.skin_fields import SKIN, border_chains
from lappet.drawing.skin_source import ORIGINS, SCALARS, SkinEpoch, SkinSource
from lappet.export.lesson_arrays import LessonArrays
from lappet.geometry.skin_shape import uv_scale

_GRID_STEP = 0.02  # mm
_DEPTH_STEP = 0.01  # mm
_MOST = 65535


@dataclass(frozen=True, eq=False)
class DrawnVertices:
    """The vertices that a browser draws: one for each face label, column of layers and texture coordinate of a vertex.

    Parameters
    ----------
    vertex
        The vertex of the cache that each is, shape (r,); ascending in each label.
    column
        Its column of layers, shape (r,).
    grid
        Its place on the printed grid in steps of 0.02 mm, shape (r, 2).
    triangles
        Their indices, shape (m, 3), by label.
    faces
        Number of triangles of each label, in the order of `ORIGINS`.
    vertices
        Number of drawn vertices of each label.
    """

    vertex: NDArray[np.int64]
    column: NDArray[np.int64]
    grid: NDArray[np.int64]
    triangles: NDArray[np.int64]
    faces: tuple[int, ...]
    vertices: tuple[int, ...]


def drawn_vertices(source: SkinSource, epoch: SkinEpoch, grid_scale: NDArray[np.float64]) -> DrawnVertices:
    """Split the vertices of an epoch where its faces' labels, layers or texture coordinates differ.

    Parameters
    ----------
    source
        The solved procedure.
    epoch
        The epoch.
    grid_scale
        Millimetres per unit of u and v, shape (2,).

    Returns
    -------
    DrawnVertices
        What is drawn.
    """
    st = epoch.st if epoch.st is not None else source.rest(epoch)[epoch.triangles][:, :, :2]
    grid = np.rint(st.reshape(-1, 2).astype(np.float64) * grid_scale / _GRID_STEP).astype(np.int64)
    every = [epoch.origin, source.column(epoch)]
    label, column = (np.repeat(np.asarray(each, np.int64), 3) for each in every)
    keys = np.column_stack([label, epoch.triangles.reshape(-1).astype(np.int64), column, grid])
    rows, back = np.unique(keys, axis=0, return_inverse=True)
    order = np.argsort(epoch.origin, kind="stable")
    triangles = back.reshape(-1, 3)[order]
    labels = range(len(ORIGINS))
    faces = tuple(int((epoch.origin == each).sum()) for each in labels)
    vertices = tuple(int((rows[:, 0] == each).sum()) for each in labels)
    return DrawnVertices(rows[:, 1], rows[:, 2], rows[:, 3:], triangles, faces, vertices)


def quantity_scales(shown: Sequence[tuple[SkinSource, Sequence[float]]]) -> dict[str, dict[str, Any]]:
    """Choose the color scales of what caches hold of the skin, the same for all of them.

    Parameters
    ----------
    shown
        The solved procedures, each with the time codes of its frames.

    Returns
    -------
    dict[str, dict[str, Any]]
        `full`, the value at the top, and `unit`, for each quantity that every frame has.
    """
    found = {}
    for name in SCALARS:
        every = [source.scalar(source.epoch_at(time), name, time) for source, frames in shown for time in frames]
        peaks = [frame_peak(values) for values in every if values is not None]
        if len(peaks) == len(every):
            found[name] = {"full": full_value(max(peaks)), "unit": UNITS[name].strip()}
    return found


class LessonSkin:
    """Write the skin of a procedure.

    Parameters
    ----------
    source
        The solved procedure.
    frames
        Time codes of the frames that are shown.
    scales
        The color scales of its quantities (`quantity_scales`).
    arrays
        Where its arrays go.
    """

    def __init__(
        self, source: SkinSource, frames: Sequence[float], scales: Mapping[str, Any], arrays: LessonArrays
    ) -> None:
        self._source, self._frames, self._arrays, self._scales = source, frames, arrays, scales
        first = source.epochs[0]
        skin = first.origin == SKIN
        self._grid_scale = (
            uv_scale(source.rest(first), first.triangles[skin], first.st[skin]) if first.st is not None else np.ones(2)
        )

    def epochs(self) -> list[dict[str, Any]]:
        """Write all epochs of which a frame is shown.

        Returns
        -------
        list[dict[str, Any]]
            Each epoch's numbers and where its arrays lie.
        """
        shown = [(epoch, [t for t in self._frames if t in epoch.frames]) for epoch in self._source.epochs]
        return [self._epoch(epoch, times) for epoch, times in shown if times]

    def _epoch(self, epoch: SkinEpoch, times: list[float]) -> dict[str, Any]:
        arrays, source = self._arrays, self._source
        drawn = drawn_vertices(source, epoch, self._grid_scale)
        low = drawn.grid.min(axis=0)
        depth = np.rint(source.depth(epoch)[drawn.vertex] / _DEPTH_STEP).clip(0, _MOST).astype(np.uint16)
        states = np.stack([source.rest(epoch), *(source.positions(epoch, time) for time in times)])
        chains = border_chains(epoch.triangles, epoch.origin)
        lips = np.concatenate([np.zeros(0, np.int32), *chains])
        return {
            "name": epoch.name,
            "frames": [self._frames.index(time) for time in times],
            "faces": drawn.faces,
            "vertices": drawn.vertices,
            "triangles": arrays.add(drawn.triangles.astype(np.uint32)),
            "vertex": arrays.add(drawn.vertex.astype(np.uint32)),
            "column": arrays.add(drawn.column.clip(0, 255).astype(np.uint8)),
            "grid": arrays.add((drawn.grid - low).clip(0, _MOST).astype(np.uint16).T, len(drawn.grid)),
            "gridLow": (low * _GRID_STEP).tolist(),
            "gridStep": _GRID_STEP,
            "depth": arrays.add(depth),
            "depthStep": _DEPTH_STEP,
            "positions": arrays.positions(states),
            "lips": arrays.add(lips.astype(np.uint32)),
            "lipCounts": [len(chain) for chain in chains],
            "quantities": {name: self._quantity(epoch, times, name, drawn) for name in self._scales},
        }

    def _quantity(self, epoch: SkinEpoch, times: list[float], name: str, drawn: DrawnVertices) -> dict[str, int]:
        """A quantity at the drawn vertices of the skin, frame by frame, in 255ths of full scale."""
        skin = drawn.vertex[: drawn.vertices[SKIN]]
        rows = []
        for time in times:
            values = self._source.scalar(epoch, name, time)
            assert values is not None  # or it had no scale
            share = np.nan_to_num(np.abs(values[skin]), nan=0.0, posinf=0.0) / self._scales[name]["full"]
            rows.append(np.rint(255.0 * share.clip(0.0, 1.0)).astype(np.uint8))
        return self._arrays.add(np.stack(rows), len(skin))
