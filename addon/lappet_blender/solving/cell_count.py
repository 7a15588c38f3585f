"""About how many cells the lattice of a tissue will have, from its surface: before the solver has counted them."""

from __future__ import annotations

import numpy as np

from lappet.checks.lattice_size import TissueMeasure
from lappet.procedure import Tissue

_measured: tuple[Tissue, float] | None = None


def cell_count(tissue: Tissue) -> float:
    """The cells, 0 for a mesh without any volume; measured once for the same object."""
    global _measured
    if _measured is None or _measured[0] is not tissue:
        _measured = (tissue, _measure(tissue))
    return _measured[1]


def _measure(tissue: Tissue) -> float:
    counts, index = tissue.face_vertex_counts, tissue.face_vertex_indices
    if len(counts) == 0 or len(tissue.points) == 0 or tissue.spacing <= 0.0:
        return 0.0
    first = np.cumsum(counts) - counts
    fans = []
    for corner in range(1, int(counts.max()) - 1):
        at = first[counts > corner + 1]
        fans.append(np.stack([index[at], index[at + corner], index[at + corner + 1]], axis=1))
    return TissueMeasure(tissue.points, np.concatenate(fans)).lattice(tissue.spacing).cells
