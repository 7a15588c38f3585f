"""Holes of the skin: eyes, nostrils, a mouth. A design that lies across one cannot be cut, or its flap not carried.

Where skin ends, the edges of its triangles make closed lines. The longest is the rim of the tissue; each other one is
the edge of a hole. A hole that is only a slit, as between closed lips, is stepped over by a line that is walked in
steps; the way around it along the skin is longer, and that is how it is found.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.connected_labels import connected_labels
from lappet.geometry.geodesic_distance import geodesic_distance
from lappet.geometry.triangulation import triangulate
from lappet.procedure import Point, Tissue
from lappet.tissue.surface import skin_faces

_LONGER = 0.12  # share by which the way along the skin to a point of the design is longer, if a hole lies between
_CLOSE = 1.0  # mm from a hole's edge: there a line ends at the hole


@dataclass(frozen=True)
class Hole:
    """A hole of the skin.

    Parameters
    ----------
    middle
        The middle of its edge in mm.
    size
        Greatest extent of its edge along an axis in mm.
    """

    middle: Point
    size: float


class SkinHoles:
    """The holes of a tissue's skin.

    Parameters
    ----------
    tissue
        The tissue.
    """

    def __init__(self, tissue: Tissue) -> None:
        counts, indices = tissue.face_vertex_counts.astype(np.int64), tissue.face_vertex_indices.astype(np.int64)
        triangles, _, faces = triangulate(tissue.points, counts, indices)
        self._points, self._triangles = tissue.points, triangles[skin_faces(tissue)[faces]]
        edges = np.sort(np.vstack([self._triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])]), axis=1)
        unique, uses = np.unique(edges, axis=0, return_counts=True)
        ends = unique[uses == 1]
        label = connected_labels(len(self._points), ends)[ends[:, 0]] if len(ends) else np.zeros(0, np.int64)
        lengths = np.linalg.norm(self._points[ends[:, 1]] - self._points[ends[:, 0]], axis=1)
        names, which = np.unique(label, return_inverse=True)
        rim = int(np.bincount(which, lengths).argmax()) if len(names) else -1
        self._edges = {k: ends[which == k] for k in range(len(names)) if k != rim}

    def __bool__(self) -> bool:
        return bool(self._edges)

    def at(self, place: Point) -> Hole | None:
        """Find the hole at whose edge a place lies.

        Parameters
        ----------
        place
            The place in mm.

        Returns
        -------
        Hole | None
            The hole; None where none is within a millimeter.
        """
        near = [(self._distance(edges, place), k) for k, edges in self._edges.items()]
        if not near or min(near)[0] > _CLOSE:
            return None
        return self._hole(min(near)[1])

    def border_near(
        self, place: Point, within: float, least: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
        """Find the border of the nearest hole.

        Parameters
        ----------
        place
            A place in mm.
        within
            How far from it the border may be in mm.
        least
            How large the hole is in mm, at least.

        Returns
        -------
        tuple[NDArray[np.float64], NDArray[np.float64]] | None
            The border's points in order in mm, and vectors from them into the skin, each of shape (n, 3); None where no
            such hole is so near.
        """
        near = [(self._distance(edges, place), k) for k, edges in self._edges.items() if self._hole(k).size >= least]
        if not near or min(near)[0] > within:
            return None
        beside: dict[int, list[int]] = {}
        for a, b in self._edges[min(near)[1]].tolist():
            beside.setdefault(a, []).append(b)
            beside.setdefault(b, []).append(a)
        order = [next(iter(beside))]
        while len(order) < len(beside):
            ahead = [each for each in beside[order[-1]] if each not in order[-2:] and each != order[0]]
            if not ahead:
                return None  # it touches itself
            order.append(ahead[0])
        middles = self._points[self._triangles].mean(axis=1)
        around = [middles[(self._triangles == vertex).any(axis=1)].mean(axis=0) for vertex in order]
        return self._points[order], np.array(around) - self._points[order]

    def crossed(
        self, middle: NDArray[np.float64], points: NDArray[np.float64], away: NDArray[np.float64]
    ) -> Hole | None:
        """Find a hole that lies between the middle of a design and a point of it.

        Parameters
        ----------
        middle
            The middle in mm, shape (3,).
        points
            Points of the design on the skin in mm, shape (k, 3).
        away
            Lengths of the lines from the middle on which these lie, in mm, shape (k,).

        Returns
        -------
        Hole | None
            The hole nearest to the way to the worst point; None where no way along the skin is much longer.
        """
        if not self._edges or not len(points):
            return None
        far = geodesic_distance(self._points, self._triangles, middle, 1.5 * float(away.max()) + 10.0)
        which, closest, _ = ClosestPoint(self._points, self._triangles).query(points)
        corners = self._points[self._triangles[which]]
        # From the nearest corner on, straight: an upper bound that is loose by the size of a triangle at most.
        ways = far[self._triangles[which]] + np.linalg.norm(corners - closest[:, None], axis=2)
        size = np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1)
        longer = ways.min(axis=1) - (1.0 + _LONGER) * away - size
        worst = int(longer.argmax())
        if not longer[worst] > 0.0:
            return None
        halfway = 0.5 * (points[worst] + middle)
        return self._hole(min((self._distance(edges, halfway), k) for k, edges in self._edges.items())[1])

    def _distance(self, edges: NDArray[np.int64], place: Point | NDArray[np.float64]) -> float:
        return float(ClosestPoint(self._points, edges[:, [0, 1, 1]]).query(np.array([place], np.float64))[2][0])

    def _hole(self, k: int) -> Hole:
        points = self._points[np.unique(self._edges[k])]
        x, y, z = (0.5 * (points.min(axis=0) + points.max(axis=0))).tolist()
        return Hole((x, y, z), float(np.ptp(points, axis=0).max()))
