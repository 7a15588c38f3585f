"""The face of the tissue that each triangle of a cut surface lies on: material picked on cut skin is marked there."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.labelled_surface import FaceOrigin, Surface
from lappet.geometry.triangulation import triangulate
from lappet.procedure import Tissue

_PAIRS = 1_000_000  # point and triangle at once


class TissueFaces:
    """A search for the nearest face of a tissue; the surfaces of its epochs lie on it but for their wound walls.

    Candidates come from a grid of boxes as wide as the tissue's triangles; what lies farther off than a tenth of such a
    box is asked of `ClosestPoint`.

    Parameters
    ----------
    tissue
        The tissue.
    """

    def __init__(self, tissue: Tissue) -> None:
        points = np.asarray(tissue.points, np.float64)
        triangles, _, self._face = triangulate(
            points, np.asarray(tissue.face_vertex_counts, np.int64), np.asarray(tissue.face_vertex_indices, np.int64)
        )
        self._points, self._triangles = points, triangles
        self._corners = points[triangles]
        low, high = self._corners.min(axis=1), self._corners.max(axis=1)
        size = float(np.median((high - low).max(axis=1)))
        extent = float(np.ptp(points, axis=0).max())
        self._size = max(size, extent / 200.0, 1e-12)  # the grid stays below 200³ boxes
        self._reach = 0.1 * self._size
        self._low = points.min(axis=0) - 2.0 * self._reach
        first, last = self._box(low - self._reach), self._box(high + self._reach)
        self._shape = last.max(axis=0) + 1
        # A row per triangle and box that it may touch, in the order of the boxes.
        spans = last - first + 1
        counts = spans.prod(axis=1)
        owner = np.repeat(np.arange(len(triangles)), counts)
        within = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
        step = np.stack(
            [
                within // (spans[owner, 1] * spans[owner, 2]),
                within // spans[owner, 2] % spans[owner, 1],
                within % spans[owner, 2],
            ],
            axis=1,
        )
        code = self._code(first[owner] + step)
        order = np.argsort(code, kind="stable")
        self._boxes, self._owner = code[order], owner[order]

    def of(self, surface: Surface) -> NDArray[np.int32]:
        """Find the face under the center of each triangle of an epoch's surface.

        Parameters
        ----------
        surface
            The surface.

        Returns
        -------
        NDArray[np.int32]
            Faces, shape (m,), int32; -1 for wound walls.
        """
        result = np.full(len(surface.triangles), -1, np.int32)
        asked = np.flatnonzero(surface.origin != FaceOrigin.WOUND_WALL)
        centres = surface.points[surface.triangles[asked]].mean(axis=1)
        result[asked] = self.nearest(centres)
        return result

    def nearest(self, points: NDArray[np.float64]) -> NDArray[np.int32]:
        """Find the face nearest to each point.

        Parameters
        ----------
        points
            Points in mm, shape (q, 3).

        Returns
        -------
        NDArray[np.int32]
            Faces, shape (q,), int32.
        """
        box = self._box(points)
        inside = ((box >= 0) & (box < self._shape)).all(axis=1)
        code = np.where(inside, self._code(box), -1)
        start = np.searchsorted(self._boxes, code, "left")
        counts = np.searchsorted(self._boxes, code, "right") - start
        best = np.full(len(points), -1, np.int64)
        ends = np.cumsum(counts)
        cuts = np.searchsorted(ends, np.arange(_PAIRS, ends[-1] if len(ends) else 0, _PAIRS))
        for rows in np.split(np.arange(len(points)), cuts):
            self._search(points, rows, start, counts, best)
        far = np.flatnonzero(best < 0)
        if len(far):
            best[far] = ClosestPoint(self._points, self._triangles).query(points[far])[0]
        return self._face[best].astype(np.int32)

    def _search(
        self,
        points: NDArray[np.float64],
        rows: NDArray[np.int64],
        start: NDArray[np.int64],
        counts: NDArray[np.int64],
        best: NDArray[np.int64],
    ) -> None:
        many = counts[rows]
        if not many.sum():
            return
        query = np.repeat(rows, many)
        within = np.arange(len(query)) - np.repeat(np.cumsum(many) - many, many)
        candidate = self._owner[start[query] + within]
        squared = _squared_distance(points[query], self._corners[candidate])
        # The least distance of each point, the first triangle where several have it.
        order = np.lexsort((candidate, squared, query))
        first = order[np.unique(query[order], return_index=True)[1]]
        near = first[squared[first] <= self._reach**2]
        best[query[near]] = candidate[near]

    def _box(self, points: NDArray[np.float64]) -> NDArray[np.int64]:
        return np.floor((points - self._low) / self._size).astype(np.int64)

    def _code(self, box: NDArray[np.int64]) -> NDArray[np.int64]:
        return (box[:, 0] * self._shape[1] + box[:, 1]) * self._shape[2] + box[:, 2]


def _squared_distance(points: NDArray[np.float64], corners: NDArray[np.float64]) -> NDArray[Any]:
    """The squared distance (k,) of each point (k, 3) to its triangle (k, 3, 3), degenerate ones included."""
    edges = corners[:, [1, 2, 0]] - corners
    offset = points[:, None] - corners
    lengths = np.einsum("kij,kij->ki", edges, edges)
    along = np.einsum("kij,kij->ki", offset, edges)
    t = np.clip(np.divide(along, lengths, out=np.zeros_like(along), where=lengths > 0.0), 0.0, 1.0)
    apart = offset - t[..., None] * edges
    squared = np.einsum("kij,kij->ki", apart, apart).min(axis=1)
    normal = np.cross(edges[:, 0], edges[:, 1])
    area = np.einsum("kj,kj->k", normal, normal)
    sides = np.einsum("kij,kj->ki", np.cross(edges, offset), normal)
    above = (area > 0.0) & (sides >= 0.0).all(axis=1)
    height = np.einsum("kj,kj->k", offset[:, 0], normal)
    return np.where(above, np.divide(height**2, area, out=np.full_like(area, np.inf), where=area > 0.0), squared)
