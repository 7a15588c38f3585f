"""Cut a region out of a surface: inside a sphere or a box, with a clean border on its faces."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.normals import corner_normals
from lappet.geometry.surface_check import directed_edges, unique_edges
from lappet.geometry.triangles import directions

Level = Callable[[NDArray[np.float64]], NDArray[np.float64]]
_SNAP = 0.2  # of an edge: a vertex nearer to the border than this is moved onto it


def sphere_level(center: Sequence[float], radius: float) -> list[Level]:
    """Make the signed distance that is negative inside a sphere.

    Parameters
    ----------
    center
        Center in mm.
    radius
        Radius in mm.

    Returns
    -------
    list[Level]
        One function from points (k, 3) in mm to distances (k,) in mm.
    """
    middle = np.asarray(center, np.float64)
    return [lambda p: np.linalg.norm(p - middle, axis=1) - radius]


def box_levels(low: Sequence[float], high: Sequence[float]) -> list[Level]:
    """Make the signed distances to the six sides of a box, all negative inside.

    Parameters
    ----------
    low
        Lowest corner in mm.
    high
        Highest corner in mm.

    Returns
    -------
    list[Level]
        Six functions from points (k, 3) in mm to distances (k,) in mm.
    """

    def side(axis: int, at: float, sign: float) -> Level:
        return lambda p: sign * (p[:, axis] - at)

    return [f for k in range(3) for f in (side(k, float(low[k]), -1.0), side(k, float(high[k]), 1.0))]


def refine_smoothly(
    points: NDArray[np.float64], triangles: NDArray[np.int64], length: float
) -> tuple[NDArray[np.float64], NDArray[np.int64], float]:
    """Quarter all triangles until their edges are short enough, with the new vertices on a smooth surface.

    A new vertex is the middle of its edge on the cubic of the curved point-normal triangle (Vlachos et al. 2001); old
    vertices stay. Edges that turn 60° and more, and borders, keep straight middles.

    Parameters
    ----------
    points
        Vertices in mm, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).
    length
        Length of the edges in mm, on the average, at most.

    Returns
    -------
    tuple[NDArray[np.float64], NDArray[np.int64], float]
        Vertices, vertex indices, and how far the farthest new vertex left its edge in mm.
    """
    moved = 0.0
    while True:
        edges, inverse, counts = unique_edges(directed_edges(triangles))
        a, b = points[edges[:, 0]], points[edges[:, 1]]
        lengths = np.linalg.norm(b - a, axis=1)
        if float(np.median(lengths)) <= length or len(triangles) > 200_000:
            return points, triangles, moved
        corner = corner_normals(points, triangles)
        normals = np.zeros_like(points)
        np.add.at(normals, triangles.reshape(-1), corner.reshape(-1, 3))
        normals = directions(normals)
        na, nb = normals[edges[:, 0]], normals[edges[:, 1]]
        rise = np.einsum("ij,ij->i", b - a, na)[:, None] * na - np.einsum("ij,ij->i", b - a, nb)[:, None] * nb
        smooth = (counts == 2) & (np.einsum("ij,ij->i", na, nb) > 0.5)
        rise = np.where(smooth[:, None], -rise / 8.0, 0.0)
        moved = max(moved, float(np.linalg.norm(rise, axis=1).max()))
        n, m = len(points), len(triangles)
        points = np.concatenate([points, 0.5 * (a + b) + rise])
        m01, m12, m20 = (n + inverse[k * m : (k + 1) * m] for k in range(3))
        v0, v1, v2 = triangles.T
        triangles = np.stack(
            [
                np.stack([v0, m01, m20], 1),
                np.stack([m01, v1, m12], 1),
                np.stack([m20, m12, v2], 1),
                np.stack([m01, m12, m20], 1),
            ],
            axis=1,
        ).reshape(-1, 3)


def near(points: NDArray[np.float64], triangles: NDArray[np.int64], levels: list[Level]) -> NDArray[np.int64]:
    """Find the triangles that may reach inside: those whose bounding sphere meets the region.

    Parameters
    ----------
    points
        Vertices in mm, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).
    levels
        Signed distances, all negative inside.

    Returns
    -------
    NDArray[np.int64]
        Vertex indices of these triangles, shape (k, 3).
    """
    corners = points[triangles]
    middle = corners.mean(axis=1)
    reach = np.linalg.norm(corners - middle[:, None], axis=2).max(axis=1)
    keep = np.ones(len(triangles), bool)
    for level in levels:
        keep &= level(middle) <= 2.0 * reach
    return triangles[keep]


def crop(
    points: NDArray[np.float64], triangles: NDArray[np.int64], levels: list[Level]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Cut out the part of a surface where all levels are negative; triangles on the border are cut along it.

    Parameters
    ----------
    points
        Vertices in mm, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).
    levels
        Signed distances, all negative inside.

    Returns
    -------
    tuple[NDArray[np.float64], NDArray[np.int64]]
        Vertices in mm and vertex indices of the part.
    """
    for level in levels:
        points, triangles = _crop_one(points, triangles, level)
        if len(triangles) == 0:
            break
    used, compact = np.unique(triangles, return_inverse=True)
    return points[used], compact.reshape(-1, 3)


def _crop_one(
    points: NDArray[np.float64], triangles: NDArray[np.int64], level: Level
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    value = level(points)
    edges = unique_edges(directed_edges(triangles))[0]
    crossing = edges[(value[edges[:, 0]] < 0.0) != (value[edges[:, 1]] < 0.0)]
    at = _zero(points, crossing, level)

    # Vertices close to the border move onto it, along their nearest crossing edge.
    ends = np.concatenate([crossing[:, 0], crossing[:, 1]])
    fraction = np.concatenate([at, 1.0 - at])
    place = points[crossing[:, 0]] + (points[crossing[:, 1]] - points[crossing[:, 0]]) * at[:, None]
    place = np.concatenate([place, place])
    order = np.argsort(fraction, kind="stable")
    order = order[fraction[order] < _SNAP]
    snapped, first = np.unique(ends[order], return_index=True)
    points = points.copy()
    points[snapped] = place[order[first]]
    value = level(points)
    value[snapped] = 0.0

    inside, outside = value < 0.0, value > 0.0
    crossing = edges[(inside[edges[:, 0]] & outside[edges[:, 1]]) | (outside[edges[:, 0]] & inside[edges[:, 1]])]
    at = _zero(points, crossing, level)
    n = len(points)
    key = crossing[:, 0] * n + crossing[:, 1]
    points = np.concatenate(
        [points, points[crossing[:, 0]] + (points[crossing[:, 1]] - points[crossing[:, 0]]) * at[:, None]]
    )

    kept = []
    order = np.argsort(key, kind="stable")
    new = dict(zip(key[order].tolist(), (n + order).tolist(), strict=True))
    mixed = inside[triangles].any(axis=1) & outside[triangles].any(axis=1)
    kept.append(triangles[~mixed & inside[triangles].any(axis=1)])
    cut = []
    for triangle in triangles[mixed].tolist():
        polygon: list[int] = []
        for i in range(3):
            a, b = triangle[i], triangle[(i + 1) % 3]
            if not outside[a]:
                polygon.append(a)
            middle = new.get(min(a, b) * n + max(a, b))
            if middle is not None:
                polygon.append(middle)
        if len(polygon) == 3:
            cut.append(polygon)
        elif len(polygon) == 4:
            p = points[polygon]
            if np.linalg.norm(p[0] - p[2]) <= np.linalg.norm(p[1] - p[3]):
                cut += [[polygon[0], polygon[1], polygon[2]], [polygon[0], polygon[2], polygon[3]]]
            else:
                cut += [[polygon[1], polygon[2], polygon[3]], [polygon[1], polygon[3], polygon[0]]]
    kept.append(np.array(cut, np.int64).reshape(-1, 3))
    return points, np.concatenate(kept)


def _zero(points: NDArray[np.float64], edges: NDArray[np.int64], level: Level) -> NDArray[np.float64]:
    """Where along each edge (k, 2) the level is zero, by bisection."""
    a, b = points[edges[:, 0]], points[edges[:, 1]]
    low, high = np.zeros(len(edges)), np.ones(len(edges))
    if len(edges) == 0:
        return low
    begin = level(a) < 0.0
    for _ in range(50):
        middle = 0.5 * (low + high)
        same = (level(a + (b - a) * middle[:, None]) < 0.0) == begin
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return 0.5 * (low + high)
