"""The course of a stitch between its two bites: the thread over the wound, the knot beside it and the knot's tails."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

THREAD_RADIUS = 0.11
BURIED = 0.5
KNOT_RADIUS = 0.19
KNOT_LENGTH = 0.42
KNOT_AT = 0.2
TAIL = 1.0
# Along the thread, the coil and a tail, 0 to 1; stitches are drawn anew in every frame.
_ALONG = np.linspace(0.0, 1.0, 9)[:, None]
_ARCH = np.sin(np.pi * _ALONG)
_COIL = np.linspace(0.0, 2.0, 21)[:, None]
_COIL_COS, _COIL_SIN = np.cos(2 * np.pi * _COIL), np.sin(2 * np.pi * _COIL)
_TAIL = np.linspace(0.0, 1.0, 5)[:, None]


@dataclass(frozen=True, eq=False)
class StitchPath:
    """The lines of a stitch.

    Parameters
    ----------
    thread
        The thread from bite to bite in mm, shape (k, 3).
    knot
        Once it is tied, the knot's coil and tails in mm, shape (k, 3) each.
    """

    thread: NDArray[np.float64]
    knot: tuple[NDArray[np.float64], ...]


def stitch_path(
    bites: NDArray[np.float64], lips: NDArray[np.float64], normals: NDArray[np.float64], tied: bool, scale: float = 1.0
) -> StitchPath:
    """Lay the lines of a stitch.

    Parameters
    ----------
    bites
        Where the thread enters the skin in mm, shape (2, 3); the knot lies beside the first.
    lips
        The suture's ends on the wound's edges in mm, shape (2, 3); the thread lies over them.
    normals
        Unit normals of the skin at the bites, shape (2, 3).
    tied
        Whether the wound is closed there, so that the knot is tied.
    scale
        Of all thicknesses and of the knot.

    Returns
    -------
    StitchPath
        The lines.
    """
    radius = THREAD_RADIUS * scale
    up = _unit(normals.sum(axis=0))
    if not tied:
        over = np.stack([bites[0], lips[0], lips[1], bites[1]])
        over += radius * np.stack([normals[0], normals[0], normals[1], normals[1]])
        return StitchPath(_entering(over, normals, scale), ())
    summit = lips.mean(axis=0)
    # The thread lies on the skin: as high over the wound as the wound's edge stands over the line between the bites.
    rise = max(float((summit - bites.mean(axis=0)) @ up), 0.0) + 0.5 * radius
    over = bites[0] + _ALONG * (bites[1] - bites[0]) + (radius + rise * _ARCH) * up
    along = _unit(bites[1] - bites[0])
    sideways = np.array(
        [up[1] * along[2] - up[2] * along[1], up[2] * along[0] - up[0] * along[2], up[0] * along[1] - up[1] * along[0]]
    )
    center = bites[0] + KNOT_AT * (bites[1] - bites[0]) + (radius + rise * np.sin(np.pi * KNOT_AT)) * up
    coil = center + scale * (
        (_COIL / 2.0 - 0.5) * KNOT_LENGTH * along + KNOT_RADIUS * (_COIL_COS * sideways + (0.35 + _COIL_SIN) * up)
    )
    s = _TAIL
    tails = tuple(
        center + scale * (TAIL * s * (0.72 * side * sideways - 0.69 * along) + (0.15 + 0.35 * s - 0.4 * s**2) * up)
        for side in (1.0, -1.0)
    )
    return StitchPath(_entering(over, normals, scale), (coil, *tails))


def risen(path: StitchPath, rises: NDArray[np.float64], up: NDArray[np.float64]) -> StitchPath:
    """Raise a stitch where the skin bulges between its bites; what enters the skin stays where it is.

    Parameters
    ----------
    path
        A tied stitch.
    rises
        How far the points of its thread rise, but for the first and the last, in mm, shape (k - 2,).
    up
        Unit vector in which they do, shape (3,).

    Returns
    -------
    StitchPath
        The stitch; its knot rises as the thread does there.
    """
    thread = path.thread.copy()
    thread[1:-1] += rises[:, None] * up
    at_knot = float(np.interp(KNOT_AT, _ALONG[:, 0], rises))
    return StitchPath(thread, tuple(line + at_knot * up for line in path.knot))


def _entering(over: NDArray[np.float64], normals: NDArray[np.float64], scale: float) -> NDArray[np.float64]:
    """The thread over the skin, carried on into the skin at both bites."""
    return np.vstack([over[0] - BURIED * scale * normals[0], over, over[-1] - BURIED * scale * normals[1]])


def _unit(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    unit: NDArray[np.float64] = vector / max(float(vector @ vector) ** 0.5, 1e-12)
    return unit
