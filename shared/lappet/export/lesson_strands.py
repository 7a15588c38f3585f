"""Threads, hooks, pen marks and vessels of a lesson: lines with a thickness, anew in every frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.export.lesson_arrays import LessonArrays

_RADIUS_STEP = 0.002  # mm

Line = tuple[NDArray[np.float64], NDArray[np.float64] | float]


def strands(frames: Sequence[Sequence[Line]], arrays: LessonArrays) -> dict[str, Any]:
    """Write lines that differ from frame to frame.

    Parameters
    ----------
    frames
        For each frame its lines: points in mm, shape (k, 3), and a radius in mm, or one for each point, shape (k,).
    arrays
        Where their arrays go.

    Returns
    -------
    dict[str, Any]
        `lines`, how many each frame has, and where the numbers of their points, the points and the radii lie.
    """
    lines = [line for frame in frames for line in frame]
    points = np.concatenate([np.zeros((0, 3)), *(line for line, _ in lines)])
    radii = np.concatenate([np.zeros(0), *(np.broadcast_to(radius, len(line)) for line, radius in lines)])
    # Points follow each other along a line: as states of one place each they are differences to the point before.
    return {
        "lines": [len(frame) for frame in frames],
        "counts": arrays.add(np.array([len(line) for line, _ in lines], np.uint16)),
        "points": arrays.positions(points.reshape(-1, 1, 3)),
        "radii": arrays.add(np.rint(radii / _RADIUS_STEP).clip(1, 65535).astype(np.uint16)),
        "radiusStep": _RADIUS_STEP,
    }
