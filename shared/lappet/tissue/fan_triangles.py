"""The faces of a tissue as fans of triangles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.procedure import Tissue


def fan_triangles(tissue: Tissue) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Split the faces of a tissue into fans of triangles.

    Parameters
    ----------
    tissue
        The tissue.

    Returns
    -------
    tuple[NDArray[np.int32], NDArray[np.int32]]
        Vertex indices, shape (t, 3), and the face of each triangle, shape (t,).
    """
    counts = np.asarray(tissue.face_vertex_counts, np.int64)
    starts = np.concatenate(([0], np.cumsum(counts)[:-1]))
    pieces = np.maximum(counts - 2, 0)
    face = np.repeat(np.arange(len(counts)), pieces)
    within = np.arange(len(face)) - np.repeat(np.concatenate(([0], np.cumsum(pieces)[:-1])), pieces)
    corners = np.stack([starts[face], starts[face] + within + 1, starts[face] + within + 2], axis=1)
    indices = np.asarray(tissue.face_vertex_indices, np.int32)
    return indices[corners].astype(np.int32), face.astype(np.int32)
