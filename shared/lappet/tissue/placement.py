"""How points drawn in space come to lie on a skin: a `Place` maps points (k, 3) to points (k, 3), mm."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.geometry.closest_point import ClosestPoint

Place = Callable[[NDArray[np.float64]], NDArray[np.float64]]


def onto(points: ArrayLike, triangles: ArrayLike) -> Place:
    """Make a `project` for designs that takes points to the closest point of a surface.

    Parameters
    ----------
    points
        Vertices in mm, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).

    Returns
    -------
    Place
        A function from points (k, 3) to points (k, 3) on the surface, in mm.
    """
    surface = ClosestPoint(points, triangles)
    return lambda drawn: surface.query(drawn)[1]
