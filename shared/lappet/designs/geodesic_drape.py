"""Drape a flat design over any skin: straight lines from its middle stay straight and as long as they were."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.tissue.placement import Place
from lappet.tissue.skin_sheet import SkinSheet

STEP = 0.5  # mm: a line is walked in such steps


def draped_on(skin: SkinSheet, center: ArrayLike) -> Place:
    """Make a `project` for designs drawn in the skin's tangent plane at a point.

    A point of the plane goes where the geodesic that starts towards it has come after its distance from the middle: the
    exponential map of the surface, by steps of `STEP`. On a sphere it is `lappet.tissue.dome.draped`. A line that meets
    the skin's border ends there.

    Parameters
    ----------
    skin
        The skin.
    center
        A point in mm, shape (3,); the plane touches the skin where that is closest to it.

    Returns
    -------
    Place
        A function from points of the plane in mm, shape (k, 3), to points on the skin in mm, shape (k, 3).
    """
    points, normals = skin.at(center)
    middle, normal = points[0], normals[0]

    def drape(plane: NDArray[np.float64]) -> NDArray[np.float64]:
        offsets = plane - middle
        offsets -= np.outer(offsets @ normal, normal)
        return np.array([_walk(skin, middle, normal, offset) for offset in offsets])

    return drape


def _walk(
    skin: SkinSheet, start: NDArray[np.float64], normal: NDArray[np.float64], offset: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Where one comes to from `start` going straight over the skin, first along `offset` and as far as it is long."""
    left = float(np.linalg.norm(offset))
    here, along = start, offset / max(left, 1e-300)
    while left > 1e-9:
        ahead = along - (along @ normal) * normal
        ahead /= max(float(np.linalg.norm(ahead)), 1e-300)
        step = min(STEP, left)
        points, normals = skin.at(here + step * ahead)
        if (points[0] - here) @ ahead < 0.5 * step:  # the border is in the way
            break
        left -= step
        here, normal, along = points[0], normals[0], points[0] - here
    return here
