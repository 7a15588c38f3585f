"""Where points are relative to the tissue at rest: how far outside it, if they are."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.inside import InsideTest

OFF_TISSUE = 0.01  # how far off the tissue a seed or a curve may be, as a fraction of the tissue's diagonal
ROUNDING = 1e-6  # as a fraction of the tissue's diagonal: what lies so near to its surface lies on it
_FEW = 4


class RestSpace:
    """A closed triangle surface at rest, which tells how far points are outside it.

    Parameters
    ----------
    points
        Vertices in mm, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).
    """

    def __init__(self, points: NDArray[np.float64], triangles: NDArray[np.integer]) -> None:
        self._closest = ClosestPoint(points, triangles)
        self._inside = InsideTest(points, triangles)
        self.diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
        self.margin = OFF_TISSUE * self.diagonal

    def distance(self, points: ArrayLike) -> NDArray[np.float64]:
        """Measure how far points are from the surface.

        Parameters
        ----------
        points
            Points in mm, shape (q, 3).

        Returns
        -------
        NDArray[np.float64]
            Distances in mm, shape (q,).
        """
        return self._closest.query(points)[2]

    def outside(self, points: ArrayLike) -> NDArray[np.float64]:
        """Measure how far points are outside the tissue.

        Parameters
        ----------
        points
            Points in mm, shape (q, 3).

        Returns
        -------
        NDArray[np.float64]
            Distances in mm, shape (q,); 0 for points inside or on the surface.
        """
        queries = np.asarray(points, np.float64).reshape(-1, 3)
        triangle, closest, distance = self._closest.query(queries)
        distance[distance <= ROUNDING * self.diagonal] = 0.0
        off = np.flatnonzero(distance > 0.0)
        inside = self._inside.contains(queries[off], triangle[off], closest[off])
        distance[off[inside]] = 0.0
        return distance

    def off(self, points: ArrayLike) -> NDArray[np.float64]:
        """Measure how far points are off the tissue, which they may miss by a margin.

        Parameters
        ----------
        points
            Points in mm, shape (q, 3).

        Returns
        -------
        NDArray[np.float64]
            Distances in mm, shape (q,); 0 for points inside or within the margin.
        """
        distance = self.outside(points)
        distance[distance <= self.margin] = 0.0
        return distance

    def nearest(self, points: ArrayLike) -> float:
        """Measure how far the nearest of some points is outside the tissue.

        Parameters
        ----------
        points
            Points in mm, shape (q, 3).

        Returns
        -------
        float
            Distance in mm; 0 where a point is inside or on the tissue.
        """
        every = np.asarray(points, np.float64).reshape(-1, 3)
        for some in (every[:_FEW], every[_FEW:]):  # most often the first one lies on the tissue
            if (self.distance(some) <= self.margin).any():
                return 0.0
        return float(self.off(every).min(initial=np.inf))
