"""Where points are relative to the tissue at rest: how far off it, or inside it."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.geometry.closest_point import ClosestPoint

OFF_TISSUE = 0.01  # how far off the tissue an anchor may be, as a fraction of the tissue's diagonal


class RestSpace:
    """A closed triangle surface at rest, which tells how far points are off it.

    Parameters
    ----------
    points
        Vertices in mm, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).
    """

    def __init__(self, points: NDArray[np.float64], triangles: NDArray[np.integer]) -> None:
        self._closest = ClosestPoint(points, triangles)
        self._corners = points[triangles]
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

    def off(self, points: ArrayLike) -> NDArray[np.float64]:
        """Measure how far points are outside the tissue.

        Parameters
        ----------
        points
            Points in mm, shape (q, 3).

        Returns
        -------
        NDArray[np.float64]
            Distances in mm, shape (q,); 0 for points inside or within the margin.
        """
        queries = np.asarray(points, np.float64).reshape(-1, 3)
        distance = self.distance(queries)
        distance[distance <= self.margin] = 0.0
        for i in np.flatnonzero(distance > 0.0):
            if abs(self._winding(queries[i])) > 0.5:
                distance[i] = 0.0
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
        if (self.distance(points) <= self.margin).any():
            return 0.0
        return float(self.off(points).min(initial=np.inf))

    def _winding(self, query: NDArray[np.float64]) -> float:
        """The winding number of the surface about a point: the solid angles over 4π (Van Oosterom, Strackee 1983)."""
        a, b, c = (self._corners[:, k] - query for k in range(3))
        la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
        numerator = np.einsum("ij,ij->i", a, np.cross(b, c))
        dots = [np.einsum("ij,ij->i", u, v) for u, v in ((a, b), (b, c), (c, a))]
        denominator = la * lb * lc + dots[0] * lc + dots[1] * la + dots[2] * lb
        return float(np.arctan2(numerator, denominator).sum() / (2.0 * np.pi))
