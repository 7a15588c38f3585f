"""The closest point of a triangle surface to each of many points (numpy only).

The triangles lie in a tree of boxes, each of which parts them by their middles into four, across its longest side. All
points of a batch walk down the levels together, as pairs of a point and a box: first each to one triangle nearby, whose
distance bounds the answer, then to every triangle whose box is not farther. A point alone is measured to all boxes of
the lowest level instead: that takes fewer calls of numpy.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.geometry.vectors import cross, dot, triangle_corners

_LEAF = 12  # triangles in the lowest boxes, at most
_BATCH = 4096  # points at once
_MAX_PAIRS = 1 << 18  # of a point and a box at once; a batch that needs more is halved
_SLICE = 4096  # pairs of a point and a triangle measured at once
_AT_ONCE = 1 << 13  # boxes of the lowest level that one point alone is measured to, without the tree above them
_REMEMBERED = 1 << 12  # answers to one point alone: designs and checks ask for the same places again and again
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
        corners = triangle_corners(vertices, faces)
        self._corners = np.take(vertices, faces, axis=0).reshape(-1, 9)
        largest = np.maximum.reduce(np.abs(corners), axis=(0, 1))
        self._extent = float(largest.max(initial=0.0, where=np.isfinite(largest)))
        self._triangle, self._levels = _tree(corners, np.isfinite(largest))
        self._answers: dict[tuple[bytes, float], tuple[int, NDArray[np.float64], float]] = {}

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
        if len(queries) == 1 and len(self._triangle) <= _AT_ONCE:
            index[0], closest[0], distance[0] = self._remembered(queries[0], float(within))
            return index, closest, distance
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

    @cached_property
    def _lowest(self) -> NDArray[np.float64]:
        """The low and the high corners of the lowest boxes, shape (2, 3, k): numpy is slow along short axes."""
        return np.ascontiguousarray(self._levels[-1].T).reshape(2, 3, -1)

    def _remembered(self, query: NDArray[np.float64], within: float) -> tuple[int, NDArray[np.float64], float]:
        """The triangle, point (3,) and distance of one query (3,), as `query` gives them."""
        asked = (query.tobytes(), within)
        if (known := self._answers.get(asked)) is None:
            if len(self._answers) >= _REMEMBERED:
                self._answers.clear()
            known = self._answers[asked] = self._closest_of_one(query, within)
        return known

    def _closest_of_one(self, query: NDArray[np.float64], within: float) -> tuple[int, NDArray[np.float64], float]:
        nothing = (-1, np.full(3, np.nan), np.nan)
        if not np.isfinite(query).all():
            return nothing
        low, high = self._lowest
        point = query[:, None]
        outside = np.maximum(np.maximum(low - point, point - high), 0.0)
        outside *= outside
        away = outside[0] + outside[1] + outside[2]
        nearest = int(away.argmin())
        if not np.isfinite(away[nearest]):  # no triangle is
            return nothing
        # The triangle in the nearest box is not farther than that box's farthest corner.
        farthest = np.maximum(query - low[:, nearest], high[:, nearest] - query)
        coordinate = max(float(np.abs(query).max()), self._extent)
        reach = min(float(np.sqrt((farthest * farthest).sum())), within) * (1.0 + _SHARE) + _COORDINATE * coordinate
        triangle = self._triangle[np.flatnonzero(away <= reach * reach)]
        if len(triangle) == 0:
            return nothing
        squared, found = _on_triangles(np.broadcast_to(query, (len(triangle), 3)), self._corners[triangle])
        least = squared.min()
        distance = float(np.sqrt(least))
        tied = np.flatnonzero(squared == least)
        chosen = tied[triangle[tied].argmin()]
        return (int(triangle[chosen]), found[chosen].copy(), distance) if distance <= within else nothing

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

    The corners have the shape (3, 3, m): coordinate, corner, triangle. All boxes of a level have as many children;
    slots too many are empty boxes, which nothing comes near.
    """
    count = corners.shape[2]
    depth = max(0, int(np.ceil(np.log2(count / _LEAF))))
    leaf = -(-count >> depth)
    slots = leaf << depth
    triangle = np.arange(slots) * count // slots
    empty = np.diff(triangle, prepend=-1) == 0
    empty |= ~finite[triangle]
    a, b, c = corners.swapaxes(0, 1)
    order = _parted(np.nan_to_num(a + b + c, posinf=0.0, neginf=0.0)[:, triangle], depth)
    triangle, empty = triangle[order], empty[order]
    # The upper corners are negative here, so that the box of several boxes is their minimum.
    boxes = np.concatenate([np.minimum(np.minimum(a, b), c), -np.maximum(np.maximum(a, b), c)])[:, triangle]
    boxes[:, empty] = np.inf
    levels = [boxes]
    fan = leaf
    while (boxes := levels[-1]).shape[1] > 1:
        levels.append(np.minimum.reduce([boxes[:, child::fan] for child in range(fan)]))
        fan = 4 if levels[-1].shape[1] % 4 == 0 else 2
    rows = [np.concatenate([each[:3], -each[3:]]).T.copy() for each in levels]
    return triangle, rows[-2::-1] if len(rows) > 1 else rows


def _parted(points: NDArray[np.float64], depth: int) -> NDArray[np.int64]:
    """An order of points (3, k) that parts them into 2^depth groups, a divisor of k, each across its longest side.

    A part becomes four at once; the first one two, where that is left over.
    """
    order = np.arange(points.shape[1])
    parts = 1
    while parts < 1 << depth:
        fan = 2 if depth % 2 and parts == 1 else 4
        size = len(order) // parts
        starts = np.arange(0, len(order), size)
        # Over the last axis `reduceat` is many times as fast as `max`.
        sides = np.maximum.reduceat(points, starts, axis=1) - np.minimum.reduceat(points, starts, axis=1)
        across = points.reshape(3, parts, size)[sides.argmax(axis=0), np.arange(parts)]
        chosen = np.argpartition(across, np.arange(1, fan) * (size // fan), axis=1)
        moved = (chosen + starts[:, None]).ravel()
        order, points = order[moved], np.take(points, moved, axis=1)
        parts *= fan
    return order


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
    Axes here: coordinate, edge or corner, pair.
    """
    corner = np.ascontiguousarray(corners.reshape(-1, 3, 3).transpose(2, 1, 0))
    point = np.ascontiguousarray(points.T)[:, None]
    following = corner[:, [1, 2, 0]]
    edges = following - corner
    offset = point - corner
    lengths, along = dot(edges, edges), dot(offset, edges)
    t = np.clip(np.divide(along, lengths, out=np.zeros_like(along), where=lengths > 0.0), 0.0, 1.0)
    # From the nearer end, so that a corner is met exactly.
    candidates = np.where(t <= 0.5, corner + t * edges, following - (1.0 - t) * edges)
    apart = candidates - point
    squared = dot(apart, apart)
    edge, pair = squared.argmin(axis=0), np.arange(len(points))
    best, found = squared[edge, pair], candidates[:, edge, pair].T

    normal = cross(edges[:, 0], edges[:, 1])
    area = dot(normal, normal)
    above = area > 0.0
    for k in range(3):
        above &= dot(cross(edges[:, k], offset[:, k]), normal) >= 0.0
    inside = np.flatnonzero(above)
    normal, area = normal[:, inside], area[inside]
    height = dot(offset[:, 0, inside], normal) / area
    distance = height * height * area
    better = distance <= best[inside]
    target = inside[better]
    best[target] = distance[better]
    found[target] = (point[:, 0, inside] - height * normal)[:, better].T
    return best, found
