"""How large the lattice of a tissue will be, from its surface alone: the cells and bytes that `check` names.

The daemon makes the same estimate of its rasterization before it allocates anything (memory_estimate.cpp in
solverd/src/lattice) and has the last word.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

BYTES_PER_CELL = 1024.0  # tangents, nodal vectors and preconditioner of the solver, about


@dataclass(frozen=True)
class LatticeSize:
    """The size of a lattice.

    Parameters
    ----------
    cells
        Number of lattice cells that hold tissue.
    bytes
        Memory at the peak, of rasterization and solver together.
    """

    cells: float
    bytes: float


class TissueMeasure:
    """Box, areas, volume and thickness of a closed surface.

    Parameters
    ----------
    points
        Vertices in mm, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).
    """

    def __init__(self, points: NDArray[np.float64], triangles: NDArray[np.integer]) -> None:
        low, high = points.min(axis=0), points.max(axis=0)
        self.size = high - low
        a, b, c = (points[triangles[:, k]] - 0.5 * (low + high) for k in range(3))
        self.projected_area = float(np.abs(np.cross(b - a, c - a)).sum() / 2.0)
        self.area = float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0)
        self.volume = abs(float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0))

    @property
    def thickness(self) -> float:
        """Mean thickness in mm, as of a sheet: twice the volume over the area."""
        return 2.0 * self.volume / self.area if self.area > 0.0 else 0.0

    def lattice(self, spacing: float, fine_ratio: int = 4) -> LatticeSize:
        """Estimate the size of a lattice.

        Parameters
        ----------
        spacing
            Lattice spacing in mm.
        fine_ratio
            Voxels per cell edge.

        Returns
        -------
        LatticeSize
            The size.
        """
        spacing = max(spacing, 1e-9 * float(self.size.max()))  # finer is as far out of reach, and powers stay finite
        extent = self.size / spacing + 1.0
        box = float(extent.prod())
        touched = min(box, 1.3 * self.projected_area / spacing**2)
        cells = min(box, self.volume / spacing**3 + 0.5 * self.projected_area / spacing**2)
        occupied = min(box, self.volume / spacing**3 + touched)
        crossings = self.projected_area * (fine_ratio / spacing) ** 2
        lines = box / float(extent.min()) * fine_ratio**2
        masks = fine_ratio**3 / 2.0 + 64.0
        rasterization = 4.0 * box + 8.0 * lines + 26.0 * crossings + masks * touched + 224.0 * occupied
        return LatticeSize(float(cells), float(rasterization + BYTES_PER_CELL * cells))

    def least_spacing(self, memory_budget: float, fine_ratio: int = 4) -> float:
        """Find the smallest spacing whose lattice fits a budget.

        Parameters
        ----------
        memory_budget
            The budget in bytes.
        fine_ratio
            Voxels per cell edge.

        Returns
        -------
        float
            Spacing in mm with two digits, rounded up.
        """
        spacing = float(self.size.max())
        while self.lattice(spacing / 1.02, fine_ratio).bytes <= memory_budget:
            spacing /= 1.02
        unit = 10.0 ** (np.floor(np.log10(spacing)) - 1.0)
        return float(np.ceil(spacing / unit - 1e-9) * unit)
