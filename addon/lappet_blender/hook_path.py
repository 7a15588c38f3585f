"""The course of a skin hook: a fine curved tip in the skin, a shank, a handle along the pull."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

ELEVATION = np.radians(34.0)
CROOK = 1.3
SHANK = 26.0
HANDLE = 80.0
SHANK_RADIUS = 0.36
HANDLE_RADIUS = 0.85


def pull_direction(
    anchors: NDArray[np.float64], normal: NDArray[np.float64], away: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Unit direction (3,) of a hook's handle over its whole life, so that it does not swing from frame to frame.

    anchors: (k, 3) mm, the course of the hook's end on the tissue and its targets. normal: (3,) unit, out of the skin.
    away: (3,) direction to take where the course does not move along the skin (mm, any length). The handle leans along
    the skin's part of the course and rises by `ELEVATION`.
    """
    course = anchors[-1] - anchors[0]
    farthest = anchors - anchors[0]
    if len(anchors):
        course = farthest[np.linalg.norm(farthest - np.outer(farthest @ normal, normal), axis=1).argmax()]
    flat = course - (course @ normal) * normal
    if np.linalg.norm(flat) < 0.5:
        flat = away - (away @ normal) * normal
    if np.linalg.norm(flat) < 1e-6:
        axis = np.eye(3)[int(np.abs(normal).argmin())]
        flat = axis - (axis @ normal) * normal
    flat /= np.linalg.norm(flat)
    return np.cos(ELEVATION) * flat + np.sin(ELEVATION) * normal


def hook_path(
    anchor: NDArray[np.float64], direction: NDArray[np.float64], normal: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Centre line (k, 3) in mm and radii (k,) in mm of a hook that holds the skin at a point.

    The tip lies under the skin, points back along the pull and bends over the anchor into the shank.
    """
    flat = direction - (direction @ normal) * normal
    flat /= max(float(np.linalg.norm(flat)), 1e-9)
    # From the tip, under the skin, around the crook, to the shank: an arc in the plane of pull and normal.
    rise = float(direction @ normal)
    start, stop = np.radians(-75.0), np.pi / 2 + np.arcsin(np.clip(rise, -1, 1))
    angle = np.linspace(start, stop, 15)[:, None]
    centre = anchor + 0.35 * CROOK * normal
    arc = centre - CROOK * (np.cos(angle) * flat - np.sin(angle) * normal)
    arc_radius = np.linspace(0.10, SHANK_RADIUS * 0.8, len(arc))
    reach = np.array([3.0, 9.0, SHANK, SHANK + 2.0, SHANK + 4.0, HANDLE - 1.5, HANDLE])
    radius = (
        np.array([0.9, 1.0, 1.0, 1.6, HANDLE_RADIUS / SHANK_RADIUS, HANDLE_RADIUS / SHANK_RADIUS, 1.2]) * SHANK_RADIUS
    )
    line = arc[-1] + reach[:, None] * direction
    return np.vstack([arc, line]), np.concatenate([arc_radius, radius])
