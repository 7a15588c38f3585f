"""How large a tissue is: its surface as triangles, and how many cells its lattice will have."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.checks.lattice_size import TissueMeasure
from lappet.geometry.triangulation import triangulate
from lappet.procedure import Tissue

_MAX_KEPT = 8


@dataclass(frozen=True, eq=False)
class TissueSize:
    """points: (n, 3) mm. triangles: (m, 3). measure: of them."""

    points: NDArray[np.float64]
    triangles: NDArray[np.int64]
    measure: TissueMeasure


_kept: list[TissueSize] = []


def tissue_size(tissue: Tissue) -> TissueSize:
    """Return the surface of a tissue and its measure; kept for the surfaces that were asked for last."""
    global _kept
    known = _kept  # replaced whole: a thread asks too
    for each in known:
        if each.points is tissue.points or np.array_equal(each.points, tissue.points):
            _kept = [each, *(other for other in known if other is not each)]
            return each
    counts, indices = tissue.face_vertex_counts.astype(np.int64), tissue.face_vertex_indices.astype(np.int64)
    triangles, _, _ = triangulate(tissue.points, counts, indices)
    found = TissueSize(tissue.points, triangles, TissueMeasure(tissue.points, triangles))
    _kept = [found, *_kept][:_MAX_KEPT]
    return found


def cell_count(tissue: Tissue) -> float:
    """Return about how many cells the lattice will have, 0 for a mesh without a face."""
    if len(tissue.face_vertex_counts) == 0 or len(tissue.points) == 0 or tissue.spacing <= 0.0:
        return 0.0
    return float(tissue_size(tissue).measure.lattice(tissue.spacing).cells)


def clear_cache() -> None:
    """Drop what is kept."""
    global _kept
    _kept = []
