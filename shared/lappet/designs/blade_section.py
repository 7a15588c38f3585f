"""The way of a cut over a rolled border: where the plane of a blade meets the skin, from a place on."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.geometry.surface_check import directed_edges


def blade_section(
    points: NDArray[np.float64],
    triangles: NDArray[np.integer],
    start: int,
    through: ArrayLike,
    normal: ArrayLike,
    way: ArrayLike,
) -> NDArray[np.float64]:
    """Follow the section of a skin with a plane from a place on it to the skin's border, or around.

    Parameters
    ----------
    points
        Vertices of the skin in mm, shape (n, 3).
    triangles
        Its triangles, shape (m, 3).
    start
        The triangle in which the way begins.
    through
        The place in it, in mm, shape (3,).
    normal
        Normal of the plane, of any length.
    way
        Which of the two ways along the section is taken, of any length.

    Returns
    -------
    NDArray[np.float64]
        The place, then points on edges of the skin, in order, in mm, shape (k, 3); the place alone where the plane
        only touches the triangle.
    """
    begin = np.asarray(through, np.float64)
    across, onward = np.asarray(normal, np.float64), np.asarray(way, np.float64)
    high = (points - begin) @ across
    edges = directed_edges(triangles)  # (3 m, 2): first all 0-1, then 1-2, then 2-0
    beside = {(int(a), int(b)): k % len(triangles) for k, (a, b) in enumerate(edges)}

    def crossings(face: int) -> list[tuple[tuple[int, int], NDArray[np.float64]]]:
        found = []
        a, b, c = (int(vertex) for vertex in triangles[face])
        for one, two in ((a, b), (b, c), (c, a)):
            if (high[one] < 0.0) != (high[two] < 0.0):
                share = high[one] / (high[one] - high[two])
                found.append(((one, two), points[one] + share * (points[two] - points[one])))
        return found

    first = crossings(start)
    if not first:
        return begin[None]
    edge, at = max(first, key=lambda each: float(each[1] @ onward))
    line, seen = [begin, at], {start}
    while (face := beside.get((edge[1], edge[0]))) is not None and face not in seen:
        seen.add(face)
        ((edge, at),) = (each for each in crossings(face) if each[0] != (edge[1], edge[0]))
        line.append(at)
    return np.array(line)
