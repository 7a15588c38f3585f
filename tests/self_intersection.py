"""Whether a surface passes through itself, by a library that shares nothing with the daemon."""

from __future__ import annotations

import ipctk
import numpy as np
from numpy.typing import ArrayLike


def passes_through_itself(points: ArrayLike, triangles: ArrayLike) -> bool:
    """Whether an edge goes through a face, after the IPC Toolkit (Li et al. 2020); points in mm, shape (n, 3)."""
    places, faces = np.asarray(points, np.float64), np.asarray(triangles, np.int32)
    edges = ipctk.edges(faces)
    return bool(ipctk.has_intersections(ipctk.CollisionMesh(places, edges, faces), places))
