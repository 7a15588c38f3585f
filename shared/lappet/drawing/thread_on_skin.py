"""The course of a thread with many bites: in the tissue straight from bite to bite, outside over the skin.

The solver's thread runs straight everywhere, through the skin where that bulges between two bites.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

ON_SKIN = 0.35  # mm that a bite on the skin may lie off its nearest triangle's plane
_ALONG = np.linspace(0.0, 1.0, 11)[1:-1, None]


def laid_on_skin(
    bites: NDArray[np.float64], points: NDArray[np.floating], triangles: NDArray[np.integer], lift: float
) -> NDArray[np.float64]:
    """Lay a thread with many bites on the skin.

    Parameters
    ----------
    bites
        The bites in mm, shape (n, 3).
    points
        Vertices of the surface in mm, shape (v, 3).
    triangles
        Vertex indices of its skin, shape (m, 3).
    lift
        How high above the skin the thread lies between two bites on it, mm.

    Returns
    -------
    NDArray[np.float64]
        The thread through all bites in mm, shape (k, 3).
    """
    low, high = bites.min(axis=0), bites.max(axis=0)
    reach = float(np.linalg.norm(np.diff(bites, axis=0), axis=1).max(initial=0.0))
    middles = points[triangles].mean(axis=1)
    near = ((middles > low - reach) & (middles < high + reach)).all(axis=1)
    corners = np.asarray(points[triangles[near]], np.float64)
    if not len(corners):
        return bites
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    centers = corners.mean(axis=1)
    own = np.linalg.norm(bites[:, None] - centers, axis=2).argmin(axis=1)
    outside = np.abs(np.einsum("ki,ki->k", bites - centers[own], normals[own])) < ON_SKIN
    line = [bites[:1]]
    for k in range(len(bites) - 1):
        first, second = bites[k], bites[k + 1]
        size = float(np.linalg.norm(second - first))
        if outside[k] and outside[k + 1] and size > 2.0 * lift:
            up = normals[own[k]] + normals[own[k + 1]]
            up /= max(float(np.linalg.norm(up)), 1e-12)
            some = corners[np.linalg.norm(centers - 0.5 * (first + second), axis=1) < size]
            samples = first + _ALONG * (second - first)
            line.append(samples + np.maximum(_heights(samples, some, up) + lift, 0.0)[:, None] * up)
        line.append(second[None])
    return np.concatenate(line)


def _heights(
    samples: NDArray[np.float64], corners: NDArray[np.float64], up: NDArray[np.float64]
) -> NDArray[np.float64]:
    """How far the highest triangle stands above each sample (s,) in a direction, mm; minus infinity where none does."""
    along = np.cross(up, np.eye(3)[int(np.argmin(np.abs(up)))])
    along /= np.linalg.norm(along)
    axes = np.stack([along, np.cross(up, along)], axis=1)
    flat, at = corners @ axes, samples @ axes
    a, b, c = flat[:, 0], flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
    area = b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0]
    facing = area > 1e-12  # those that face the other way are not seen from above
    away = at[:, None] - a[facing]
    b, c, area = b[facing], c[facing], area[facing]
    v = (away[..., 0] * c[:, 1] - away[..., 1] * c[:, 0]) / area
    w = (b[:, 0] * away[..., 1] - b[:, 1] * away[..., 0]) / area
    inside = (v >= -1e-6) & (w >= -1e-6) & (v + w <= 1.0 + 1e-6)
    z = corners[facing] @ up
    height = z[:, 0] + v * (z[:, 1] - z[:, 0]) + w * (z[:, 2] - z[:, 0]) - (samples @ up)[:, None]
    return np.where(inside, height, -np.inf).max(axis=1, initial=-np.inf)
