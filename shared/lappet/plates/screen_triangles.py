"""Which triangle of a surface lies nearest behind a place on the paper: rays through a grid of cells."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_PAIRS = 100_000  # of a place and a triangle that are looked at at once: what the processor's caches hold
_EDGE = 1e-9  # share of a triangle by which a place may lie outside it


class ScreenTriangles:
    """The triangles of a projected surface that face the camera, by the cells of the paper that they cover.

    Parameters
    ----------
    paper
        Where the vertices lie on the paper in mm, shape (n, 2).
    depth
        Their depths in mm, positive, shape (n,).
    triangles
        Vertex indices, counterclockwise as seen from outside, shape (m, 3).
    cell
        Side of a cell in mm.
    behind
        Whether to take those that face away from the camera instead.
    frame
        Half the width and height in mm beside which nothing is looked for; None: everywhere.
    """

    def __init__(
        self,
        paper: NDArray[np.float64],
        depth: NDArray[np.float64],
        triangles: NDArray[np.integer],
        cell: float,
        behind: bool = False,
        frame: tuple[float, float] | None = None,
    ) -> None:
        corners = paper[triangles]
        first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        area = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
        # y runs downwards. Of a closed surface what faces the camera is nearest.
        kept = area > 1e-12 if behind else area < -1e-12
        if frame is not None:  # a close-up: what lies beside it is not looked at
            reach = np.asarray(frame)
            kept &= ((corners.min(axis=1) < reach) & (corners.max(axis=1) > -reach)).all(axis=1)
        self.ids = np.flatnonzero(kept)
        # Rows of numbers, which are picked faster than pairs of them.
        vectors = (corners[kept, 0], first[kept], second[kept])
        self._numbers = np.concatenate([*(each.T for each in vectors), area[kept][None]])
        self._inverse = 1.0 / depth[triangles[kept]]  # linear on the paper
        low, high = corners[kept].min(axis=1), corners[kept].max(axis=1)
        if frame is not None:
            low, high = np.maximum(low, -reach), np.minimum(high, reach)
        self._low = low.min(axis=0) if len(low) else np.zeros(2)
        self._cell = cell
        begin, end = self._cell_of(low), self._cell_of(high)
        self._shape = end.max(axis=0) + 1 if len(end) else np.ones(2, np.int64)
        across, down = (end - begin + 1).T if len(end) else np.zeros((2, 0), np.int64)
        counts = across * down
        owner = np.repeat(np.arange(len(counts)), counts)
        place = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
        x = begin[owner, 0] + place % across[owner]
        y = begin[owner, 1] + place // across[owner]
        cells = y * self._shape[0] + x
        order = np.argsort(cells, kind="stable")
        self._owner = owner[order]
        self._start = np.searchsorted(cells[order], np.arange(int(self._shape.prod()) + 1))

    def nearest(self, places: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Find what is seen at some places.

        Parameters
        ----------
        places
            Places on the paper in mm, shape (k, 2).

        Returns
        -------
        tuple[NDArray[np.int64], NDArray[np.float64]]
            The triangle that is nearest to the camera there, -1 where there is none, and its depth in mm, infinite
            where there is none; both of shape (k,).
        """
        found = np.full(len(places), -1, np.int64)
        inverse = np.zeros(len(places))
        if not len(self.ids):
            return found, np.full(len(places), np.inf)
        at = self._cell_of(places)
        inside = ((at >= 0) & (at < self._shape)).all(axis=1)
        cells = np.where(inside, at[:, 1] * self._shape[0] + at[:, 0], 0)
        counts = np.where(inside, self._start[cells + 1] - self._start[cells], 0)
        ends = np.cumsum(counts)
        begin = 0
        while begin < len(places):
            base = ends[begin - 1] if begin else 0
            end = max(int(np.searchsorted(ends, base + _PAIRS, side="right")), begin + 1)
            self._look(places, cells, counts, slice(begin, end), found, inverse)
            begin = end
        with np.errstate(divide="ignore"):
            return np.where(found >= 0, self.ids[found], -1), 1.0 / inverse

    def _look(
        self,
        places: NDArray[np.float64],
        cells: NDArray[np.int64],
        counts: NDArray[np.int64],
        part: slice,
        found: NDArray[np.int64],
        inverse: NDArray[np.float64],
    ) -> None:
        """Look at some of the places."""
        count = counts[part]
        place = np.arange(int(count.sum())) - np.repeat(np.cumsum(count) - count, count)
        candidate = self._owner[np.repeat(self._start[cells[part]], count) + place]
        left, top, first_x, first_y, second_x, second_y, area = (each[candidate] for each in self._numbers)
        away_x, away_y = (np.repeat(each, count) for each in places[part].T)
        away_x -= left
        away_y -= top
        u = (away_x * second_y - away_y * second_x) / area
        v = (first_x * away_y - first_y * away_x) / area
        hit = (u >= -_EDGE) & (v >= -_EDGE) & (u + v <= 1.0 + _EDGE)
        owner = np.repeat(np.arange(part.start, part.stop), count)[hit]
        candidate, u, v = candidate[hit], u[hit], v[hit]
        corner = self._inverse[candidate]
        nearness = corner[:, 0] + u * (corner[:, 1] - corner[:, 0]) + v * (corner[:, 2] - corner[:, 0])
        # Owners stand in order: each has its candidates together, of which the nearest and, of those, the first counts.
        begin = np.flatnonzero(np.diff(owner, prepend=-1))
        if not len(begin):
            return
        best = np.maximum.reduceat(nearness, begin)
        is_best = nearness == np.repeat(best, np.diff(begin, append=len(owner)))
        found[owner[begin]] = np.minimum.reduceat(np.where(is_best, candidate, len(self.ids)), begin)
        inverse[owner[begin]] = best

    def _cell_of(self, places: NDArray[np.float64]) -> NDArray[np.int64]:
        cells: NDArray[np.int64] = np.floor((places - self._low) / self._cell).astype(np.int64)
        return cells
