"""Where lines along an axis of space cross the triangles of a surface: which points lie inside it, and how deep."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.vectors import triangle_corners

_ASIDE = 1e-7  # of the surface's extent, by which lines pass beside its vertices and edges
_PAIRS = 1 << 20  # of a line and a triangle at once


class Crossings(NamedTuple):
    """Where lines cross triangles, k times.

    Parameters
    ----------
    line
        Index of the line, ascending, shape (k,).
    along
        How far from the line's point the crossing lies along the axis, in the unit of the points, shape (k,).
    leaves
        Whether the line leaves the surface there, as it goes along the axis, shape (k,).
    """

    line: NDArray[np.int64]
    along: NDArray[np.float64]
    leaves: NDArray[np.bool_]


class AxisRays:
    """A search for the crossings of lines along one axis with a surface.

    Parameters
    ----------
    points
        Vertices in any length unit, shape (n, 3).
    triangles
        Vertex indices, outward-oriented, shape (m, 3).
    axis
        0, 1 or 2: the axis that the lines run along.
    """

    def __init__(self, points: NDArray[np.floating], triangles: NDArray[np.integer], axis: int) -> None:
        self._axes = [(axis + k) % 3 for k in (1, 2, 0)]
        self._corners = triangle_corners(np.asarray(points, np.float64)[:, self._axes], triangles)
        low, high = self._corners.min(axis=1), self._corners.max(axis=1)
        self._aside = _ASIDE * float((high.max(axis=1) - low.min(axis=1)).max())
        sides = (high - low)[:2].max(axis=0)
        self._size = max(float(np.median(sides)) * 1.5, float(sides.max()) / 32.0, 1e-30)
        self._origin = low[:2].min(axis=1, keepdims=True)
        first, last = (np.floor((each[:2] - self._origin) / self._size).astype(np.int64) for each in (low, high))
        self._tall = int(last[1].max()) + 1
        self._wide = int(last[0].max()) + 1
        span = last - first + 1
        copies = span.prod(axis=0)
        triangle = np.repeat(np.arange(low.shape[1]), copies)
        local = np.arange(len(triangle)) - np.repeat(np.cumsum(copies) - copies, copies)
        column = (first[0, triangle] + local // span[1, triangle]) * self._tall
        column += first[1, triangle] + local % span[1, triangle]
        order = np.argsort(column, kind="stable")
        self._triangle = triangle[order]
        self._start = np.searchsorted(column[order], np.arange(self._wide * self._tall + 1))

    def crossings(self, queries: NDArray[np.floating]) -> Crossings:
        """Find where the lines through points cross the surface, both ways.

        Parameters
        ----------
        queries
            A point of each line in the surface's unit, shape (q, 3).

        Returns
        -------
        Crossings
            What was found. A line passes a little beside its point, so that it meets no edge of the surface.
        """
        at = np.asarray(queries, np.float64)[:, self._axes].T.copy()
        at[:2] += self._aside * np.array([[1.0], [0.618]])
        place = np.floor((at[:2] - self._origin) / self._size).astype(np.int64)
        met = ((place >= 0) & (place < np.array([[self._wide], [self._tall]]))).all(axis=0)
        column = np.where(met, place[0] * self._tall + place[1], 0)
        count = np.where(met, self._start[column + 1] - self._start[column], 0)
        found = [Crossings(np.zeros(0, np.int64), np.zeros(0), np.zeros(0, np.bool_))]
        ends = np.cumsum(count)
        begin = 0
        while begin < len(count):
            done = ends[begin - 1] if begin else 0
            end = max(begin + 1, int(np.searchsorted(ends, done + _PAIRS, side="right")))
            line = np.repeat(np.arange(begin, end), count[begin:end])
            local = np.arange(len(line)) - np.repeat(ends[begin:end] - count[begin:end] - done, count[begin:end])
            found.append(self._crossed(at, line, self._triangle[self._start[column[line]] + local]))
            begin = end
        return Crossings(*(np.concatenate(each) for each in zip(*found, strict=True)))

    def _crossed(self, at: NDArray[np.float64], line: NDArray[np.int64], triangle: NDArray[np.int64]) -> Crossings:
        """The pairs of a line and a triangle that meet."""
        corners = self._corners[:, :, triangle]
        flat = corners[:2] - at[:2, None, line]
        x, y = flat
        # Twice the areas that the line's foot spans with each edge: of one sign inside.
        areas = np.stack([x[i] * y[j] - x[j] * y[i] for i, j in ((1, 2), (2, 0), (0, 1))])
        inside = (areas > 0.0).all(axis=0) | (areas < 0.0).all(axis=0)
        total = areas[:, inside].sum(axis=0)
        height = (areas[:, inside] * corners[2][:, inside]).sum(axis=0) / total
        return Crossings(line[inside], height - at[2, line[inside]], total > 0.0)
