"""Split polygons into triangles: quads along their shorter diagonal, larger ones by ears."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode


def triangulate(
    points: NDArray[np.float64], counts: NDArray[np.int64], indices: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Split polygons into triangles.

    Parameters
    ----------
    points
        Vertices in mm, shape (n, 3).
    counts
        Corners of each polygon, shape (m,).
    indices
        Vertices of the polygons, shape (k,).

    Returns
    -------
    tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]
        Vertices, shape (t, 3), face corners, shape (t, 3), and face, shape (t,), of each triangle.

    Raises
    ------
    RefusedError
        If no polygon has three or more corners.
    """
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    pieces, owners = [], []
    for size in np.unique(counts):
        faces = np.flatnonzero(counts == size)
        corner = starts[faces][:, None] + np.arange(size)
        if size == 3:
            pieces.append(corner)
            owners.append(faces)
        elif size == 4:
            p = points[indices[corner]]
            other = np.sum((p[:, 1] - p[:, 3]) ** 2, axis=1) < np.sum((p[:, 0] - p[:, 2]) ** 2, axis=1) * (1 - 1e-9)
            split = np.where(other[:, None], [1, 2, 3, 1, 3, 0], [0, 1, 2, 0, 2, 3])
            pieces.append(np.take_along_axis(corner, split, axis=1).reshape(-1, 3))
            owners.append(np.repeat(faces, 2))
        elif size > 4:
            for face, row in zip(faces, corner, strict=True):
                ears = clip_ears(points[indices[row]])
                pieces.append(row[ears])
                owners.append(np.full(len(ears), face))
    if not pieces:
        raise refused(ProblemCode.MESH_NO_FACE)
    corners: NDArray[np.int64] = np.vstack(pieces)
    owner: NDArray[np.int64] = np.concatenate(owners)
    order = np.argsort(owner, kind="stable")
    corners = corners[order]
    return np.asarray(indices[corners], np.int64), corners, owner[order]


def clip_ears(polygon: NDArray[np.float64]) -> NDArray[np.int64]:
    """Split one polygon by ear clipping in the plane of its mean normal.

    Parameters
    ----------
    polygon
        Corners in order, shape (n, 3).

    Returns
    -------
    NDArray[np.int64]
        Corner indices of the triangles, shape (n - 2, 3).
    """
    normal = np.cross(polygon, np.roll(polygon, -1, axis=0)).sum(axis=0)
    axis = int(np.abs(normal).argmax())
    keep = [(axis + 1) % 3, (axis + 2) % 3]
    flat = polygon[:, keep] * np.array([1.0, 1.0 if normal[axis] >= 0 else -1.0])

    def turn(a: int, b: int, c: int) -> float:
        u, v = flat[b] - flat[a], flat[c] - flat[a]
        return float(u[0] * v[1] - u[1] * v[0])

    ring = list(range(len(polygon)))
    ears = []
    while len(ring) > 3:
        best, best_value = 0, -np.inf
        for k in range(len(ring)):
            a, b, c = ring[k - 1], ring[k], ring[(k + 1) % len(ring)]
            value = turn(a, b, c)
            blocked = value <= 0 or any(
                turn(a, b, q) >= 0 and turn(b, c, q) >= 0 and turn(c, a, q) >= 0 for q in ring if q not in (a, b, c)
            )
            sides = sum(float(np.sum((flat[i] - flat[j]) ** 2)) for i, j in ((a, b), (b, c), (c, a)))
            quality = value / max(sides, 1e-300) - (10.0 if blocked else 0.0)
            if quality > best_value:
                best, best_value = k, quality
        ears.append([ring[best - 1], ring[best], ring[(best + 1) % len(ring)]])
        del ring[best]
    return np.array([*ears, ring], np.int64)
