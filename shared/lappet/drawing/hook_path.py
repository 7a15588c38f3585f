"""The course of a skin hook: a fine point in the skin, a crook around its edge, a slender shank and a handle."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

ELEVATION = np.radians(42.0)
CROOK = 0.75
LEAST_SIDEWAYS = 0.6
SHANK = 30.0
HANDLE = 95.0
SHANK_RADIUS = 0.22
HANDLE_RADIUS = 0.6


def hook_directions(
    courses: list[NDArray[np.float64]], center: NDArray[np.float64], axes: NDArray[np.float64]
) -> list[NDArray[np.float64]]:
    """Choose the directions of the handles of hooks, fixed for their whole life so that they do not swing.

    Handles rise by `ELEVATION`, half of them to the left and half to the right of the picture in the order of the
    hooks' places, so that none crosses the field.

    Parameters
    ----------
    courses
        Where each hook's end on the tissue goes in mm, shape (k, 3).
    center
        The middle of the field in mm, shape (3,).
    axes
        Unit vectors to the right, up along the skin and along its normal, as the picture is seen, shape (3, 3).

    Returns
    -------
    list[NDArray[np.float64]]
        A unit vector for each hook, shape (3,).
    """
    places = np.array([(course.mean(axis=0) - center) @ axes.T for course in courses]).reshape(-1, 3)
    starts = np.array([(course[0] - center) @ axes.T for course in courses]).reshape(-1, 3)
    reach = max(float(np.abs(places[:, :2]).max(initial=0.0)), 1e-9)
    across = places[:, 0] + 0.5 * starts[:, 0]
    directions = [np.zeros(3)] * len(courses)
    for rank, k in enumerate(np.argsort(across, kind="stable")):
        side = np.sign(across[k]) or 1.0
        if len(courses) > 1:
            side = -1.0 if rank < len(courses) / 2 else 1.0
        sideways, along = np.clip(places[k, :2] / reach, -1.0, 1.0)
        flat = side * max(abs(float(sideways)), LEAST_SIDEWAYS) * axes[0] + float(along) * axes[1]
        flat /= np.linalg.norm(flat)
        directions[int(k)] = np.cos(ELEVATION) * flat + np.sin(ELEVATION) * axes[2]
    return directions


def hook_path(
    anchor: NDArray[np.float64],
    direction: NDArray[np.float64],
    normal: NDArray[np.float64],
    edge: NDArray[np.float64],
    scale: float = 1.0,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lay the line of a hook that holds an edge of skin by a point beside it.

    The point comes up through the skin at the anchor and shows a little above it; from there the crook runs under the
    skin, around its edge and up into the shank.

    Parameters
    ----------
    anchor
        Where the hook holds the skin in mm, shape (3,).
    direction
        Unit vector along the handle, shape (3,).
    normal
        Unit vector out of the skin at the anchor, shape (3,).
    edge
        Unit vector from the anchor towards the edge, shape (3,).
    scale
        Of all thicknesses and of the crook.

    Returns
    -------
    tuple[NDArray[np.float64], NDArray[np.float64]]
        The center line, shape (k, 3), and its radii, shape (k,), in mm.
    """
    out = edge - (edge @ normal) * normal
    if np.linalg.norm(out) < 1e-6:
        out = direction - (direction @ normal) * normal
    if np.linalg.norm(out) < 1e-6:
        axis = np.eye(3)[int(np.abs(normal).argmin())]
        out = axis - (axis @ normal) * normal
    out /= np.linalg.norm(out)
    radius = CROOK * scale
    angle = np.linspace(np.radians(-225.0), 0.0, 19)[:, None]
    crook = anchor + radius * ((1.0 + np.cos(angle)) * out + np.sin(angle) * normal)
    # From the crook's end, which runs along the normal, a smooth bend into the handle's direction.
    begin = crook[-1]
    end = begin + 2.2 * radius * direction + 0.8 * radius * normal
    t = np.linspace(0.0, 1.0, 9)[1:, None]
    bend = (
        (2 * t**3 - 3 * t**2 + 1) * begin
        + (t**3 - 2 * t**2 + t) * (3.0 * radius * normal)
        + (3 * t**2 - 2 * t**3) * end
        + (t**3 - t**2) * (3.0 * radius * direction)
    )
    reach = np.array([6.0, SHANK, SHANK + 1.5, SHANK + 4.0, HANDLE - 1.5, HANDLE]) * scale
    line = end + reach[:, None] * direction
    thin, thick = SHANK_RADIUS * scale, HANDLE_RADIUS * scale
    radii = np.concatenate(
        [
            np.linspace(0.25, 0.75, len(crook)) * thin,
            np.linspace(0.75, 0.9, len(bend)) * thin,
            [thin, thin * 1.25, 0.8 * thick, thick, thick, 0.5 * thick],
        ]
    )
    return np.vstack([crook, bend, line]), radii
