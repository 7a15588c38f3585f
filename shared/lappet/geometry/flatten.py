"""Flatten a patch of skin to the plane with little distortion, in mm: texture coordinates for a sheet."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.border_loops import border_loops
from lappet.geometry.connected_parts import parts_of
from lappet.geometry.injective_layout import injective_layout, signed_areas
from lappet.geometry.normals import corner_normals
from lappet.geometry.surface_check import directed_edges, unique_edges
from lappet.geometry.triangles import areas

_ROUNDS = 400
_LEAST_AREA = 0.02  # of a triangle's: one that is smaller in the plane counts as turned over
_KEPT = 0.4  # of the patch's reach: lengths matter within, and less and less beyond
_MIDDLE = 0.1  # of the points, those nearest to the middle: there a layout without turned triangles is placed
_ALIKE = 1e-6  # relative: the two halves of a symmetric patch differ by less, for rounding alone
_DECIMALS = 4  # in mm: processors that round differently differ by a millionth of the last


def flatten(points: NDArray[np.float64], triangles: NDArray[np.int64]) -> NDArray[np.float64]:
    """Flatten a patch to the plane with little distortion.

    The patch is laid out by the azimuthal equidistant projection of the sphere that fits it best, seen from its middle;
    then springs along the edges relax towards their true lengths. Where that turns triangles over, as at a nose, the
    patch is laid out without (`lappet.geometry.injective_layout`), if it has a border and no handle; lengths are kept
    best near its middle, and coordinates are rounded to 0.0001 mm, so that they are the same on every machine. x runs
    along the widest direction of the coordinate axes, y to its left seen from outside.

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
    apex = points[_first_least(np.linalg.norm(points - points.mean(axis=0), axis=1))]
    wide = np.eye(3)[_first_least(-np.ptp(points, axis=0) * (1.0 - axis**2))]
    first = wide - np.dot(wide, axis) * axis
    first /= np.linalg.norm(first)
    frame = np.stack([first, np.cross(axis, first)])

    offset = points - apex
    flat = offset @ frame.T
    chord = np.linalg.norm(offset, axis=1)
    radius = _sphere_radius(points)
    arc = 2.0 * radius * np.arcsin(np.clip(chord / (2.0 * radius), 0.0, 1.0))
    seen = flat * (arc / np.maximum(np.linalg.norm(flat, axis=1), 1e-300))[:, None]

    edges = unique_edges(directed_edges(triangles))[0]
    a, b = np.ascontiguousarray(edges.T)
    length = np.linalg.norm(points[a] - points[b], axis=1)
    weight = 1.0 / np.maximum(length, 1e-9 * length.max())
    total = np.bincount(a, weight, len(points)) + np.bincount(b, weight, len(points))
    u, v = np.ascontiguousarray(seen[:, 0]), np.ascontiguousarray(seen[:, 1])
    stiff = 0.5 * weight
    for _ in range(_ROUNDS):
        across, up = u[b] - u[a], v[b] - v[a]
        size = np.maximum(np.sqrt(across * across + up * up), 1e-300)
        pull = stiff * (size - length) / size
        along, upward = pull * across, pull * up
        u = u + 1.6 * (np.bincount(a, along, len(u)) - np.bincount(b, along, len(u))) / total
        v = v + 1.6 * (np.bincount(a, upward, len(v)) - np.bincount(b, upward, len(v))) / total
    uv = np.stack([u, v], axis=1)
    return np.asarray(uv) if _whole(uv, points, triangles) else _without_turned(seen, uv, chord, points, triangles)


def _first_least(values: NDArray[np.float64]) -> int:
    """The first of the values that is the least one but for rounding."""
    return int((values <= values.min() + _ALIKE * np.abs(values).max()).argmax())


def _whole(uv: NDArray[np.float64], points: NDArray[np.float64], triangles: NDArray[np.int64]) -> bool:
    return bool((signed_areas(uv, triangles) > _LEAST_AREA * areas(points[triangles])).all())


def _without_turned(
    seen: NDArray[np.float64],
    uv: NDArray[np.float64],
    away: NDArray[np.float64],
    points: NDArray[np.float64],
    triangles: NDArray[np.int64],
) -> NDArray[np.float64]:
    """A layout without turned triangles where there is one, else `uv`.

    It is placed as the projection `seen` is near the middle, from which the points are `away` (n,). Springs that fold
    never settle, so where they are in the end depends on how a processor rounds.
    """
    edges, _, uses = unique_edges(directed_edges(triangles))
    parts = int(parts_of(triangles, len(points)).max()) + 1
    # Euler's characteristic of a disc with holes: 2 less one for each border.
    round_ = len(points) - len(edges) + len(triangles) == 2 - len(border_loops(triangles))
    if parts > 1 or uses.max() > 2 or not (uses == 1).any() or not round_:
        return uv
    far = away[triangles].mean(axis=1) / max(float(away.max()), 1e-300)
    layout = injective_layout(points, triangles, 1.0 / (1.0 + (far / _KEPT) ** 4))
    if not (signed_areas(layout, triangles) > 0.0).all():
        return uv
    near = away <= np.quantile(away, _MIDDLE) * (1.0 + _ALIKE)
    middle, before = layout[near].mean(axis=0), seen[near].mean(axis=0)
    u, _, v = np.linalg.svd((layout[near] - middle).T @ (seen[near] - before))
    turn = u @ np.diag([1.0, np.sign(np.linalg.det(u @ v))]) @ v
    layout = (layout - middle) @ turn + before
    rounded = np.round(layout, _DECIMALS)
    return np.asarray(rounded if (signed_areas(rounded, triangles) > 0.0).all() else layout)


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
