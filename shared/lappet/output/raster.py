"""Draw triangles into a picture without a graphics card: nearest surface, and where on it, for each pixel."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

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
    begin = 0
    while begin < len(count):
        done = int(total[begin - 1]) if begin else 0
        end = max(begin + 1, int(np.searchsorted(total, done + _SAMPLES, side="right")))
        triangle = np.repeat(np.arange(begin, end), count[begin:end])
        local = np.arange(len(triangle)) - np.repeat(total[begin:end] - count[begin:end] - done, count[begin:end])
        x = low[triangle, 0] + local % np.maximum(span[triangle, 0], 1)
        y = low[triangle, 1] + local // np.maximum(span[triangle, 0], 1)
        inside, weights = _weights(flat[triangle], np.stack([x, y], axis=1) + 0.5)
        triangle, pixel, weights = triangle[inside], (y * width + x)[inside], weights[inside]
        away = np.einsum("ij,ij->i", weights, corners[triangle][:, :, 2])
        order = np.lexsort((triangle, away, pixel))
        pixels, first = np.unique(pixel[order], return_index=True)
        chosen = order[first]
        nearer = away[chosen] < nearest[pixels]
        pixels, chosen = pixels[nearer], chosen[nearer]
        nearest[pixels], which[pixels], weight[pixels] = away[chosen], triangle[chosen], weights[chosen]
        begin = end
    return Raster(which.reshape(height, width), weight.reshape(height, width, 3))


def _weights(
    corners: NDArray[np.float64], points: NDArray[np.float64]
) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
    """Which points (k, 2) lie in their triangles (k, 3, 2), and their barycentric weights (k, 3)."""
    a, b, c = corners.swapaxes(0, 1)

    def area(p: NDArray[np.float64], q: NDArray[np.float64], r: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray((q[:, 0] - p[:, 0]) * (r[:, 1] - p[:, 1]) - (q[:, 1] - p[:, 1]) * (r[:, 0] - p[:, 0]))

    whole = area(a, b, c)
    parts = np.stack([area(points, b, c), area(a, points, c), area(a, b, points)], axis=1)
    proper = np.abs(whole) > 1e-12
    weights = parts / np.where(proper, whole, 1.0)[:, None]
    return proper & (weights >= 0.0).all(axis=1), weights
