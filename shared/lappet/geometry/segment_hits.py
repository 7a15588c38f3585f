"""Where segments first meet the triangles of a surface: rays of a limited length, in any direction."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.vectors import cross, dot, triangle_corners

_PAIRS = 1 << 20  # of a segment and a triangle at once
_CELLS = 64  # of the grid along the longest triangle, at most


class Hits(NamedTuple):
    """The first triangle that each of q segments meets.

    Parameters
    ----------
    triangle
        Its index, shape (q,); -1 where a segment meets none.
    fraction
        Where on the segment, from 0 at its start to 1 at its end, shape (q,); infinite where it meets none.
    """

    triangle: NDArray[np.int64]
    fraction: NDArray[np.float64]


def first_hits(
    starts: NDArray[np.float64], ends: NDArray[np.float64], points: NDArray[np.float64], triangles: NDArray[np.integer]
) -> Hits:
    """Find the first triangle that each segment meets (Möller and Trumbore 1997), from either side.

    A segment that begins on a triangle meets it; begin a little off to leave it out.

    Parameters
    ----------
    starts, ends
        Ends of the segments, shape (q, 3).
    points
        Vertices of the surface in the same unit, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).

    Returns
    -------
    Hits
        What was found.
    """
    count = len(starts)
    hits = Hits(np.full(count, -1, np.int64), np.full(count, np.inf))
    if count == 0 or len(triangles) == 0:
        return hits
    corners = triangle_corners(points, triangles)
    low, high = corners.min(axis=1), corners.max(axis=1)
    sides = (high - low).max(axis=0)
    size = max(float(np.median(sides)) * 1.5, float(sides.max()) / _CELLS, 1e-30)
    origin = low.min(axis=1, keepdims=True)
    extent = np.floor((high.max(axis=1, keepdims=True) - origin) / size).astype(np.int64) + 1
    triangle, cell = _cells((low - origin) / size, (high - origin) / size, extent)
    order = np.argsort(cell, kind="stable")
    triangle, cell = triangle[order], cell[order]

    segment, piece_low, piece_high = _pieces(starts.T, ends.T, size)
    piece, asked = _cells((piece_low - origin) / size, (piece_high - origin) / size, extent)
    pairs = np.unique(segment[piece] * int(extent.prod()) + asked)
    segment, asked = np.divmod(pairs, int(extent.prod()))
    first = np.asarray(np.searchsorted(cell, asked, side="left"))
    number: NDArray[np.int64] = np.asarray(np.searchsorted(cell, asked, side="right")) - first
    total: NDArray[np.int64] = np.cumsum(number)
    begin = 0
    while begin < len(segment):
        done = int(total[begin - 1]) if begin else 0
        end = max(begin + 1, int(np.searchsorted(total, done + _PAIRS, side="right")))
        local = np.arange(int(total[end - 1]) - done) - np.repeat(
            total[begin:end] - number[begin:end] - done, number[begin:end]
        )
        _meet(
            hits,
            (starts.T, ends.T, corners),
            np.repeat(segment[begin:end], number[begin:end]),
            triangle[np.repeat(first[begin:end], number[begin:end]) + local],
        )
        begin = end
    return hits


def _pieces(
    starts: NDArray[np.float64], ends: NDArray[np.float64], size: float
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """Segments (3, q) in pieces of at most `size`: the segment of each, and its box, two of (3, k)."""
    parts = np.maximum(np.ceil(np.abs(ends - starts).max(axis=0) / size), 1.0).astype(np.int64)
    segment = np.repeat(np.arange(len(parts)), parts)
    rank = np.arange(len(segment)) - np.repeat(np.cumsum(parts) - parts, parts)
    one = starts[:, segment] + (ends - starts)[:, segment] * (rank / parts[segment])
    two = starts[:, segment] + (ends - starts)[:, segment] * ((rank + 1) / parts[segment])
    return segment, np.minimum(one, two), np.maximum(one, two)


def _cells(
    low: NDArray[np.float64], high: NDArray[np.float64], extent: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Which box lies in which cell of a grid with unit cells, as pairs; boxes (3, k) are clipped to the grid."""
    first = np.maximum(np.floor(low).astype(np.int64), 0)
    last = np.minimum(np.floor(high).astype(np.int64), extent - 1)
    span = np.maximum(last - first + 1, 0)
    copies = span.prod(axis=0)
    box = np.repeat(np.arange(low.shape[1]), copies)
    local = np.arange(len(box)) - np.repeat(np.cumsum(copies) - copies, copies)
    _, wide, tall = span[:, box]
    x, y, z = first[:, box] + np.stack([local // (wide * tall), local // tall % wide, local % tall])
    return box, (x * extent[1] + y) * extent[2] + z


def _meet(
    hits: Hits,
    surface: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]],
    segment: NDArray[np.int64],
    triangle: NDArray[np.int64],
) -> None:
    """Enter into the hits where pairs of a segment and a triangle meet nearer than known."""
    starts, ends, corners = surface
    start = starts[:, segment]
    along = ends[:, segment] - start
    a, b, c = (corners[:, k, triangle] for k in range(3))
    u, v = b - a, c - a
    p = cross(along, v)
    determinant = dot(u, p)
    proper = np.abs(determinant) > 1e-300
    inverse = np.divide(1.0, determinant, out=np.zeros_like(determinant), where=proper)
    s = start - a
    q = cross(s, u)
    x, y, at = dot(s, p) * inverse, dot(along, q) * inverse, dot(v, q) * inverse
    edge = -1e-9
    met = np.flatnonzero(proper & (x > edge) & (y > edge) & (x + y < 1.0 - edge) & (at >= 0.0) & (at <= 1.0))
    met = met[np.lexsort((triangle[met], at[met], segment[met]))]
    which, first = np.unique(segment[met], return_index=True)
    nearer = at[met[first]] < hits.fraction[which]
    hits.fraction[which[nearer]] = at[met[first[nearer]]]
    hits.triangle[which[nearer]] = triangle[met[first[nearer]]]
