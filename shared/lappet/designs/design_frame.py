"""The frame in which a design is drawn, and its points once they are placed on the skin."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.core.problem import RefusedError
from lappet.procedure import Point
from lappet.tissue.placement import Place


def skin_frame(direction: ArrayLike, normal: ArrayLike, what: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Unit vectors along the direction (made square to the normal) and across it, to its left."""
    up = np.asarray(normal, np.float64)
    along = np.asarray(direction, np.float64)
    up = up / max(float(np.linalg.norm(up)), 1e-300)
    flat = along - np.dot(along, up) * up
    size = float(np.linalg.norm(flat))
    if not size > 1e-9 * float(np.linalg.norm(along)) or not np.isfinite(flat).all():
        raise RefusedError(f"{what}: the direction {tuple(along.tolist())} does not lie along the skin; turn it")
    flat = flat / size
    return flat, np.cross(up, flat)


def placed_on(points: NDArray[np.float64], project: Place | None) -> tuple[Point, ...]:
    """The points (k, 3) of a design where `project` puts them on the skin."""
    placed = points if project is None else project(points)
    return tuple((float(x), float(y), float(z)) for x, y, z in placed)
