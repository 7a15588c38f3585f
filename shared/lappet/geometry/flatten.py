"""Flatten a patch of skin to the plane with little distortion, in mm: texture coordinates for a sheet."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.normals import corner_normals
from lappet.geometry.surface_check import directed_edges, unique_edges

_ROUNDS = 400


def flatten(points: NDArray[np.float64], triangles: NDArray[np.int64]) -> NDArray[np.float64]:
    """Flatten a patch to the plane with little distortion.

    The patch is laid out by the azimuthal equidistant projection of the sphere that fits it best, seen from its middle;
    then springs along the edges relax towards their true lengths. x runs along the widest direction of the coordinate
    axes, y to its left seen from outside.

    Parameters
    ----------
    points
        Vertices in mm, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).

    Returns
    -------
    NDArray[np.float64]
        Plane coordinates in mm, shape (n, 2), with (0, 0) near the patch's middle.
    """
    corner = corner_normals(points, triangles)
    axis = corner.reshape(-1, 3).sum(axis=0)
    axis = axis / max(float(np.linalg.norm(axis)), 1e-300)
    apex = points[int(np.linalg.norm(points - points.mean(axis=0), axis=1).argmin())]
    wide = np.eye(3)[int((np.ptp(points, axis=0) * (1.0 - axis**2)).argmax())]
    first = wide - np.dot(wide, axis) * axis
    first /= np.linalg.norm(first)
    frame = np.stack([first, np.cross(axis, first)])

    offset = points - apex
    flat = offset @ frame.T
    chord = np.linalg.norm(offset, axis=1)
    radius = _sphere_radius(points)
    arc = 2.0 * radius * np.arcsin(np.clip(chord / (2.0 * radius), 0.0, 1.0))
    uv = flat * (arc / np.maximum(np.linalg.norm(flat, axis=1), 1e-300))[:, None]

    edges = unique_edges(directed_edges(triangles))[0]
    a, b = edges.T
    length = np.linalg.norm(points[a] - points[b], axis=1)
    weight = 1.0 / np.maximum(length, 1e-9 * length.max())
    total = np.bincount(a, weight, len(points)) + np.bincount(b, weight, len(points))
    for _ in range(_ROUNDS):
        along = uv[b] - uv[a]
        size = np.maximum(np.linalg.norm(along, axis=1), 1e-300)
        pull = (0.5 * weight * (size - length) / size)[:, None] * along
        step = np.stack(
            [np.bincount(a, pull[:, k], len(points)) - np.bincount(b, pull[:, k], len(points)) for k in range(2)],
            axis=1,
        )
        uv = uv + 1.6 * step / total[:, None]
    return np.asarray(uv)


def _sphere_radius(points: NDArray[np.float64]) -> float:
    """The radius in mm of the least-squares sphere through points, very large for a plane."""
    middle = points.mean(axis=0)
    p = points - middle
    size = float(np.linalg.norm(p, axis=1).max())
    p = p / size
    spread = np.linalg.svd(p, compute_uv=False)
    if spread[2] < 1e-4 * spread[0]:
        return 1e4 * size
    system = np.column_stack([2.0 * p, np.ones(len(p))])
    solution = np.linalg.lstsq(system, np.einsum("ij,ij->i", p, p), rcond=1e-12)[0]
    squared = float(solution[3] + solution[:3] @ solution[:3])
    return size * min(float(np.sqrt(max(squared, 0.25))), 1e4)
