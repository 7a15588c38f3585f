"""Which part of the body a model is: what of its skin lies in an ellipsoid of the neutral body."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lappet.procedure import Point

_X, _Y, _Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Ellipsoid:
    """An ellipsoid.

    Parameters
    ----------
    center
        Its center in mm, on the skin or near it.
    radii
        Its half axes in mm.
    first
        Direction of the first half axis, of any length.
    second
        Direction near that of the second, of any length.
    """

    center: Point
    radii: Point
    first: Point = _X
    second: Point = _Y

    def reaching(self, times: float) -> Ellipsoid:
        """Make one whose half axes are longer.

        Parameters
        ----------
        times
            How many times as long.

        Returns
        -------
        Ellipsoid
            It has the same center and directions.
        """
        x, y, z = self.radii
        return replace(self, radii=(times * x, times * y, times * z))

    @property
    def axes(self) -> NDArray[np.float64]:
        """The unit vectors of the half axes as rows, shape (3, 3)."""
        a = np.array(self.first) / np.linalg.norm(self.first)
        c = np.cross(a, self.second)
        c /= np.linalg.norm(c)
        return np.stack([a, np.cross(c, a), c])

    def level(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Measure about how far points are outside.

        Parameters
        ----------
        points
            Points in mm as the first three columns, shape (k, 3 or more).

        Returns
        -------
        NDArray[np.float64]
            Negative inside; in mm near the border along the least half axis, shape (k,).
        """
        local = (points[:, :3] - np.array(self.center)) @ self.axes.T / np.array(self.radii)
        return np.asarray((np.linalg.norm(local, axis=1) - 1.0) * min(self.radii))
