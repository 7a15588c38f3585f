"""Counts of a triangle surface: its volume, its edges and borders, and triangles that pierce each other."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.connected_labels import connected_labels
from lappet.geometry.vectors import cross, dot, length, triangle_corners


def place(point: NDArray[np.float64]) -> str:
    """Write a point as people read it: (1.25, 0, -3).

    Parameters
    ----------
    point
        A point in mm, shape (3,).

    Returns
    -------
    str
        The text.
    """
    return "(" + ", ".join(f"{float(c):.6g}" for c in point) + ")"


def signed_volume(points: NDArray[np.float64], triangles: NDArray[np.integer]) -> float:
    """Compute the volume that a closed surface encloses.

    Parameters
    ----------
    points
        Vertices in mm, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).

    Returns
    -------
    float
        Volume in mm³, negative where the surface is turned inside out.
    """
    a, b, c = triangle_corners(points - points.mean(axis=0), triangles).swapaxes(0, 1)
    return float(dot(a, cross(b, c)).sum() / 6.0)


def directed_edges(triangles: NDArray[np.integer]) -> NDArray[np.int64]:
    """List the three directed edges of each triangle.

    Parameters
    ----------
    triangles
        Vertex indices, shape (m, 3).

    Returns
    -------
    NDArray[np.int64]
        Vertex pairs, shape (3m, 2).
    """
    t = np.asarray(triangles, np.int64)
    return np.vstack([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]])


def open_edges(triangles: NDArray[np.integer]) -> NDArray[np.int64]:
    """Find the directed edges that belong to one triangle only.

    Parameters
    ----------
    triangles
        Vertex indices, shape (m, 3).

    Returns
    -------
    NDArray[np.int64]
        Vertex pairs, shape (k, 2).
    """
    edges = directed_edges(triangles)
    _, inverse, counts = unique_edges(edges)
    return edges[counts[inverse] == 1]


def unpaired_edges(triangles: NDArray[np.integer]) -> NDArray[np.int64]:
    """Find the edges that do not join exactly two triangles of one orientation: of holes, or of parts that touch.

    Parameters
    ----------
    triangles
        Vertex indices, shape (m, 3).

    Returns
    -------
    NDArray[np.int64]
        Vertex pairs, each once in either direction in which it is found, shape (k, 2); none for a watertight surface.
    """
    edges = directed_edges(triangles)
    count = int(edges.max(initial=0)) + 1
    ahead, back = (np.unique(each, return_counts=True) for each in (edges @ (count, 1), edges @ (1, count)))
    loose = ahead[0][~(np.isin(ahead[0], back[0][back[1] == 1]) & (ahead[1] == 1))]
    return np.stack([loose // count, loose % count], axis=1)


def pinched_vertices(triangles: NDArray[np.integer]) -> NDArray[np.int64]:
    """Find the vertices at which parts of a surface touch: their triangles make several fans.

    Parameters
    ----------
    triangles
        Vertex indices, shape (m, 3).

    Returns
    -------
    NDArray[np.int64]
        Vertices, shape (k,); the ends of an edge of four triangles are among them.
    """
    ahead = np.asarray(triangles, np.int64)
    start, end = ahead.ravel(), np.roll(ahead, -1, axis=1).ravel()
    count = int(start.max(initial=0)) + 1
    keys, first, times = np.unique(start * count + end, return_index=True, return_counts=True)
    row = np.minimum(np.searchsorted(keys, end * count + start), len(keys) - 1)
    alone = times[np.searchsorted(keys, start * count + end)] == 1
    joined = alone & (keys[row] == end * count + start) & (times[row] == 1)
    # Across the edge from a corner to the next one lies a triangle in which the edge ends at the same vertex.
    across = first[row[joined]]
    corner = across - across % 3 + (across + 1) % 3
    fan = connected_labels(len(start), np.stack([np.flatnonzero(joined), corner], axis=1))
    vertices, fans = np.unique(np.unique(np.stack([start, fan], axis=1), axis=0)[:, 0], return_counts=True)
    return vertices[fans > 1]


def unique_edges(edges: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Sort directed edges into undirected ones.

    Parameters
    ----------
    edges
        Vertex pairs, shape (k, 2).

    Returns
    -------
    tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]
        The undirected edges, smaller index first, shape (u, 2); which of them each edge is, shape (k,); and how often
        each occurs, shape (u,).
    """
    low, high = np.minimum(edges[:, 0], edges[:, 1]), np.maximum(edges[:, 0], edges[:, 1])
    size = int(high.max()) + 1 if len(edges) else 1
    key, inverse, counts = np.unique(low * size + high, return_inverse=True, return_counts=True)
    return np.stack([key // size, key % size], axis=1), inverse.reshape(-1), counts


def first_intersection(points: NDArray[np.float64], triangles: NDArray[np.integer]) -> tuple[int, int] | None:
    """Find a pair of triangles without a common vertex that pierce each other.

    Parameters
    ----------
    points
        Vertices in mm, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).

    Returns
    -------
    tuple[int, int] | None
        Indices of the two triangles, or None; see `intersections`.
    """
    for pairs in intersections(points, triangles):
        return int(pairs[0].min()), int(pairs[0].max())
    return None


def intersections(points: NDArray[np.float64], triangles: NDArray[np.integer]) -> Iterator[NDArray[np.int64]]:
    """Find the pairs of triangles without a common vertex that pierce each other, some at a time.

    Candidate pairs share a cell of a grid; a pair intersects when an edge of one crosses the inside of the other
    (Möller and Trumbore 1997). A corner that only touches the other triangle does not count.

    Parameters
    ----------
    points
        Vertices in mm, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).

    Yields
    ------
    NDArray[np.int64]
        Pairs of triangle indices, shape (k, 2).
    """
    t = np.ascontiguousarray(np.transpose(triangles))
    corners = triangle_corners(points, t.T)
    for left, right in _overlapping_boxes(corners.min(axis=1), corners.max(axis=1)):
        apart = (t[:, None, left] != t[None, :, right]).all(axis=(0, 1))
        left, right = left[apart], right[apart]
        one, other = corners[:, :, left], corners[:, :, right]
        hit = _pierces(one, other) | _pierces(other, one)
        if hit.any():
            yield np.stack([left[hit], right[hit]], axis=1)


def piercings(
    points: NDArray[np.float64], triangles: NDArray[np.integer], chosen: NDArray[np.bool_]
) -> NDArray[np.int64]:
    """Find the pairs of triangles of which an edge of one passes through the other, for a few triangles.

    Unlike `intersections` this finds those with a common corner, too, where the edge across from it passes through.

    Parameters
    ----------
    points
        Vertices in mm, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).
    chosen
        Triangles of which each pair has one at least, shape (m,).

    Returns
    -------
    NDArray[np.int64]
        Pairs of triangle indices, each once in either order or in both, shape (k, 2).
    """
    corners = triangle_corners(points, triangles)
    left, right = _beside_chosen(corners.min(axis=1), corners.max(axis=1), chosen)
    one, other = corners[:, :, left], corners[:, :, right]
    common = triangles[left].T[:, None] == triangles[right].T[None]
    hit = _pierces(one, other, ~common.any(axis=1)) | _pierces(other, one, ~common.any(axis=0))
    return np.stack([left[hit], right[hit]], axis=1)


def _beside_chosen(
    low: NDArray[np.float64], high: NDArray[np.float64], chosen: NDArray[np.bool_]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Index arrays (left, right) of boxes (3, n) that overlap or touch, the left one of which is chosen."""
    box, key, _ = _cells_of_boxes(low, high)
    order = np.argsort(key, kind="stable")
    box, key = box[order], key[order]
    asking = np.flatnonzero(chosen[box])
    first, last = np.searchsorted(key, key[asking], "left"), np.searchsorted(key, key[asking], "right")
    count = last - first
    other = np.arange(int(count.sum())) - np.repeat(np.cumsum(count) - count - first, count)
    left, right = np.repeat(box[asking], count), box[other]
    beside = (
        (left != right) & (low[:, left] <= high[:, right]).all(axis=0) & (low[:, right] <= high[:, left]).all(axis=0)
    )
    pairs = np.unique(left[beside] * low.shape[1] + right[beside])
    return pairs // low.shape[1], pairs % low.shape[1]


def _cells_of_boxes(
    low: NDArray[np.float64], high: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.int64], Callable[[NDArray[np.float64]], NDArray[np.int64]]]:
    """Pairs of a box (3, n) and a cell of a grid that it lies in, by their numbers, and the cells of points (3, k)."""
    sides = (high - low).max(axis=0)
    size = max(float(np.median(sides)) * 1.5, float(sides.max()) / 32.0, 1e-30)
    origin = low.min(axis=1, keepdims=True)
    first, last = np.floor((low - origin) / size).astype(np.int64), np.floor((high - origin) / size).astype(np.int64)
    span = last - first + 1
    copies = span.prod(axis=0)
    box = np.repeat(np.arange(low.shape[1]), copies)
    local = np.arange(len(box)) - np.repeat(np.cumsum(copies) - copies, copies)
    _, wide, tall = span[:, box]
    cell = first[:, box] + np.stack([local // (wide * tall), local // tall % wide, local % tall])
    extent = last.max(axis=1) + 1

    def number(cells: NDArray[np.int64]) -> NDArray[np.int64]:
        return np.asarray((cells[0] * extent[1] + cells[1]) * extent[2] + cells[2])

    return box, number(cell), lambda places: number(np.floor((places - origin) / size).astype(np.int64))


def _overlapping_boxes(
    low: NDArray[np.float64], high: NDArray[np.float64]
) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64]]]:
    """Index arrays (left, right) of boxes (3, n) that overlap or touch, each pair once."""
    box, key, cells_of = _cells_of_boxes(low, high)
    order = np.argsort(key, kind="stable")
    key, box = key[order], box[order]
    for shift in range(1, len(key)):
        same = np.flatnonzero(key[shift:] == key[:-shift])
        if len(same) == 0:
            return
        a, b = box[same], box[same + shift]
        from_corner, to_corner = np.maximum(low[:, a], low[:, b]), np.minimum(high[:, a], high[:, b])
        # A common box counts in the cell that holds its lower corner only.
        keep = (from_corner <= to_corner).all(axis=0) & (cells_of(from_corner) == key[same])
        if keep.any():
            yield a[keep], b[keep]


def _pierces(
    one: NDArray[np.float64], other: NDArray[np.float64], free: NDArray[np.bool_] | None = None
) -> NDArray[np.bool_]:
    """Whether an edge of triangle `one` passes through triangle `other`, its border included.

    Both have the shape (3, 3, k): coordinate, corner, triangle. With `free`, the corners (3, k) of `one` that are none
    of `other`'s, only edges between such corners count.
    """
    a = other[:, 0]
    u, v = other[:, 1] - a, other[:, 2] - a
    area = length(u) * length(v)
    hit = np.zeros(one.shape[2], bool)
    for i in range(3):
        start = one[:, i]
        ray = one[:, (i + 1) % 3] - start
        p = cross(ray, v)
        det = dot(u, p)
        proper = np.abs(det) > 1e-9 * (area * length(ray))
        inverse = np.divide(1.0, det, out=np.zeros_like(det), where=proper)
        s = start - a
        q = cross(s, u)
        x, y, at = dot(s, p) * inverse, dot(ray, q) * inverse, dot(v, q) * inverse
        e = 1e-9
        if free is not None:
            proper &= free[i] & free[(i + 1) % 3]
        hit |= proper & (x > -e) & (y > -e) & (x + y < 1 + e) & (at > e) & (at < 1 - e)
    return hit
