"""The closest point of a triangle surface to each of some points (numpy only).

Triangles are sorted along a Morton curve into blocks with bounding boxes; a query first measures the block
whose box is nearest, then only those blocks whose boxes are nearer than what it found.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

_BLOCK = 64


class ClosestPoint:
    """Answers closest-point queries against one surface.

    surface_points: (n, 3), any length unit. triangles: (m, 3) integer, m >= 1; degenerate triangles count as the
    segments or points that they are. Raises ValueError for a surface without triangles or with wrong shapes.
    """

    def __init__(self, surface_points: ArrayLike, triangles: ArrayLike) -> None:
        vertices = np.asarray(surface_points, np.float64)
        faces = np.asarray(triangles)
        if vertices.ndim != 2 or vertices.shape[1] != 3:
            raise ValueError(f"surface points have the shape {vertices.shape}; give (n, 3).")
        if faces.ndim != 2 or faces.shape[1] != 3 or len(faces) == 0:
            raise ValueError(f"triangles have the shape {faces.shape}; give (m, 3) with at least one triangle.")
        corners = vertices[faces]
        order = np.argsort(_morton(corners.mean(axis=1)), kind="stable")
        self._order = order
        self._corners = np.ascontiguousarray(corners[order])
        starts = np.arange(0, len(order), _BLOCK)
        self._starts = starts
        self._stops = np.minimum(starts + _BLOCK, len(order))
        self._low = np.minimum.reduceat(self._corners.min(axis=1), starts, axis=0)
        self._high = np.maximum.reduceat(self._corners.max(axis=1), starts, axis=0)

    def query(self, points: ArrayLike) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
        """The triangle index (q,), closest point (q, 3) and distance (q,) for points (q, 3).

        Among triangles at exactly the same distance the one with the lowest index is reported. A point that is
        not finite gets the triangle -1 and the distance NaN.
        """
        queries = np.asarray(points, np.float64).reshape(-1, 3)
        index = np.full(len(queries), -1, np.int64)
        closest = np.full((len(queries), 3), np.nan)
        squared = np.full(len(queries), np.nan)
        for i, query in enumerate(queries):
            if np.isfinite(query).all():
                index[i], closest[i], squared[i] = self._one(query)
        return index, closest, np.sqrt(squared)

    def _one(self, query: NDArray[np.float64]) -> tuple[int, NDArray[np.float64], float]:
        outside = np.maximum(np.maximum(self._low - query, query - self._high), 0.0)
        bound = np.einsum("ij,ij->i", outside, outside)
        nearest = int(bound.argmin())
        rows = np.arange(self._starts[nearest], self._stops[nearest])
        found, squared = _on_triangles(query, self._corners[rows])
        blocks = np.flatnonzero(bound <= squared.min())
        if len(blocks) > 1:
            rows = np.concatenate([np.arange(self._starts[b], self._stops[b]) for b in blocks])
            found, squared = _on_triangles(query, self._corners[rows])
        ties = np.flatnonzero(squared == squared.min())
        best = ties[self._order[rows[ties]].argmin()]
        return int(self._order[rows[best]]), found[best], float(squared[best])


def closest_points(
    points: ArrayLike, surface_points: ArrayLike, triangles: ArrayLike
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """The closest point of a triangle surface to each point: (triangle index, point, distance).

    points: (q, 3). surface_points: (n, 3). triangles: (m, 3). Returns (q,), (q, 3) and (q,), in the unit of the
    input; see `ClosestPoint` for ties, degenerate triangles and errors. Keep a `ClosestPoint` for many calls
    against one surface.
    """
    return ClosestPoint(surface_points, triangles).query(points)


def _on_triangles(
    query: NDArray[np.float64], corners: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The closest point on each triangle (k, 3, 3) to one point, and its squared distance (k,).

    The candidates are the closest points of the three edges and, where the projection falls inside, the projection
    (Ericson, Real-Time Collision Detection, 5.1.5, written without its region tests so that degenerate triangles work).
    """
    following = corners[:, [1, 2, 0]]
    edges = following - corners
    lengths = np.einsum("ijk,ijk->ij", edges, edges)
    along = np.einsum("ijk,ijk->ij", query - corners, edges)
    t = np.clip(np.divide(along, lengths, out=np.zeros_like(along), where=lengths > 0.0), 0.0, 1.0)[:, :, None]
    # From the nearer end, so that a corner is met exactly.
    candidates = np.where(t <= 0.5, corners + t * edges, following - (1.0 - t) * edges)
    offsets = candidates - query
    squared = np.einsum("ijk,ijk->ij", offsets, offsets)
    edge = squared.argmin(axis=1)
    rows = np.arange(len(corners))
    found, best = candidates[rows, edge], squared[rows, edge]

    normals = _cross(edges[:, 0], edges[:, 1])
    area = np.einsum("ij,ij->i", normals, normals)
    sides = np.einsum("ijk,ijk->ij", _cross(edges, query - corners), normals[:, None, :])
    inside = (area > 0.0) & (sides >= 0.0).all(axis=1)
    if inside.any():
        height = np.einsum("ij,ij->i", query - corners[inside, 0], normals[inside]) / area[inside]
        projected = query - height[:, None] * normals[inside]
        distance = height * height * area[inside]
        better = distance <= best[inside]
        target = np.flatnonzero(inside)[better]
        found[target], best[target] = projected[better], distance[better]
    return found, best


def _cross(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """The cross products along the last axis; `np.cross` spends most of its time on where that axis is."""
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)


def _morton(points: NDArray[np.float64]) -> NDArray[np.uint64]:
    """A 3 x 16 bit Morton code of each point (n, 3) within their bounding box."""
    with np.errstate(invalid="ignore"):
        low = points.min(axis=0)
        extent = float((points.max(axis=0) - low).max())
        scaled = (points - low) * (65535.0 / extent if extent > 0.0 else 0.0)
    cells = np.nan_to_num(scaled, nan=0.0, posinf=0.0, neginf=0.0).astype(np.uint64)
    code = np.zeros(len(points), np.uint64)
    for bit in range(16):
        for axis in range(3):
            code |= ((cells[:, axis] >> np.uint64(bit)) & np.uint64(1)) << np.uint64(3 * bit + axis)
    return code
