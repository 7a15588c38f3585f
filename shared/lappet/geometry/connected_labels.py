"""Connected pieces of points that edges join."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def connected_labels(count: int, edges: NDArray[np.int64]) -> NDArray[np.int64]:
    """Label the connected pieces of a graph: the least label spreads until nothing changes.

    Parameters
    ----------
    count
        Number of points.
    edges
        Pairs of points that are joined, shape (k, 2).

    Returns
    -------
    NDArray[np.int64]
        For each point the least point of its piece, shape (count,); a point without an edge is a piece of its own.
    """
    label = np.arange(count)
    while True:
        least = np.minimum(label[edges[:, 0]], label[edges[:, 1]])
        fresh = label.copy()
        for side in (0, 1):
            np.minimum.at(fresh, edges[:, side], least)
        fresh = fresh[fresh]
        if np.array_equal(fresh, label):
            return label
        label = fresh
