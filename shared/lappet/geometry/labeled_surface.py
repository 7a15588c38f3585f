"""A closed triangle surface with labels: what its faces are, which of them are held, gripped or attached."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray


class FaceOrigin(IntEnum):
    """Where a surface triangle comes from."""

    SKIN = 0
    WOUND_WALL = 1
    UNDERSIDE = 2
    RIM = 3


LINING = "lining"  # among the grips: the underside that lies on free inner skin and not on deep tissue


@dataclass(frozen=True, eq=False)
class Surface:
    """A closed, manifold triangle surface at rest, with labels.

    Parameters
    ----------
    points
        Vertices in mm, shape (n, 3), float64.
    triangles
        Vertex indices, oriented outwards, shape (m, 3), int32.
    uv
        Texture coordinates of the triangles' corners, shape (m, 3, 2), float32.
    origin
        A `FaceOrigin` for each triangle, shape (m,), uint8.
    fixed
        Which triangles are held in space, shape (m,), bool.
    bed
        Which triangles are attached to the bed, shape (m,), bool.
    grips
        Which triangles a retractor grips, by subset name, each of shape (m,), bool.
    """

    points: NDArray[np.float64]
    triangles: NDArray[np.int32]
    uv: NDArray[np.float32]
    origin: NDArray[np.uint8]
    fixed: NDArray[np.bool_]
    bed: NDArray[np.bool_]
    grips: dict[str, NDArray[np.bool_]] = field(default_factory=dict)

    @property
    def resting(self) -> NDArray[np.bool_]:
        """Underside faces that lie on the bed without being attached, shape (m,).

        They can lift and slide, but not sink below their original plane.
        """
        return (self.origin == FaceOrigin.UNDERSIDE) & ~self.bed & ~self.fixed

    def of_faces(
        self,
        faces: NDArray[Any],
        points: NDArray[np.float64],
        triangles: NDArray[np.integer],
        uv: NDArray[np.floating],
    ) -> Surface:
        """Make a surface of other triangles, each labeled as one of these.

        Parameters
        ----------
        faces
            Which triangle each new one comes from, shape (k,), or which triangles stay, shape (m,), bool.
        points
            Its vertices in mm, shape (n, 3).
        triangles
            Its vertex indices, shape (k, 3).
        uv
            Its texture coordinates, shape (k, 3, 2).

        Returns
        -------
        Surface
            The surface.
        """
        return Surface(
            points=points,
            triangles=triangles.astype(np.int32),
            uv=uv.astype(np.float32),
            origin=self.origin[faces],
            fixed=self.fixed[faces],
            bed=self.bed[faces],
            grips={name: mask[faces] for name, mask in self.grips.items()},
        )
