"""Values at the vertices of a surface that spread along its edges: means around, and limits to how fast they change."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_ROUNDS = 1000


def means_around(values: NDArray[np.float64], edges: NDArray[np.int64]) -> NDArray[np.float64]:
    """Average values over the neighbors of each vertex.

    Parameters
    ----------
    values
        A value for each vertex, shape (n,) or (n, k).
    edges
        Undirected edges, each once, shape (e, 2).

    Returns
    -------
    NDArray[np.float64]
        The means, of the shape of `values`; the vertex's own value where it has no neighbor.
    """
    flat = values.reshape(len(values), -1)
    a, b = edges.T
    degree = np.bincount(edges.reshape(-1), minlength=len(values))
    sums = np.stack(
        [np.bincount(a, row[b], len(values)) + np.bincount(b, row[a], len(values)) for row in flat.T], axis=1
    )
    around = np.where(degree[:, None] > 0, sums / np.maximum(degree, 1)[:, None], flat)
    return np.asarray(around.reshape(values.shape))


def limit_slope(
    values: NDArray[np.float64], edges: NDArray[np.int64], lengths: NDArray[np.float64], slope: float
) -> NDArray[np.float64]:
    """Lower values at vertices until no edge is steeper than a slope.

    The result is the largest function below the values whose difference along each edge is at most `slope` times the
    edge's length.

    Parameters
    ----------
    values
        A value for each vertex, shape (n,).
    edges
        Undirected edges, shape (e, 2).
    lengths
        Lengths of the edges, shape (e,).
    slope
        The steepest change of a value by length.

    Returns
    -------
    NDArray[np.float64]
        The lowered values, shape (n,).
    """
    result = np.array(values, np.float64)
    a, b = edges.T
    rise = slope * lengths
    for _ in range(_ROUNDS):
        before = result.copy()
        np.minimum.at(result, a, before[b] + rise)
        np.minimum.at(result, b, before[a] + rise)
        if np.array_equal(result, before):
            break
    return result
