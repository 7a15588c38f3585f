"""A shape that moves by bones: for formats that play neither morph targets nor meshes that change from frame to frame.

What appears and disappears as one, such as an epoch's skin or one thread, has a set of bones of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.export.moving_shape import MovingShape
from lappet.geometry.skinning_decomposition import Skinning, skinning_decomposition

_MARGIN = 0.6  # of the tolerance, at which no more bones are added
_LAST_COUNTS = 0.3  # of the frames: how much more than one the last one counts for normals
_THIN = 1e-6  # mm: a tube that is not wider is not drawn


@dataclass(frozen=True, eq=False)
class BoneSet:
    """Bones that are shown and hidden together.

    Parameters
    ----------
    frames
        Time codes at which they are shown, ascending.
    vertices
        The vertices of the shape that they move, from the first to before the second.
    bind
        These vertices in the bind pose in mm, shape (n, 3).
    skinning
        Bones, and their weights at these vertices.
    error
        How far a vertex is, at most, from where it should be in these frames, in mm.
    """

    frames: tuple[float, ...]
    vertices: tuple[int, int]
    bind: NDArray[np.float64]
    skinning: Skinning
    error: float


@dataclass(frozen=True, eq=False)
class SkinnedShape:
    """A shape and what moves it.

    Parameters
    ----------
    shape
        The shape.
    normals
        Unit normals that the bones carry from the bind pose, shape (n, 3).
    sets
        Its bones, in the order of the vertices, each of which belongs to one set.
    """

    shape: MovingShape
    normals: NDArray[np.float32]
    sets: tuple[BoneSet, ...]

    @property
    def bind(self) -> NDArray[np.float64]:
        """The vertices in the bind pose in mm, shape (n, 3)."""
        return np.concatenate([each.bind for each in self.sets])

    @property
    def error(self) -> float:
        """How far a vertex is, at most, from where it should be, in mm."""
        return max(each.error for each in self.sets)


def skinned_surface(shape: MovingShape, tolerance: float, most_bones: int) -> SkinnedShape:
    """Find the bones of a surface; it is in its bind pose in its last frame.

    Parameters
    ----------
    shape
        The surface.
    tolerance
        How far a vertex may be from where it should be, in mm.
    most_bones
        How many bones it may have.

    Returns
    -------
    SkinnedShape
        The surface with its bones, be they enough or not.
    """
    count = shape.positions.shape[1]
    bones = _bones(shape, (0, count), range(len(shape.frames)), tolerance, most_bones)
    return SkinnedShape(shape, _carried_normals(shape.normals, bones.skinning), (bones,))


def skinned_tubes(shape: MovingShape, tolerance: float, most_bones: int) -> SkinnedShape:
    """Find the bones of tubes that come and go, each tube's own; each is in its bind pose when it is last drawn.

    Parameters
    ----------
    shape
        The tubes.
    tolerance
        How far a vertex may be from where it should be, in mm.
    most_bones
        How many bones a tube may have.

    Returns
    -------
    SkinnedShape
        The tubes with their bones, be they enough or not.
    """
    sets, normals = [], shape.normals[-1].copy()
    for begin, end in _pieces(shape):
        # Where a tube is not drawn, all points of a ring lie at one place.
        own = shape.positions[:, begin:end].astype(np.float64)
        width = np.linalg.norm(own[:, 1] - own[:, 0], axis=1)
        drawn = np.flatnonzero(width > _THIN).tolist() or [0]
        bones = _bones(shape, (begin, end), drawn, tolerance, most_bones)
        normals[begin:end] = _carried_normals(shape.normals[drawn, begin:end], bones.skinning)
        sets.append(bones)
    return SkinnedShape(shape, normals, tuple(sets))


def _bones(
    shape: MovingShape, vertices: tuple[int, int], rows: Sequence[int], tolerance: float, most_bones: int
) -> BoneSet:
    begin, end = vertices
    own = shape.positions[np.asarray(rows), begin:end].astype(np.float64)
    # Vertices that were divided for shading and texture are one.
    which = np.arange(end - begin) if shape.vertex is None else shape.vertex[begin:end]
    _, first, index = np.unique(which, return_index=True, return_inverse=True)
    triangles = np.concatenate([each for _, each in shape.parts])
    inside = triangles[(triangles >= begin).all(axis=1) & (triangles < end).all(axis=1)] - begin
    edges = index[np.concatenate([inside[:, [0, 1]], inside[:, [1, 2]], inside[:, [2, 0]]])]
    edges = np.unique(np.sort(edges, axis=1), axis=0)
    joined = own[:, first]
    found = skinning_decomposition(joined[-1], joined, edges, _MARGIN * tolerance, most_bones)
    skinning = Skinning(found.rotation, found.shift, found.bones[index], found.weights[index])
    error = float(np.linalg.norm(found.positions(joined[-1]) - joined, axis=2).max())
    return BoneSet(tuple(shape.frames[k] for k in rows), vertices, own[-1], skinning, error)


def _carried_normals(normals: NDArray[np.float32], skinning: Skinning) -> NDArray[np.float32]:
    """The normals of the bind pose that bones carry nearest to those of the frames; the last frame is held longest."""
    total = np.zeros((normals.shape[1], 3))
    for k in range(skinning.bones.shape[1]):
        rotation = skinning.rotation[:, skinning.bones[:, k]]
        back = np.einsum("fnij,fni->fnj", rotation, normals.astype(np.float64))
        total += skinning.weights[:, k, None] * (back.sum(axis=0) + _LAST_COUNTS * len(back) * back[-1])
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return np.where(length > 1e-6, total / np.maximum(length, 1e-6), normals[-1]).astype(np.float32)


def _pieces(shape: MovingShape) -> list[tuple[int, int]]:
    """The vertices of each tube: those of one follow each other, and no triangle joins two."""
    triangles = np.concatenate([each for _, each in shape.parts])
    reach = np.arange(shape.positions.shape[1])
    np.maximum.at(reach, triangles.min(axis=1), triangles.max(axis=1))
    farthest = np.maximum.accumulate(reach)
    ends = np.flatnonzero(farthest == np.arange(len(reach))) + 1
    return list(zip([0, *ends[:-1].tolist()], ends.tolist(), strict=True))
