"""Arrays of vectors, most with the coordinate as the first axis: numpy is slow along short axes that come last.

The numbers are those of `numpy.cross`, `numpy.einsum` and `numpy.linalg.norm` to the bit, and do not depend on shapes
and strides.
"""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

_ROW = 64  # points that are taken as one row of numbers
Real = TypeVar("Real", bound=np.floating[Any])


def cross(a: NDArray[Real], b: NDArray[Real]) -> NDArray[Real]:
    """Compute cross products.

    Parameters
    ----------
    a, b
        Vectors, shape (3, …).

    Returns
    -------
    NDArray[np.float64]
        The products, shape (3, …).
    """
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def dot(a: NDArray[Real], b: NDArray[Real]) -> NDArray[Real]:
    """Compute dot products, added in the order of `numpy.einsum`.

    Parameters
    ----------
    a, b
        Vectors, shape (3, …).

    Returns
    -------
    NDArray[np.float64]
        The products, shape (…).
    """
    return np.asarray((a[0] * b[0] + a[2] * b[2]) + a[1] * b[1])


def length(vectors: NDArray[Real]) -> NDArray[Real]:
    """Compute the lengths of vectors, added in the order of `numpy.linalg.norm`.

    Parameters
    ----------
    vectors
        Vectors, shape (3, …).

    Returns
    -------
    NDArray[np.float64]
        Lengths, shape (…).
    """
    total = vectors[0] * vectors[0]
    for each in vectors[1:]:
        total += each * each
    return np.asarray(np.sqrt(total))


def unit(vectors: NDArray[Real]) -> NDArray[Real]:
    """Scale vectors to length 1; those of length 0 stay.

    Parameters
    ----------
    vectors
        Vectors, shape (3, …).

    Returns
    -------
    NDArray[np.float64]
        The directions, shape (3, …).
    """
    size = length(vectors)
    return vectors / (size + (size == 0.0))


def bounds(points: NDArray[Real]) -> NDArray[Real]:
    """Find the box around points.

    Parameters
    ----------
    points
        At least one point, shape (n, 3), row by row in memory.

    Returns
    -------
    NDArray[np.float64]
        The least and the greatest coordinates, shape (2, 3).
    """
    whole = len(points) // _ROW * _ROW
    wide, rest = points[:whole].reshape(-1, 3 * _ROW), points[whole:]
    found = []
    for extreme in (np.min, np.max):
        parts = [extreme(wide, axis=0).reshape(_ROW, 3)] if whole else []
        found.append(extreme(np.concatenate([*parts, rest]), axis=0))
    return np.stack(found)


def triangle_corners(points: NDArray[np.float64], triangles: NDArray[np.integer]) -> NDArray[np.float64]:
    """Gather the corners of triangles.

    Parameters
    ----------
    points
        Vertices, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).

    Returns
    -------
    NDArray[np.float64]
        The vertices, shape (3, 3, m): coordinate, corner, triangle.
    """
    return np.take(np.ascontiguousarray(points.T), np.ascontiguousarray(triangles.T), axis=1)
