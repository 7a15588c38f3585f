"""The parts of a triangle surface that share no vertex."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def parts_of(triangles: NDArray[np.int64], size: int) -> NDArray[np.int64]:
    """Number the connected parts of a surface by their first vertex.

    Parameters
    ----------
    triangles
        Vertex indices, shape (m, 3).
    size
        Number of vertices.

    Returns
    -------
    NDArray[np.int64]
        Part of each triangle, shape (m,).
    """
    label = np.arange(size)
    t = triangles
    while True:
        low = label[t].min(axis=1)
        following = label.copy()
        for k in range(3):
            np.minimum.at(following, t[:, k], low)
        following = following[following]
        if np.array_equal(following, label):
            return np.unique(label[t[:, 0]], return_inverse=True)[1].reshape(-1)
        label = following
