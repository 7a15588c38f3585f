"""Simple polygons in the plane: whether one crosses itself, and how far points lie inside or outside it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def crosses_itself(polygon: NDArray[np.float64]) -> bool:
    """Tell whether two sides of a closed polygon cross that do not follow each other.

    Parameters
    ----------
    polygon
        Corners in order, shape (k, 2).

    Returns
    -------
    bool
        Whether any do.
    """
    a, b = polygon, np.roll(polygon, -1, axis=0)

    def side(p: NDArray[np.float64]) -> NDArray[np.float64]:
        """On which side of each line a to b (rows) the points (columns) lie."""
        u, v = (b - a)[:, None], p[None] - a[:, None]
        return np.asarray(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])

    apart = side(a) * side(b) < 0.0
    return bool((apart & apart.T).any())


def signed_distance(points: NDArray[np.float64], polygon: NDArray[np.float64]) -> NDArray[np.float64]:
    """Measure how far points lie from a closed polygon, negative inside it.

    Parameters
    ----------
    points
        Points, shape (q, 2).
    polygon
        Corners in order, either way round, shape (k, 2).

    Returns
    -------
    NDArray[np.float64]
        Distances, shape (q,).
    """
    nearest = np.full(len(points), np.inf)
    inside = np.zeros(len(points), bool)
    for a, b in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        along = b - a
        at = np.clip((points - a) @ along / max(float(along @ along), 1e-300), 0.0, 1.0)
        nearest = np.minimum(nearest, np.linalg.norm(points - a - at[:, None] * along, axis=1))
        spans = (a[1] > points[:, 1]) != (b[1] > points[:, 1])
        with np.errstate(divide="ignore", invalid="ignore"):
            inside ^= spans & (points[:, 0] < a[0] + (points[:, 1] - a[1]) * along[0] / along[1])
    return np.where(inside, -nearest, nearest)
