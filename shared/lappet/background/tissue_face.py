"""The face of the tissue that each triangle of a cut surface lies on: material picked on cut skin is marked there."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.labeled_surface import FaceOrigin, Surface
from lappet.geometry.triangulation import triangulate
from lappet.procedure import Tissue


class TissueFaces:
    """A search for the nearest face of a tissue; the surfaces of its epochs lie on it but for their wound walls.

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
        self._closest = ClosestPoint(points, triangles)

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
        result[asked] = self.nearest(surface.points[surface.triangles[asked]].mean(axis=1))
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
        return self._face[self._closest.query(points)[0]].astype(np.int32)
