"""How many edges of a mesh of polygons belong to one face only."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.mesh_faults import polygon_edges
from lappet.geometry.surface_check import unique_edges

from .mesh_values import MeshValues


def directed_edges(mesh: MeshValues) -> NDArray[np.int64]:
    """The edges (k, 2) of the faces in their direction, one per corner."""
    return polygon_edges(mesh.counts.astype(np.int64), mesh.indices.astype(np.int64))


def open_edge_count(mesh: MeshValues) -> int:
    """The number of border edges."""
    _, _, uses = unique_edges(directed_edges(mesh))
    return int((uses == 1).sum())
