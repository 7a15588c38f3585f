"""Subdivide a mesh of quadrilaterals: Catmull and Clark 1978, with borders as cubic B-splines."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def catmull_clark(
    values: NDArray[np.float64], quads: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Divide every quadrilateral into four and smooth the surface.

    The rule is linear in the values, so that several shapes of one mesh are divided alike: as more columns.

    Parameters
    ----------
    values
        Coordinates, and whatever else is to be interpolated, of each vertex, shape (n, k).
    quads
        Vertex indices of the faces, oriented alike, shape (m, 4). Every vertex is used, and every edge by at most two
        faces.

    Returns
    -------
    tuple[NDArray[np.float64], NDArray[np.int64]]
        Values of the vertices, the old ones first, and vertex indices of shape (4m, 4).

    Examples
    --------
    >>> import numpy as np
    >>> square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    >>> values, quads = catmull_clark(square, np.array([[0, 1, 2, 3]]))
    >>> len(values), len(quads), values[8].tolist()
    (9, 4, [2.0, 2.0])
    """
    n, m = len(values), len(quads)
    following = np.roll(quads, -1, axis=1)
    ends = np.sort(np.stack([quads, following], axis=2).reshape(-1, 2), axis=1)
    edges, edge_of, uses = np.unique(ends, axis=0, return_inverse=True, return_counts=True)
    edge_of = edge_of.reshape(m, 4)
    border = uses == 1

    faces = values[quads].mean(axis=1)
    middles = values[edges].mean(axis=1)
    around = np.zeros((len(edges), values.shape[1]))
    np.add.at(around, edge_of.reshape(-1), np.repeat(faces, 4, axis=0))
    points = np.where(border[:, None], middles, 0.5 * middles + 0.25 * around)

    valence = np.bincount(quads.reshape(-1), minlength=n)[:, None].astype(np.float64)
    face_mean, edge_mean = np.zeros_like(values), np.zeros_like(values)
    np.add.at(face_mean, quads.reshape(-1), np.repeat(faces, 4, axis=0))
    for end in range(2):
        np.add.at(edge_mean, edges[:, end], middles)
    degree = np.bincount(edges.reshape(-1), minlength=n)[:, None]
    moved = (face_mean / valence + 2.0 * edge_mean / degree + (valence - 3.0) * values) / valence
    along = np.zeros_like(values)
    for end in range(2):
        np.add.at(along, edges[border, end], values[edges[border, 1 - end]])
    on_border = np.bincount(edges[border].reshape(-1), minlength=n)
    smooth = (0.75 * values) + 0.125 * along
    # Where a corner of the surface, or two borders, meet in one vertex it stays.
    moved = np.where((on_border == 2)[:, None], smooth, np.where((on_border > 0)[:, None], values, moved))
    moved[(on_border == 2) & (valence[:, 0] == 1)] = values[(on_border == 2) & (valence[:, 0] == 1)]

    middle = n + len(edges) + np.arange(m)
    after, before = n + edge_of, n + np.roll(edge_of, 1, axis=1)
    divided = np.stack([quads, after, np.broadcast_to(middle[:, None], (m, 4)), before], axis=2)
    return np.concatenate([moved, points, faces]), divided.reshape(-1, 4)
