"""Counts of a triangle surface: its volume, its edges and borders, and triangles that pierce each other."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray


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
    p = points - points.mean(axis=0)
    a, b, c = (p[triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


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
    t = np.asarray(triangles, np.int64)
    corners = points[t]
    low, high = corners.min(axis=1), corners.max(axis=1)
    for left, right in _overlapping_boxes(low, high):
        shared = (t[left][:, :, None] == t[right][:, None, :]).any(axis=(1, 2))
        left, right = left[~shared], right[~shared]
        hit = _pierces(corners[left], corners[right]) | _pierces(corners[right], corners[left])
        if hit.any():
            yield np.stack([left[hit], right[hit]], axis=1)


def _overlapping_boxes(
    low: NDArray[np.float64], high: NDArray[np.float64]
) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64]]]:
    """Index arrays (left, right) of boxes (n, 3) that overlap or touch, each pair once."""
    size = max(float(np.median((high - low).max(axis=1))) * 1.5, float((high - low).max()) / 32.0, 1e-30)
    origin = low.min(axis=0)
    first = np.floor((low - origin) / size).astype(np.int64)
    last = np.floor((high - origin) / size).astype(np.int64)
    span = last - first + 1
    copies = span.prod(axis=1)
    box = np.repeat(np.arange(len(low)), copies)
    local = np.arange(len(box)) - np.repeat(np.cumsum(copies) - copies, copies)
    s = span[box]
    cell = first[box] + np.stack([local // (s[:, 1] * s[:, 2]), local // s[:, 2] % s[:, 1], local % s[:, 2]], axis=1)
    extent = last.max(axis=0) + 1
    key = (cell[:, 0] * extent[1] + cell[:, 1]) * extent[2] + cell[:, 2]
    order = np.argsort(key, kind="stable")
    key, box = key[order], box[order]
    for shift in range(1, len(key)):
        same = np.flatnonzero(key[shift:] == key[:-shift])
        if len(same) == 0:
            return
        a, b = box[same], box[same + shift]
        overlap = ((low[a] <= high[b]) & (low[b] <= high[a])).all(axis=1)
        # A common box counts in the cell that holds its lower corner only.
        corner = np.floor((np.maximum(low[a], low[b]) - origin) / size).astype(np.int64)
        here = (corner[:, 0] * extent[1] + corner[:, 1]) * extent[2] + corner[:, 2] == key[same]
        keep = overlap & here
        if keep.any():
            yield a[keep], b[keep]


def _pierces(one: NDArray[np.float64], other: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether an edge of triangle `one` (k, 3, 3) passes through triangle `other`, its border included."""
    a = other[:, 0]
    u, v = other[:, 1] - a, other[:, 2] - a
    hit = np.zeros(len(one), bool)
    for i in range(3):
        start, ray = one[:, i], one[:, (i + 1) % 3] - one[:, i]
        p = np.cross(ray, v)
        det = np.einsum("ij,ij->i", u, p)
        scale = np.linalg.norm(u, axis=1) * np.linalg.norm(v, axis=1) * np.linalg.norm(ray, axis=1)
        proper = np.abs(det) > 1e-9 * scale
        inverse = np.divide(1.0, det, out=np.zeros_like(det), where=proper)
        s = start - a
        q = np.cross(s, u)
        x = np.einsum("ij,ij->i", s, p) * inverse
        y = np.einsum("ij,ij->i", ray, q) * inverse
        at = np.einsum("ij,ij->i", v, q) * inverse
        e = 1e-9
        hit |= proper & (x > -e) & (y > -e) & (x + y < 1 + e) & (at > e) & (at < 1 - e)
    return hit
