"""Values inside a plane outline from those on it: mean value coordinates.

Hormann and Floater 2006, "Mean value coordinates for arbitrary planar polygons": where a place x sees an edge from a to
b at the signed angle alpha, its ends weigh `tan(alpha / 2)` over their distances `norm(a - x)` and `norm(b - x)`.
Linear values are reproduced exactly, and outlines may have holes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_NEAR = 1e-9  # of the outline's extent: places so near to a corner have its value
_BATCH = 512


def mean_values(
    places: NDArray[np.float64], edges: NDArray[np.float64], values: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Find the values at places inside an outline from those at its ends.

    Parameters
    ----------
    places
        The places, shape (q, 2). One on an edge has the value that is linear between its ends.
    edges
        Edges of the outline, turned alike, shape (e, 2, 2).
    values
        Values at their ends, shape (e, 2, k).

    Returns
    -------
    NDArray[np.float64]
        The values, shape (q, k).
    """
    found = np.empty((len(places), values.shape[2]))
    near = _NEAR * float(np.ptp(edges.reshape(-1, 2), axis=0).max())
    for first in range(0, len(places), _BATCH):
        rows = slice(first, first + _BATCH)
        ways = edges[None] - places[rows, None, None, :]
        length = np.linalg.norm(ways, axis=-1)
        one, two = ways[:, :, 0], ways[:, :, 1]
        turn = one[..., 0] * two[..., 1] - one[..., 1] * two[..., 0]
        ahead = (one * two).sum(axis=-1)
        product = length[..., 0] * length[..., 1]
        # tan(alpha / 2) = sin / (1 + cos); on the edge itself it grows beyond all others.
        half = turn / np.maximum(product + ahead, 1e-12 * np.maximum(product, 1e-300))
        on_edge = (np.abs(turn) <= 1e-12 * product) & (ahead < 0.0)
        half = np.where(on_edge, 1e12, half)
        weights = half[..., None] / np.maximum(length, 1e-300)
        total = weights.sum(axis=(1, 2))
        found[rows] = np.einsum("qes,esk->qk", weights, values) / total[:, None]
        flat = length.reshape(len(length), -1)
        corner = flat.argmin(axis=1)
        at_corner = flat[np.arange(len(flat)), corner] <= near
        found[rows][at_corner] = values.reshape(-1, values.shape[2])[corner[at_corner]]
    return found
