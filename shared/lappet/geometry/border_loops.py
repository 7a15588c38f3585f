"""The loops of edges at which an open surface ends."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.surface_check import open_edges


def border_loops(triangles: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """Find the closed loops of border vertices.

    Parameters
    ----------
    triangles
        Vertex indices, shape (m, 3).

    Returns
    -------
    list[NDArray[np.int64]]
        Vertex indices of each loop, in the direction of its faces; longest loop first.
    """
    border = open_edges(triangles)
    following: dict[int, list[int]] = {}
    for a, b in border.tolist():
        following.setdefault(a, []).append(b)
    loops = []
    while following:
        start = min(following)
        loop = [start]
        while True:
            nexts = following[loop[-1]]
            step = nexts.pop()
            if not nexts:
                del following[loop[-1]]
            if step == start or step not in following:
                break
            loop.append(step)
        loops.append(np.array(loop, np.int64))
    return sorted(loops, key=lambda loop: (-len(loop), int(loop[0])))


def perimeter(points: NDArray[np.float64], loop: NDArray[np.int64]) -> float:
    """Measure a loop.

    Parameters
    ----------
    points
        Vertices in mm, shape (n, 3).
    loop
        Vertex indices in order, shape (k,).

    Returns
    -------
    float
        Length of the loop in mm.
    """
    return float(np.linalg.norm(points[np.roll(loop, -1)] - points[loop], axis=1).sum())
