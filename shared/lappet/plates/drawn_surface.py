"""The surface that one panel draws: the tissue of a frame and the deep tissue below it, with what each face is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.drawing.deep_bed import DeepBed
from lappet.drawing.skin_source import SkinEpoch, SkinSource
from lappet.geometry.labeled_surface import FaceOrigin

BED = len(FaceOrigin)  # what lies below the tissue and does not move


@dataclass(frozen=True, eq=False)
class DrawnSurface:
    """A surface and what its faces are.

    Parameters
    ----------
    time
        Time code of the frame.
    epoch
        The epoch whose tissue it is.
    points
        Vertices in mm, shape (n, 3): those of the tissue, then those of the bed.
    rest
        The same at rest in mm, shape (n, 3).
    depth
        How deep below the skin the vertices lie at rest in mm, shape (n,).
    triangles
        Vertex indices, shape (m, 3).
    origin
        `FaceOrigin` of each triangle, or `BED`, shape (m,).
    column
        Column of layers that each triangle lies in, shape (m,).
    normals
        Unit normals of the corners, smooth inside faces of one origin, shape (m, 3, 3).
    """

    time: float
    epoch: SkinEpoch
    points: NDArray[np.float64]
    rest: NDArray[np.float64]
    depth: NDArray[np.float64]
    triangles: NDArray[np.int64]
    origin: NDArray[np.int64]
    column: NDArray[np.int64]
    normals: NDArray[np.float64]


def drawn_surface(source: SkinSource, bed: DeepBed, time: float) -> DrawnSurface:
    """Put together what a panel draws.

    Parameters
    ----------
    source
        The solved procedure.
    bed
        The tissue below it.
    time
        Time code of the frame.

    Returns
    -------
    DrawnSurface
        The surface.
    """
    epoch = source.epoch_at(time)
    tissue = source.positions(epoch, time).astype(np.float64)
    below = bed.positions(time).astype(np.float64)
    points = np.vstack([tissue, below])
    rest = np.vstack([source.rest(epoch).astype(np.float64), bed.rest])
    deepest = float(source.depth(epoch).max(initial=0.0))
    depth = np.concatenate([source.depth(epoch).astype(np.float64), np.full(len(below), deepest)])
    triangles = np.vstack([epoch.triangles, bed.triangles + len(tissue)]).astype(np.int64)
    origin = np.concatenate([epoch.origin.astype(np.int64), np.full(len(bed.triangles), BED, np.int64)])
    column = np.concatenate([source.column(epoch).astype(np.int64), np.zeros(len(bed.triangles), np.int64)])
    normals = corner_normals(points, triangles, origin)
    return DrawnSurface(time, epoch, points, rest, depth, triangles, origin, column, normals)


def corner_normals(
    points: NDArray[np.float64], triangles: NDArray[np.int64], origin: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Average the normals of the faces of one origin around each vertex, by their areas.

    Parameters
    ----------
    points
        Vertices in mm, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).
    origin
        What each triangle is, shape (m,).

    Returns
    -------
    NDArray[np.float64]
        Unit normals of the corners, shape (m, 3, 3).
    """
    corners = points[triangles]
    face = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    keys = (triangles + origin[:, None] * len(points)).ravel()
    used, inverse = np.unique(keys, return_inverse=True)
    total = np.stack([np.bincount(inverse, np.repeat(face[:, k], 3), len(used)) for k in range(3)], axis=1)
    lengths = np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-12)
    normals: NDArray[np.float64] = (total / lengths)[inverse].reshape(-1, 3, 3)
    return normals
