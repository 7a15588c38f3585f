"""The fragment of tissue under the mouse: the part of the shown surface that hangs together with a triangle."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .shown_surface import RestShape

_parts: dict[int, tuple[RestShape, NDArray[np.int32]]] = {}


def parts_of(shape: RestShape) -> NDArray[np.int32]:
    """The part (m,) that each triangle of a surface belongs to: triangles that share a vertex are of one part."""
    known = _parts.get(id(shape))
    if known is not None and known[0] is shape:
        return known[1]
    label = np.arange(len(shape.points), dtype=np.int32)
    while True:
        least = label[shape.triangles].min(axis=1)
        grown = label.copy()
        for corner in range(3):
            np.minimum.at(grown, shape.triangles[:, corner], least)
        grown = grown[grown]  # a part takes over the least label of the part it has met
        if np.array_equal(grown, label):
            break
        label = grown
    found = label[shape.triangles[:, 0]]
    _parts.clear()
    _parts[id(shape)] = (shape, found)
    return found


def fragment_of(shape: RestShape, triangle: int) -> NDArray[np.int64]:
    """The triangles (k,) of the fragment that a triangle belongs to; none where the surface is one piece."""
    parts = parts_of(shape)
    mine = np.flatnonzero(parts == parts[triangle])
    return mine if len(mine) < len(parts) else np.zeros(0, np.int64)
