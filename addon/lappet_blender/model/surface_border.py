"""How many edges of a mesh of polygons belong to one face only."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.mesh_faults import polygon_edges

from .mesh_values import MeshValues


def directed_edges(mesh: MeshValues) -> NDArray[np.int64]:
    """The edges (k, 2) of the faces in their direction, one per corner."""
    return polygon_edges(mesh.counts.astype(np.int64), mesh.indices.astype(np.int64))


def open_edge_count(mesh: MeshValues) -> int:
    """The number of border edges."""
    first, second = directed_edges(mesh).T
    key = np.minimum(first, second) * len(mesh.points) + np.maximum(first, second)
    key.sort()  # by itself: to say which edge is which takes four times as long
    other = np.concatenate([[True], key[1:] != key[:-1], [True]])
    return int((other[1:] & other[:-1]).sum()) if len(key) else 0
