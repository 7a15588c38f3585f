"""The line around the skin that a design's operation frees, where skin ends nearby: at a border, a mouth, a nostril.

It is the contour of what lies at most so far from the cuts, measured along the skin, and at least `INSET` from every
border of the skin.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from lappet.designs.flat_curves import length
from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.geodesic_distance import geodesic_distance
from lappet.geometry.triangulation import triangulate
from lappet.procedure import Point, Tissue
from lappet.tissue.skin_sheet import SkinSheet
from lappet.tissue.surface import skin_faces

INSET = 2.0  # mm of skin that stays on its bed beside a border
_SOURCES = 12  # points of the cuts from which distances are measured
_POINTS = 64  # of the line
_SMOOTHED = 3  # times each point of the line moves to between its neighbors


class SkinBorder:
    """The skin's triangles and where they end.

    Parameters
    ----------
    tissue
        The tissue.
    """

    def __init__(self, tissue: Tissue) -> None:
        counts, indices = tissue.face_vertex_counts.astype(np.int64), tissue.face_vertex_indices.astype(np.int64)
        triangles, _, faces = triangulate(tissue.points, counts, indices)
        self.points = tissue.points
        self.triangles = triangles[skin_faces(tissue)[faces]]
        edges = np.sort(np.vstack([self.triangles[:, [0, 1]], self.triangles[:, [1, 2]], self.triangles[:, [2, 0]]]))
        key, count = np.unique(edges, axis=0, return_counts=True)
        ends = key[count == 1]
        self._ends = ClosestPoint(self.points, ends[:, [0, 1, 1]]) if len(ends) else None

    def distance(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Measure how far points are from where the skin ends.

        Parameters
        ----------
        points
            Points in mm, shape (k, 3).

        Returns
        -------
        NDArray[np.float64]
            Straight distances in mm, shape (k,); infinite on a closed skin.
        """
        return np.full(len(points), np.inf) if self._ends is None else self._ends.query(points)[2]


def reaches_border(border: SkinBorder, line: Sequence[Point]) -> bool:
    """Tell whether a line comes nearer to where the skin ends than `INSET`.

    Parameters
    ----------
    border
        The skin's border.
    line
        Points of the line in mm.

    Returns
    -------
    bool
        Whether it does.
    """
    return bool(border.distance(np.array(line)).min() < INSET)


def contour_around(
    border: SkinBorder, skin: SkinSheet, cuts: Sequence[Sequence[Point]], beyond: float
) -> tuple[Point, ...]:
    """Draw the line around the skin near cuts.

    Parameters
    ----------
    border
        The skin's triangles and border.
    skin
        The skin.
    cuts
        Points of each cut on the skin in mm.
    beyond
        Distance from the cuts along the skin in mm.

    Returns
    -------
    tuple[Point, ...]
        Points of the closed line on the skin in mm; none where no skin is left.
    """
    drawn = np.array([point for cut in cuts for point in cut])
    sources = drawn[np.unique(np.linspace(0, len(drawn) - 1, _SOURCES).round().astype(int))]
    away = np.full(len(border.points), np.inf)
    for source in sources:
        away = np.minimum(away, geodesic_distance(border.points, border.triangles, source, 2.0 * beyond))
    used = np.unique(border.triangles)
    room = np.full(len(border.points), -1.0)
    room[used] = np.minimum(beyond - np.minimum(away[used], 2.0 * beyond), border.distance(border.points[used]) - INSET)
    loops = _contours(border.points, border.triangles, room)
    if not loops:
        return ()
    line = max(loops, key=length)
    for _ in range(_SMOOTHED):
        line = 0.5 * line + 0.25 * (np.roll(line, 1, axis=0) + np.roll(line, -1, axis=0))
    return tuple(skin.below(point, 0.0) for point in _spaced(line))


def _contours(
    points: NDArray[np.float64], triangles: NDArray[np.int64], room: NDArray[np.float64]
) -> list[NDArray[np.float64]]:
    """The closed lines (k, 3) along which a function of the vertices is zero."""
    follows: dict[tuple[int, int], tuple[int, int]] = {}
    inside = room > 0.0
    for triangle in triangles[inside[triangles].any(axis=1) & ~inside[triangles].all(axis=1)]:
        enters = leaves = None
        for k in range(3):
            a, b = int(triangle[k]), int(triangle[(k + 1) % 3])
            if inside[a] and not inside[b]:
                leaves = (min(a, b), max(a, b))
            elif inside[b] and not inside[a]:
                enters = (min(a, b), max(a, b))
        if enters is not None and leaves is not None:
            follows[leaves] = enters
    loops = []
    while follows:
        first, here = follows.popitem()
        chain = [first]
        while here != first and here in follows:
            chain.append(here)
            here = follows.pop(here)
        if here == first and len(chain) > 3:
            a, b = np.array(chain).T
            share = (room[a] / (room[a] - room[b]))[:, None]
            loops.append(points[a] + share * (points[b] - points[a]))
    return loops


def _spaced(line: NDArray[np.float64]) -> NDArray[np.float64]:
    """The closed line's points at equal distances (`_POINTS`, 3)."""
    closed = np.vstack([line, line[:1]])
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))])
    at = np.linspace(0.0, along[-1], _POINTS, endpoint=False)
    return np.column_stack([np.interp(at, along, closed[:, k]) for k in range(3)])
