"""The edges of a triangle mesh as Blender stores them, found without Blender: on any thread (numpy only)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class MeshEdges:
    """ends: (e, 2) int32 vertices. of_corner: (3m,) int32, the edge from each corner of a triangle to the next."""

    ends: NDArray[np.int32]
    of_corner: NDArray[np.int32]


def mesh_edges(triangles: NDArray[Any], count: int) -> MeshEdges:
    """The edges of triangles (m, 3) of a mesh of `count` vertices."""
    start = triangles.ravel().astype(np.int64)
    end = np.roll(triangles, -1, axis=1).ravel().astype(np.int64)
    keys, of_corner = np.unique(np.minimum(start, end) * count + np.maximum(start, end), return_inverse=True)
    return MeshEdges(np.stack(np.divmod(keys, count), axis=1).astype(np.int32), of_corner.astype(np.int32))


def between_kinds(of_corner: NDArray[np.int32], edges: int, kind: NDArray[np.integer[Any]]) -> NDArray[np.bool_]:
    """Which edges lie between triangles of different kind (m,), and so are sharp."""
    label = np.repeat(kind.astype(np.float64), 3)
    faces = np.bincount(of_corner, minlength=edges)
    total, squares = (np.bincount(of_corner, values, edges) for values in (label, label**2))
    return np.asarray(faces * squares != total**2)
