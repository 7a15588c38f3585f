"""Make a triangle surface manifold by taking it apart where more than two triangles meet.

At an edge of more than two triangles, those pairs stay joined that face alike and turn least; the others end there. At
a vertex where fans of triangles meet that share no edge, each fan gets a vertex of its own.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.surface_check import directed_edges, unique_edges
from lappet.geometry.triangles import area_normals, directions


def separate_sheets(
    points: NDArray[np.float64], triangles: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64], int]:
    """Take a surface apart where it is not manifold.

    Parameters
    ----------
    points
        Vertices, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).

    Returns
    -------
    tuple[NDArray[np.int64], NDArray[np.int64], int]
        The vertex that each new vertex is a copy of, shape (k,), of which the first n are the old ones; the triangles,
        shape (m, 3); and how many edges had more than two triangles.
    """
    one, two, crowded = _joined(points, triangles)
    # Corners of two triangles at a vertex of an edge that joins them are the same.
    count = len(triangles)
    label = np.arange(3 * count)
    pairs = []
    for side in (0, 1):
        first = _corner_at(triangles, one, side)
        vertex = triangles.reshape(-1)[first]
        second = np.argmax(triangles[two % count] == vertex[:, None], axis=1) + 3 * (two % count)
        pairs.append(np.stack([first, second], axis=1))
    joined = np.concatenate(pairs)
    while True:
        low = label[joined].min(axis=1)
        following = label.copy()
        np.minimum.at(following, joined[:, 0], low)
        np.minimum.at(following, joined[:, 1], low)
        following = following[following]
        if np.array_equal(following, label):
            break
        label = following
    fans, fan = np.unique(label, return_inverse=True)
    owner = triangles.reshape(-1)[fans]
    # The first fan of a vertex keeps it.
    _, first = np.unique(owner, return_index=True)
    name = np.empty(len(fans), np.int64)
    rest = np.ones(len(fans), bool)
    rest[first] = False
    name[first] = owner[first]
    name[rest] = len(points) + np.arange(int(rest.sum()))
    source = np.concatenate([np.arange(len(points)), owner[rest]])
    return source, name[fan.reshape(-1)].reshape(-1, 3), crowded


def _corner_at(triangles: NDArray[np.int64], edge: NDArray[np.int64], side: int) -> NDArray[np.int64]:
    """The corner, 3 f + k, at the beginning or the end of directed edges, numbered as `directed_edges` does."""
    count = len(triangles)
    return 3 * (edge % count) + (edge // count + side) % 3


def _joined(
    points: NDArray[np.float64], triangles: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64], int]:
    """The pairs of directed edges at which two triangles stay joined, and how many edges have more than two."""
    edges = directed_edges(triangles)
    count = len(triangles)
    _, inverse, uses = unique_edges(edges)
    order = np.argsort(inverse, kind="stable")
    starts = np.cumsum(uses) - uses
    simple = starts[uses == 2]
    one, two = [order[simple]], [order[simple + 1]]
    normals = directions(area_normals(points[triangles]))
    crowded = np.flatnonzero(uses > 2)
    for edge in crowded.tolist():
        around = order[starts[edge] : starts[edge] + uses[edge]]
        faces = around % count
        alike = edges[around, 0][:, None] != edges[around, 0][None]
        # A fold back has the cosine -1 where faces are oriented alike; those that are not are turned for it.
        turn = normals[faces] @ normals[faces].T * np.where(alike, 1.0, -1.0) + np.where(alike, 0.0, -4.0)
        turn[np.tril_indices(len(faces))] = -np.inf
        while np.isfinite(turn).any():
            i, j = np.unravel_index(int(turn.argmax()), turn.shape)
            one.append(around[i : i + 1])
            two.append(around[j : j + 1])
            for k in (i, j):
                turn[k, :] = turn[:, k] = -np.inf
    return np.concatenate(one), np.concatenate(two), len(crowded)
