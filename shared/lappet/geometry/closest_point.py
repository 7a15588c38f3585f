"""The closest point of a triangle surface to each of many points (numpy only).

The triangles lie in a tree of boxes that halves them by their middles, across the longest side each time; every second
halving is a level of the tree. All points of a batch walk down the levels together, as pairs of a point and a box:
first each to one triangle nearby, whose distance bounds the answer, then to every triangle whose box is not farther.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

_LEAF = 12  # triangles in the lowest boxes, at most
_BATCH = 4096  # points at once
_MAX_PAIRS = 1 << 18  # of a point and a box at once; a batch that needs more is halved
_SLICE = 4096  # pairs of a point and a triangle measured at once
# What rounding may change a distance by, as a share of it and of the largest coordinate; boxes beyond are left out.
_SHARE, _COORDINATE = 1e-9, 1e-12

Found = tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]


class ClosestPoint:
    """A search for the closest points of one surface.

    Parameters
    ----------
    surface_points
        Vertices in any length unit, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3), at least one triangle. Degenerate triangles count as the segments or points that
        they are; one with a corner that is not finite is never closest.

    Raises
    ------
    ValueError
        If the surface has no triangles, or the shapes are wrong.
    """

    def __init__(self, surface_points: ArrayLike, triangles: ArrayLike) -> None:
        vertices = np.asarray(surface_points, np.float64)
        faces = np.asarray(triangles)
        if vertices.ndim != 2 or vertices.shape[1] != 3:
            raise ValueError(f"surface points have the shape {vertices.shape}; give (n, 3).")
        if faces.ndim != 2 or faces.shape[1] != 3 or len(faces) == 0:
            raise ValueError(f"triangles have the shape {faces.shape}; give (m, 3) with at least one triangle.")
        self._corners = vertices[faces].reshape(-1, 9)
        finite = np.isfinite(self._corners).all(axis=1)
        self._extent = float(np.abs(self._corners[finite]).max(initial=0.0))
        self._triangle, self._levels = _tree(self._corners, finite)

    def query(self, points: ArrayLike, within: float = np.inf) -> Found:
        """Return the closest triangle, its closest point and the distance for each point.

        Parameters
        ----------
        points
            (q, 3).
        within
            Farther triangles do not count; a small value makes the search of points far from the surface fast.

        Returns
        -------
        tuple
            Triangle index (q,), closest point (q, 3) and distance (q,). Of triangles at exactly the same distance the
            one with the lowest index is reported. A point that is not finite, or has no triangle within reach, gets
            the triangle -1, NaN and NaN. An answer does not depend on the other points of the batch.
        """
        queries = np.asarray(points, np.float64).reshape(-1, 3)
        index = np.full(len(queries), -1, np.int64)
        closest = np.full((len(queries), 3), np.nan)
        distance = np.full(len(queries), np.nan)
        rows = np.flatnonzero(np.isfinite(queries).all(axis=1))
        waiting = [rows[start : start + _BATCH] for start in range(0, len(rows), _BATCH)]
        while waiting:
            batch = waiting.pop()
            pairs = self._within_reach(queries[batch], within)
            if pairs is None:
                waiting += [batch[: len(batch) // 2], batch[len(batch) // 2 :]]
            elif len(pairs[0]):
                near, triangle, point, squared = self._closest(queries[batch], *pairs)
                close = np.sqrt(squared) <= within
                rows = batch[near[close]]
                index[rows], closest[rows], distance[rows] = triangle[close], point[close], np.sqrt(squared[close])
        return index, closest, distance

    def _within_reach(
        self, queries: NDArray[np.float64], within: float
    ) -> tuple[NDArray[np.int64], NDArray[np.int64]] | None:
        """The pairs of a query (sorted) and a triangle that may be its closest; None where they are too many."""
        nearby = self._descend(queries)
        squared, _ = _on_triangles(queries, self._corners[nearby])
        coordinate = np.maximum(np.abs(queries).max(axis=1), self._extent)
        reach = np.minimum(np.sqrt(squared), within) * (1.0 + _SHARE) + _COORDINATE * coordinate
        reach *= reach
        row, node = np.arange(len(queries)), np.zeros(len(queries), np.int64)
        width = 1
        for boxes in self._levels:
            fan = len(boxes) // width
            width = len(boxes)
            if len(row) * fan > _MAX_PAIRS and len(queries) > 1:
                return None
            row, node = np.repeat(row, fan), (node[:, None] * fan + np.arange(fan)).ravel()
            kept = np.flatnonzero(_to_boxes(queries[row], boxes[node]) <= reach[row])
            row, node = row[kept], node[kept]
        return row, self._triangle[node]

    def _descend(self, queries: NDArray[np.float64]) -> NDArray[np.int64]:
        """A triangle near each query (q,): that of the nearest box of each level in turn."""
        node = np.zeros(len(queries), np.int64)
        width = 1
        for boxes in self._levels:
            fan = len(boxes) // width
            width = len(boxes)
            children = node[:, None] * fan + np.arange(fan)
            away = _to_boxes(np.repeat(queries, fan, axis=0), boxes[children.ravel()])
            node = node * fan + away.reshape(-1, fan).argmin(axis=1)
        return self._triangle[node]

    def _closest(
        self, queries: NDArray[np.float64], row: NDArray[np.int64], triangle: NDArray[np.int64]
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
        """The queries (k,) that occur in pairs and, for each, its triangle, point (k, 3) and squared distance."""
        squared, found = np.empty(len(row)), np.empty((len(row), 3))
        for start in range(0, len(row), _SLICE):
            part = slice(start, start + _SLICE)
            squared[part], found[part] = _on_triangles(queries[row[part]], self._corners[triangle[part]])
        starts = np.flatnonzero(np.diff(row, prepend=-1))
        counts = np.diff(starts, append=len(row))
        least = np.minimum.reduceat(squared, starts)
        tied = np.where(squared == np.repeat(least, counts), triangle, len(self._corners))
        first = np.minimum.reduceat(tied, starts)
        chosen = np.flatnonzero(tied == np.repeat(first, counts))
        return row[starts], first, found[chosen], least


def closest_points(points: ArrayLike, surface_points: ArrayLike, triangles: ArrayLike) -> Found:
    """Find the closest point of a triangle surface to each of some points; keep a `ClosestPoint` for many calls.

    Parameters
    ----------
    points
        Points, shape (q, 3).
    surface_points
        Vertices in the same unit, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).

    Returns
    -------
    Found
        Triangle index, shape (q,), closest point, shape (q, 3), and distance, shape (q,), as `ClosestPoint.query` gives
        them.

    Raises
    ------
    ValueError
        If the surface has no triangles, or the shapes are wrong.
    """
    return ClosestPoint(surface_points, triangles).query(points)


def _tree(
    corners: NDArray[np.float64], finite: NDArray[np.bool_]
) -> tuple[NDArray[np.int64], list[NDArray[np.float64]]]:
    """The triangle in each slot of the lowest level, and the boxes of the levels, low and high corner (k, 6).

    All boxes of a level have as many children; slots too many are empty boxes, which nothing comes near.
    """
    depth = max(0, int(np.ceil(np.log2(len(corners) / _LEAF))))
    leaf = -(-len(corners) >> depth) if depth else len(corners)
    slots = leaf << depth
    triangle = np.arange(slots) * len(corners) // slots
    empty = np.diff(triangle, prepend=-1) == 0
    empty |= ~finite[triangle]
    coordinates = corners.reshape(-1, 3, 3)
    order = _halved(np.nan_to_num(coordinates.sum(axis=1), posinf=0.0, neginf=0.0)[triangle], depth)
    triangle, empty = triangle[order], empty[order]
    boxes = np.concatenate([_least(coordinates), -_least(-coordinates)], axis=1)[triangle]
    boxes[empty, :3], boxes[empty, 3:] = np.inf, -np.inf
    levels = [boxes]
    fan = leaf
    while len(boxes) > 1:
        groups = boxes.reshape(-1, fan, 6)
        boxes = np.concatenate([_least(groups[:, :, :3]), -_least(-groups[:, :, 3:])], axis=1)
        levels.append(boxes)
        fan = 4 if len(boxes) % 4 == 0 else 2
    return triangle, levels[-2::-1] if len(levels) > 1 else levels


def _halved(points: NDArray[np.float64], depth: int) -> NDArray[np.int64]:
    """An order of points (k, 3), k a multiple of 2^depth: halved so often, each part across its longest side."""
    order, placed = np.arange(len(points)), np.ascontiguousarray(points.T)
    for level in range(depth):
        parts = 1 << level
        size = len(points) // parts
        rows = placed.reshape(3, parts, size)
        axis = (rows.max(axis=2) - rows.min(axis=2)).argmax(axis=0)
        parted = np.argpartition(rows[axis, np.arange(parts)], size // 2, axis=1)
        moved = (parted + np.arange(0, len(points), size)[:, None]).ravel()
        order, placed = order[moved], np.take(placed, moved, axis=1)
    return order


def _least(groups: NDArray[np.float64]) -> NDArray[np.float64]:
    """The minimum over the second axis, which is short: (k, n, 3) to (k, 3)."""
    least = groups[:, 0].copy()
    for each in range(1, groups.shape[1]):
        np.minimum(least, groups[:, each], out=least)
    return least


def _to_boxes(points: NDArray[np.float64], boxes: NDArray[np.float64]) -> NDArray[np.float64]:
    """The squared distance (k,) of each point (k, 3) to its box (k, 6); 0 inside."""
    outside = np.maximum(np.maximum(boxes[:, :3] - points, points - boxes[:, 3:]), 0.0)
    outside *= outside
    return np.asarray(outside[:, 0] + outside[:, 1] + outside[:, 2])


def _on_triangles(
    points: NDArray[np.float64], corners: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The squared distance (k,) of each point (k, 3) to its triangle (k, 9), and the closest point (k, 3) on that.

    The candidates are the closest points of the three edges and, where the projection falls inside, the projection
    (Ericson, Real-Time Collision Detection, 5.1.5, written without its region tests so that degenerate triangles work).
    Axes here: edge or corner, coordinate, pair.
    """
    corner = np.ascontiguousarray(corners.T).reshape(3, 3, -1)
    point = np.ascontiguousarray(points.T)
    following = corner[[1, 2, 0]]
    edges = following - corner
    offset = point - corner
    lengths, along = _dot(edges, edges), _dot(offset, edges)
    t = np.clip(np.divide(along, lengths, out=np.zeros_like(along), where=lengths > 0.0), 0.0, 1.0)[:, None]
    # From the nearer end, so that a corner is met exactly.
    candidates = np.where(t <= 0.5, corner + t * edges, following - (1.0 - t) * edges)
    apart = candidates - point
    squared = _dot(apart, apart)
    edge, pair = squared.argmin(axis=0), np.arange(len(points))
    best, found = squared[edge, pair], candidates[edge, :, pair]

    normal = _cross(edges[0], edges[1])
    area = _dot(normal, normal)
    above = area > 0.0
    for k in range(3):
        above &= _dot(_cross(edges[k], offset[k]), normal) >= 0.0
    inside = np.flatnonzero(above)
    normal, area = normal[:, inside], area[inside]
    height = _dot(offset[0][:, inside], normal) / area
    distance = height * height * area
    better = distance <= best[inside]
    target = inside[better]
    best[target] = distance[better]
    found[target] = (point[:, inside] - height * normal)[:, better].T
    return best, found


def _dot(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Dot products along the last axis but one."""
    product = a * b
    # `np.einsum` adds in this order too; written out, the result does not depend on shapes and strides.
    return np.asarray((product[..., 0, :] + product[..., 2, :]) + product[..., 1, :])


def _cross(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """The cross products (3, k) of vectors (3, k)."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
