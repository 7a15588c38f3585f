"""How a point of the tissue comes to lie on the paper of a panel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.drawing.framing import Viewpoint


@dataclass(frozen=True, eq=False)
class Projection:
    """A perspective from tissue to a panel, whose origin is the panel's middle, x to the right and y downwards.

    Parameters
    ----------
    viewpoint
        The camera.
    size
        Width and height of the panel in mm on paper.
    half_width
        Tangent of half the horizontal field of view.
    """

    viewpoint: Viewpoint
    size: tuple[float, float]
    half_width: float

    @property
    def scale(self) -> float:
        """Millimetres on paper per millimetre of tissue at the distance of the field's middle."""
        return 0.5 * self.size[0] / (self.half_width * self.viewpoint.distance)

    def paper(self, points: NDArray[np.floating]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Project points.

        Parameters
        ----------
        points
            Points of the tissue in mm, shape (n, 3).

        Returns
        -------
        tuple[NDArray[np.float64], NDArray[np.float64]]
            Where they lie on the paper in mm, shape (n, 2), and their depths before the camera in mm, shape (n,).
        """
        seen = (np.asarray(points, np.float64) - self.viewpoint.position) @ self.viewpoint.axes.T
        depth = -seen[:, 2]
        # What lies behind the camera is put far to its side.
        ahead = np.maximum(depth, 1e-3 * self.viewpoint.distance)
        factor = 0.5 * self.size[0] / self.half_width / ahead
        return np.stack([seen[:, 0] * factor, -seen[:, 1] * factor], axis=1), ahead
