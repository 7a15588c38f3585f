"""The surface that one panel draws: the tissue of a frame, the deep tissue below it and the rest of a face."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.drawing.deep_bed import DeepBed
from lappet.drawing.scenery_read import SceneryMesh
from lappet.drawing.skin_source import SkinEpoch, SkinSource
from lappet.geometry.labeled_surface import FaceOrigin

BED = len(FaceOrigin)  # what lies below the tissue and does not move
SCENERY_KINDS = ("skin", "eye", "iris", "pupil", "teeth")
SCENERY = BED + 1  # what is shown around the tissue: of the first of `SCENERY_KINDS`, and so on


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
        Vertices in mm, shape (n, 3): those of the tissue, of the bed, then of the scenery.
    rest
        The same at rest in mm, shape (n, 3).
    depth
        How deep below the skin the vertices lie at rest in mm, shape (n,).
    triangles
        Vertex indices, shape (m, 3).
    origin
        `FaceOrigin` of each triangle, `BED`, or `SCENERY` and more, shape (m,).
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


def drawn_surface(source: SkinSource, bed: DeepBed, scenery: Sequence[SceneryMesh], time: float) -> DrawnSurface:
    """Put together what a panel draws.

    Parameters
    ----------
    source
        The solved procedure.
    bed
        The tissue below it.
    scenery
        What is shown around it.
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
    around = [mesh.points.astype(np.float64) for mesh in scenery]
    points = np.vstack([tissue, below, *around])
    rest = np.vstack([source.rest(epoch).astype(np.float64), bed.rest, *around])
    deepest = float(source.depth(epoch).max(initial=0.0))
    depth = np.concatenate([source.depth(epoch).astype(np.float64), np.full(len(below), deepest)])
    depth = np.concatenate([depth, np.zeros(len(points) - len(depth))])
    meshes = [epoch.triangles, bed.triangles, *(mesh.triangles for mesh in scenery)]
    begins = np.cumsum([0, len(tissue), len(below), *(len(each) for each in around)])
    triangles = np.vstack([mesh + begin for mesh, begin in zip(meshes, begins, strict=False)]).astype(np.int64)
    kinds = [BED, *(SCENERY + _kind(mesh) for mesh in scenery)]
    beyond = [np.full(len(mesh), kind, np.int64) for mesh, kind in zip(meshes[1:], kinds, strict=True)]
    origin = np.concatenate([epoch.origin.astype(np.int64), *beyond])
    column = np.zeros(len(triangles), np.int64)
    column[: len(epoch.triangles)] = source.column(epoch)
    normals = corner_normals(points, triangles, origin)
    return DrawnSurface(time, epoch, points, rest, depth, triangles, origin, column, normals)


def _kind(mesh: SceneryMesh) -> int:
    return SCENERY_KINDS.index(mesh.kind) if mesh.kind in SCENERY_KINDS else 0


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
