"""Quantities of a surface at rest that the look of the skin draws: millimetres of the printed grid, depth of walls."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.labeled_surface import FaceOrigin


def uv_scale(positions: NDArray[Any], triangles: NDArray[np.int32], st: NDArray[np.float32]) -> NDArray[np.float64]:
    """Compute the millimetres per unit of u and of v.

    They are the medians of ``|∂p/∂u|`` and ``|∂p/∂v|`` over the triangles.

    Triangles without area in the UV plane are left out.

    Parameters
    ----------
    positions
        Vertices in mm, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).
    st
        Texture coordinates of the corners, shape (m, 3, 2).

    Returns
    -------
    NDArray[np.float64]
        Both, shape (2,); (1, 1) where no triangle is left.
    """
    p = positions[triangles].astype(np.float64)
    e1, e2 = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
    d1, d2 = (st[:, k].astype(np.float64) - st[:, 0] for k in (1, 2))
    det = d1[:, 0] * d2[:, 1] - d1[:, 1] * d2[:, 0]
    good = np.abs(det) > 1e-12 * max(float(np.abs(det).max(initial=0.0)), 1e-300)
    if not good.any():
        return np.ones(2)
    inverse = 1.0 / det[good][:, None]
    along_u = (e1[good] * d2[good, 1:2] - e2[good] * d1[good, 1:2]) * inverse
    along_v = (e2[good] * d1[good, 0:1] - e1[good] * d2[good, 0:1]) * inverse
    return np.array([np.median(np.linalg.norm(g, axis=1)) for g in (along_u, along_v)])


def depth_below_skin(
    positions: NDArray[Any], triangles: NDArray[np.int32], origin: NDArray[np.uint8]
) -> NDArray[np.float32]:
    """Measure how far every wall and rim vertex is from the nearest edge vertex of the skin.

    Parameters
    ----------
    positions
        Vertices in mm, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).
    origin
        `FaceOrigin` of each triangle, shape (m,).

    Returns
    -------
    NDArray[np.float32]
        Distances in mm, shape (n,); 0 elsewhere.
    """
    depth = np.zeros(len(positions), np.float32)
    skin = np.unique(triangles[origin == FaceOrigin.SKIN])
    side = np.unique(triangles[(origin == FaceOrigin.WOUND_WALL) | (origin == FaceOrigin.RIM)])
    border = np.intersect1d(skin, side)
    inner = np.setdiff1d(side, skin)
    if len(border):
        vertices = ClosestPoint(positions, np.stack([border] * 3, axis=1))
        depth[inner] = vertices.query(positions[inner])[2]
    return depth
