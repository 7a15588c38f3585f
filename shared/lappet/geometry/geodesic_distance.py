"""Distances along a triangle surface from one point of it.

Fronts run over the triangles: from the distances of two corners the source is laid out in the third one's plane, and
the straight line from it is taken where that passes between the two (the unfolding of Chen and Han 1990, with one
source for each edge as in fast marching); else the way along an edge. Exact in a plane; on curved skin with 15 edges
to the radius within 1 % (tests/geometry/test_geodesic_distance.py).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.closest_point import closest_points

_ROUNDS = 10_000


def geodesic_distance(
    points: NDArray[np.float64], triangles: NDArray[np.int64], source: NDArray[np.float64], reach: float = np.inf
) -> NDArray[np.float64]:
    """Measure how far the vertices of a surface lie from a point, along the surface.

    Parameters
    ----------
    points
        Vertices in any length unit, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).
    source
        A point, shape (3,); the surface's closest point to it counts.
    reach
        Distance beyond which nothing is looked for.

    Returns
    -------
    NDArray[np.float64]
        Distances, shape (n,); infinite beyond the reach and for vertices that the surface does not connect.
    """
    triangle, closest, _ = closest_points(source[None], points, triangles)
    distance = np.full(len(points), np.inf)
    start = triangles[triangle[0]]
    distance[start] = np.linalg.norm(points[start] - closest[0], axis=1)
    # Each corner with the edge across from it, laid out in a plane: the edge along x from 0, the corner above it.
    corner = triangles.reshape(-1)
    one, two = np.roll(triangles, -1, axis=1).reshape(-1), np.roll(triangles, -2, axis=1).reshape(-1)
    base, side = points[two] - points[one], points[corner] - points[one]
    length = np.maximum(np.linalg.norm(base, axis=1), 1e-300)
    x = np.einsum("ij,ij->i", base, side) / length
    y = np.sqrt(np.maximum(np.einsum("ij,ij->i", side, side) - x * x, 0.0))
    from_one, from_two = np.hypot(x, y), np.hypot(x - length, y)
    active = np.ones(len(corner), bool)
    for _ in range(_ROUNDS):
        rows = np.flatnonzero(active & np.isfinite(distance[one] + distance[two]))
        a, b = distance[one[rows]], distance[two[rows]]
        found = np.minimum(a + from_one[rows], b + from_two[rows])
        straight = _straight(a, b, length[rows], x[rows], y[rows])
        found = np.where(np.isfinite(straight), straight, found)
        before = distance.copy()
        close = found <= reach
        np.minimum.at(distance, corner[rows[close]], found[close])
        changed = distance < before * (1.0 - 1e-12)
        if not changed.any():
            break
        active = changed[one] | changed[two]
    return distance


def _straight(
    a: NDArray[np.float64],
    b: NDArray[np.float64],
    length: NDArray[np.float64],
    x: NDArray[np.float64],
    y: NDArray[np.float64],
) -> NDArray[np.float64]:
    """The distance of (x, y) from a source below the x axis that lies `a` from 0 and `b` from `length`.

    Infinite where there is no such source, or its straight line misses the edge between the two.
    """
    along = (a * a - b * b + length * length) / (2.0 * length)
    squared = a * a - along * along
    below = np.sqrt(np.maximum(squared, 0.0))
    height = y + below
    meets = along + (x - along) * np.divide(below, height, out=np.zeros_like(below), where=height > 0.0)
    valid = (squared >= -1e-12 * a * a) & (height > 0.0) & (meets >= -1e-9 * length) & (meets <= (1.0 + 1e-9) * length)
    return np.where(valid, np.hypot(x - along, height), np.inf)
