"""Split chosen edges of a labeled surface and the triangles on both sides of them; nothing opens."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.labeled_surface import Surface


def split_edges(surface: Surface, edges: NDArray[np.integer], at: NDArray[np.float64]) -> Surface:
    """Put a new vertex on chosen edges, and split the triangles on both sides of them.

    Parameters
    ----------
    surface
        The surface.
    edges
        Vertex pairs, smaller index first, each once, shape (k, 2).
    at
        Where on each edge, from 0 at its first vertex to 1, both excluded, shape (k,).

    Returns
    -------
    Surface
        The surface with labels and UVs carried over; new vertices follow the old ones in the order of `edges`.

    Raises
    ------
    ValueError
        If all three edges of a triangle are to be split.
    """
    n = len(surface.points)
    a, b = surface.points[edges[:, 0]], surface.points[edges[:, 1]]
    points = np.concatenate([surface.points, a + (b - a) * at[:, None]])
    key = edges[:, 0].astype(np.int64) * n + edges[:, 1]
    order = np.argsort(key, kind="stable")

    t = surface.triangles.astype(np.int64)
    following = np.roll(t, -1, axis=1)
    wanted = np.minimum(t, following) * n + np.maximum(t, following)
    slot = np.minimum(np.searchsorted(key[order], wanted), len(key) - 1)
    hit = key[order][slot] == wanted
    which = np.where(hit, order[slot], -1)  # the split of edge c -> c + 1 of each triangle
    count = hit.sum(axis=1)
    if (count == 3).any():
        raise ValueError("split_edges: a triangle has three edges to split; split two at most")

    # Turn each triangle so that its split edges come first (one: edge 0; two: edges 0 and 1).
    turn = np.where(count == 1, hit.argmax(axis=1), np.where(count == 2, ((~hit).argmax(axis=1) + 1) % 3, 0))
    pick = (turn[:, None] + np.arange(3)) % 3
    t, which = np.take_along_axis(t, pick, axis=1), np.take_along_axis(which, pick, axis=1)
    uv = np.take_along_axis(surface.uv.astype(np.float64), pick[:, :, None], axis=1)

    corner = np.concatenate([t, n + which], axis=1)  # v0 v1 v2 m01 m12 m20
    fraction = at[np.maximum(which, 0)]
    flipped = t > np.roll(t, -1, axis=1)
    fraction = np.where(flipped, 1.0 - fraction, fraction)[:, :, None]
    corner_uv = np.concatenate([uv, uv + (np.roll(uv, -1, axis=1) - uv) * fraction], axis=1)

    pieces, piece_uv, parent = [], [], []
    for number, pattern in ((0, [(0, 1, 2)]), (1, [(0, 3, 2), (3, 1, 2)]), (2, [(3, 1, 4), (0, 3, 4), (0, 4, 2)])):
        rows = np.flatnonzero(count == number)
        for corners in pattern:
            pieces.append(corner[rows][:, corners])
            piece_uv.append(corner_uv[rows][:, corners])
            parent.append(rows)
    source = np.concatenate(parent)
    order = np.argsort(source, kind="stable")
    source = source[order]
    return surface.of_faces(source, points, np.concatenate(pieces)[order], np.concatenate(piece_uv)[order])
