"""The course of a thread over the skin, which bulges between two bites.

A thread with many bites runs straight in the tissue from bite to bite, outside over the skin; the solver's runs
straight everywhere, through the skin where that bulges.
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


def rises_over_skin(
    lines: NDArray[np.float64], corners: NDArray[np.float64], ups: NDArray[np.float64], lift: float, highest: float
) -> NDArray[np.float64]:
    """Find how far threads must rise to lie on the skin between their bites.

    Parameters
    ----------
    lines
        Points of each thread in mm, shape (s, n, 3).
    corners
        The triangles of skin below each in mm, shape (s, k, 3, 3); those without an area count for nothing.
    ups
        Unit vectors out of the skin, shape (s, 3).
    lift
        How high above the skin they lie, mm.
    highest
        The most they rise, mm: skin that stands higher is a fold that hangs over the thread.

    Returns
    -------
    NDArray[np.float64]
        How far each point rises along `ups` in mm, shape (s, n), 0 or more.
    """
    rise = _heights(lines, corners, ups) + lift
    return np.where((rise > 0.0) & (rise <= highest), rise, 0.0)


def _heights(
    samples: NDArray[np.float64], corners: NDArray[np.float64], up: NDArray[np.float64]
) -> NDArray[np.float64]:
    """How far the highest triangle stands above each sample (…, s, 3) in a direction (…, 3), mm; else minus infinity.

    corners: (…, k, 3, 3) mm; all may be of several threads at once, by the axes before.
    """
    along = np.cross(up, np.eye(3)[np.abs(up).argmin(axis=-1)])
    along /= np.linalg.norm(along, axis=-1, keepdims=True)
    axes = np.stack([along, np.cross(up, along)], axis=-1)
    flat, at = corners @ axes[..., None, :, :], samples @ axes
    a, b, c = flat[..., 0, :], flat[..., 1, :] - flat[..., 0, :], flat[..., 2, :] - flat[..., 0, :]
    area = b[..., 0] * c[..., 1] - b[..., 1] * c[..., 0]
    facing = area > 1e-12  # those that face the other way are not seen from above
    share = 1.0 / np.where(facing, area, 1.0)
    b, c = b * share[..., None], c * share[..., None]
    away = at[..., :, None, :] - a[..., None, :, :]
    v = away[..., 0] * c[..., None, :, 1] - away[..., 1] * c[..., None, :, 0]
    w = b[..., None, :, 0] * away[..., 1] - b[..., None, :, 1] * away[..., 0]
    inside = facing[..., None, :] & (v >= -1e-6) & (w >= -1e-6) & (v + w <= 1.0 + 1e-6)
    z = (corners @ up[..., None, :, None])[..., None, :, :, 0]
    height = z[..., 0] + v * (z[..., 1] - z[..., 0]) + w * (z[..., 2] - z[..., 0]) - (samples @ up[..., None])
    return np.where(inside, height, -np.inf).max(axis=-1, initial=-np.inf)
