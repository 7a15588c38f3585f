"""The parts of what is fixed, each with a name: reactions are told by them.

A face subset all of whose faces are fixed is a part under its own name. What else is fixed falls apart into what hangs
together.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.connected_parts import parts_of
from lappet.geometry.labeled_surface import Surface
from lappet.procedure import Tissue
from lappet.tissue.fan_triangles import fan_triangles
from lappet.tissue.surface import LABELS


@dataclass(frozen=True, eq=False)
class FixedParts:
    """The parts of the fixed faces of a tissue.

    Parameters
    ----------
    names
        Their names: those of the subsets in their order, then "fixed", or "fixed 1" and so on where there are several.
    points
        Vertices of the tissue in mm, shape (n, 3).
    triangles
        Triangles of the fixed faces, shape (t, 3).
    part
        Which part each is of, shape (t,).
    """

    names: tuple[str, ...]
    points: NDArray[np.float64]
    triangles: NDArray[np.int32]
    part: NDArray[np.int32]

    @classmethod
    def of(cls, tissue: Tissue) -> FixedParts:
        """Find the parts of a tissue's fixed faces.

        Parameters
        ----------
        tissue
            The tissue.

        Returns
        -------
        FixedParts
            The parts; none where nothing is fixed.
        """
        fixed = np.asarray(tissue.subsets.get("fixed", ()), np.int64)
        triangles, face = fan_triangles(tissue)
        triangles, face = triangles[np.isin(face, fixed)], face[np.isin(face, fixed)]
        part = np.full(len(triangles), -1, np.int32)
        names: list[str] = []
        for name, faces in tissue.subsets.items():
            own = np.isin(face, faces) & (part < 0)
            if name not in LABELS and len(faces) and np.isin(faces, fixed).all() and own.any():
                part[own] = len(names)
                names.append(name)
        rest = part < 0
        if rest.any():
            connected = parts_of(triangles[rest].astype(np.int64), len(tissue.points))
            part[rest] = len(names) + connected
            count = int(connected.max()) + 1
            names += ["fixed"] if count == 1 else [f"fixed {k + 1}" for k in range(count)]
        return cls(tuple(names), np.asarray(tissue.points, np.float64), triangles, part)

    def on(self, surface: Surface) -> NDArray[np.int32]:
        """Find the part of each triangle of a cut surface.

        Parameters
        ----------
        surface
            The surface.

        Returns
        -------
        NDArray[np.int32]
            The parts, -1 where a triangle is not fixed, shape (m,); without entries where there is one part at most.
        """
        if len(self.names) < 2:
            return np.zeros(0, np.int32)
        found = np.full(len(surface.triangles), -1, np.int32)
        middles = surface.points[surface.triangles[surface.fixed]].mean(axis=1)
        nearest, _, _ = ClosestPoint(self.points, self.triangles).query(middles)
        found[surface.fixed] = self.part[nearest]
        return found
