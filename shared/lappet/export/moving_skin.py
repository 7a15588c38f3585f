"""The skin of each epoch and the bed below it as shapes that move."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from lappet.drawing.deep_bed import DeepBed
from lappet.drawing.skin_fields import SKIN, WOUND_WALL
from lappet.drawing.skin_read import SkinCache
from lappet.drawing.skin_source import SkinEpoch
from lappet.drawing.surface_look import BED_LOOK, SKIN_LOOK, face_looks
from lappet.export.moving_shape import MovingShape
from lappet.geometry.labeled_surface import Surface
from lappet.geometry.shading_normals import ShadingNormals
from lappet.geometry.skin_shape import uv_scale

GRID_PITCH = 5.0  # mm


def skin_shapes(cache: SkinCache, frames: Sequence[float]) -> list[MovingShape]:
    """Read the skin: a shape for each epoch that has some of the frames.

    Vertices are divided where the skin is shaded sharply or its texture is cut.

    Parameters
    ----------
    cache
        The skin cache.
    frames
        Time codes, ascending.

    Returns
    -------
    list[MovingShape]
        The shapes, named as the epochs are.
    """
    scale = grid_scale(cache)
    shapes = []
    for epoch in cache.epochs:
        own = tuple(time for time in frames if time in epoch.frames)
        if own:
            shapes.append(_skin_shape(cache, epoch, own, scale))
    return shapes


def _skin_shape(
    cache: SkinCache, epoch: SkinEpoch, frames: tuple[float, ...], scale: NDArray[np.float64]
) -> MovingShape:
    triangles = epoch.triangles
    corners = triangles.ravel().astype(np.int64)
    nothing = np.zeros(len(triangles), bool)
    st = np.zeros((len(triangles), 3, 2), np.float32) if epoch.st is None else epoch.st
    rest = cache.rest(epoch)
    shading = ShadingNormals(Surface(rest.astype(np.float64), triangles, st, epoch.origin, nothing, nothing))
    grid = (st.reshape(-1, 2) * scale / GRID_PITCH).astype(np.float32)
    grid[np.repeat(epoch.origin != SKIN, 3)] = 0.0
    keys = np.column_stack([shading.indices, grid.view(np.int32)])
    _, first, index = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    vertex, group = corners[first], shading.indices[first]
    looks, of_face = face_looks(
        cache.layers,
        epoch.origin,
        cache.column(epoch),
        cache.depth(epoch)[triangles].mean(axis=1),
        bool(cache.scenery),
    )
    faces = index.reshape(-1, 3).astype(np.int32)
    solved = [cache.positions(epoch, time) for time in frames]
    return MovingShape(
        epoch.name,
        tuple((look, faces[of_face == k]) for k, look in enumerate(looks)),
        frames,
        np.stack([points[vertex] for points in solved]),
        np.stack([shading.at(points)[group] for points in solved]),
        grid[first],
        vertex,
    )


def grid_scale(cache: SkinCache) -> NDArray[np.float64]:
    """Measure what a unit of the skin's texture coordinates is.

    Parameters
    ----------
    cache
        The skin cache.

    Returns
    -------
    NDArray[np.float64]
        Millimetres on the skin in a unit of u and of v, shape (2,).
    """
    first = cache.epochs[0]
    if first.st is None:
        return np.ones(2)
    skin = first.origin == SKIN
    return uv_scale(cache.positions(first, first.frames[0]), first.triangles[skin], first.st[skin])


def bed_shape(cache: SkinCache, frames: Sequence[float]) -> MovingShape | None:
    """Find the deep tissue in an open wound, in the frames after the first cut.

    Parameters
    ----------
    cache
        The skin cache.
    frames
        Time codes, ascending.

    Returns
    -------
    MovingShape | None
        The shape; None where nothing is cut, or nothing lies below.
    """
    cut = [time for time in frames if (cache.epoch_at(time).origin == WOUND_WALL).any()]
    bed = DeepBed(cache) if cut else None
    if bed is None or not len(bed):
        return None
    positions = np.stack([bed.positions(time) for time in cut])
    normals = np.stack([smooth_normals(points, bed.triangles) for points in positions])
    return MovingShape("bed", ((BED_LOOK, bed.triangles),), tuple(cut), positions, normals)


def scenery_shapes(cache: SkinCache, frames: Sequence[float]) -> list[MovingShape]:
    """Read what is shown around the tissue; it does not move.

    Parameters
    ----------
    cache
        The skin cache.
    frames
        Time codes, ascending.

    Returns
    -------
    list[MovingShape]
        A shape for each mesh.
    """
    shapes = []
    for mesh in cache.scenery:
        positions = np.repeat(mesh.points[None], len(frames), axis=0)
        normals = np.repeat(smooth_normals(mesh.points, mesh.triangles)[None], len(frames), axis=0)
        shapes.append(MovingShape(mesh.name, ((SKIN_LOOK, mesh.triangles),), tuple(frames), positions, normals))
    return shapes


def smooth_normals(points: NDArray[np.float32], triangles: NDArray[np.int32]) -> NDArray[np.float32]:
    """Compute unit normals of a smooth mesh, weighted by the areas of its triangles.

    Parameters
    ----------
    points
        Vertices, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).

    Returns
    -------
    NDArray[np.float32]
        Normals, shape (n, 3); (0, 0, 1) where a vertex has no area.
    """
    corners = points[triangles].astype(np.float64)
    face = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    total = np.zeros((len(points), 3))
    for axis in range(3):
        total[:, axis] = np.bincount(triangles.ravel(), np.repeat(face[:, axis], 3), len(points))
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return np.where(length > 1e-12, total / np.maximum(length, 1e-12), (0.0, 0.0, 1.0)).astype(np.float32)
