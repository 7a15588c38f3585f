"""Draw triangles into a picture without a graphics card: nearest surface, and where on it, for each pixel."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.vectors import dot

_SAMPLES = 1 << 21  # pairs of a triangle and a pixel at once


class Raster(NamedTuple):
    """What each pixel of a picture shows.

    Parameters
    ----------
    triangle
        Index of the nearest triangle, shape (height, width); -1 where there is none.
    weights
        Barycentric weights of the point on it, shape (height, width, 3).
    """

    triangle: NDArray[np.int64]
    weights: NDArray[np.float64]


def rasterize(corners: NDArray[np.float64], size: tuple[int, int]) -> Raster:
    """Find the nearest triangle for each pixel.

    Parameters
    ----------
    corners
        Triangles in pixels, x to the right, y downwards, and their distance from the eye, shape (m, 3, 3).
    size
        Width and height of the picture in pixels.

    Returns
    -------
    Raster
        What was found; a pixel is asked at its middle.
    """
    width, height = size
    nearest = np.full(width * height, np.inf)
    which = np.full(width * height, -1, np.int64)
    weight = np.zeros((width * height, 3))
    flat = corners[:, :, :2]
    low = np.maximum(np.ceil(flat.min(axis=1) - 0.5).astype(np.int64), 0)
    high = np.minimum(np.floor(flat.max(axis=1) - 0.5).astype(np.int64), np.array([width, height]) - 1)
    span = np.maximum(high - low + 1, 0)
    count = span.prod(axis=1)
    total = np.cumsum(count)
    columns = np.ascontiguousarray(corners.transpose(1, 2, 0))  # corner, coordinate, triangle
    begin = 0
    while begin < len(count):
        done = int(total[begin - 1]) if begin else 0
        end = max(begin + 1, int(np.searchsorted(total, done + _SAMPLES, side="right")))
        part, pairs = slice(begin, end), count[begin:end]
        local = np.arange(int(pairs.sum())) - np.repeat(total[part] - pairs - done, pairs)
        down, along = np.divmod(local, np.repeat(np.maximum(span[part, 0], 1), pairs))
        x, y = (np.repeat(low[part, axis], pairs) + each for axis, each in enumerate((along, down)))
        inside, weights = _weights(columns[:, :2, part], pairs, x + 0.5, y + 0.5)
        triangle, pixel = np.repeat(np.arange(begin, end), pairs)[inside], (y * width + x)[inside]
        away = dot(weights, columns[:, 2, triangle])
        order = np.lexsort((away, pixel))  # of triangles as far the first, for that is their order
        pixels, first = np.unique(pixel[order], return_index=True)
        chosen = order[first]
        nearer = away[chosen] < nearest[pixels]
        pixels, chosen = pixels[nearer], chosen[nearer]
        nearest[pixels], which[pixels], weight[pixels] = away[chosen], triangle[chosen], weights[:, chosen].T
        begin = end
    return Raster(which.reshape(height, width), weight.reshape(height, width, 3))


def _weights(
    corners: NDArray[np.float64], pairs: NDArray[np.int64], x: NDArray[np.float64], y: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Which points lie in their triangles (indices, (i,)), and the barycentric weights (3, i) of these.

    corners: (3, 2, m), a corner's coordinates for each triangle. pairs: how many points each has, (m,). x, y: theirs.
    """
    (ax, ay), (bx, by), (cx, cy) = corners

    def each(of_triangle: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.repeat(of_triangle, pairs)

    whole = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    proper = np.abs(whole) > 1e-12
    from_a, below_a = x - each(ax), y - each(ay)
    parts = (
        (each(bx) - x) * (each(cy) - y) - (each(by) - y) * (each(cx) - x),
        from_a * each(cy - ay) - below_a * each(cx - ax),
        each(bx - ax) * below_a - each(by - ay) * from_a,
    )
    size = each(np.where(proper, whole, 1.0))
    weights = np.stack([part / size for part in parts])
    inside = np.flatnonzero(each(proper) & (weights >= 0.0).all(axis=0))
    return inside, weights[:, inside]
