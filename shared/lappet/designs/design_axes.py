"""The axes along which a design is drawn, and its points once they are placed on the skin."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Point
from lappet.tissue.placement import Place


def skin_axes(direction: ArrayLike, normal: ArrayLike, what: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Find the unit vectors of a design: along its direction, made square to the normal, and across it, to its left.

    Parameters
    ----------
    direction
        Direction of the design along the skin, shape (3,).
    normal
        Outwards from the skin, shape (3,).
    what
        Name of the design, for the message of an error.

    Returns
    -------
    tuple[NDArray[np.float64], NDArray[np.float64]]
        Unit vectors along and across, each of shape (3,).

    Raises
    ------
    RefusedError
        If the direction stands upright on the skin or a vector has no length.
    """
    up = np.asarray(normal, np.float64)
    along = np.asarray(direction, np.float64)
    up = up / max(float(np.linalg.norm(up)), 1e-300)
    flat = along - np.dot(along, up) * up
    size = float(np.linalg.norm(flat))
    if not size > 1e-9 * float(np.linalg.norm(along)) or not np.isfinite(flat).all():
        raise refused(ProblemCode.DESIGN_DIRECTION, what, tuple(along.tolist()))
    flat = flat / size
    return flat, np.cross(up, flat)


def placed_on(points: NDArray[np.float64], project: Place | None) -> tuple[Point, ...]:
    """Place a design's points on the skin.

    Parameters
    ----------
    points
        Points in mm, shape (k, 3).
    project
        Maps points (k, 3) onto the skin, or None to leave them.

    Returns
    -------
    tuple[Point, ...]
        K points in mm.
    """
    placed = points if project is None else project(points)
    return tuple((float(x), float(y), float(z)) for x, y, z in placed)
