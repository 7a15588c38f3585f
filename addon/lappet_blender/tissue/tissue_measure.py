"""How large the lattice of a scene's tissue will be and how long a solve will take."""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np
from numpy.typing import NDArray

from lappet.checks.lattice_size import TissueMeasure
from lappet.geometry.triangulation import triangulate
from lappet.procedure import Tissue

from ..model.tissue_values import tissue_value
from ..solving.speed_estimate import speed_estimate

# Of the Z-plasty in README.md: 11 s for 32 160 cells and 40 frames; until this machine has solved something itself.
_SECONDS_PER_CELL = 11.0 / (32_160 * 40)


@dataclass(frozen=True, eq=False)
class _Kept:
    points: NDArray[np.float64]
    triangles: NDArray[np.int64]
    measure: TissueMeasure


_kept: dict[int, _Kept] = {}


def tissue_triangles(scene: bpy.types.Scene, tissue: Tissue) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """The tissue's surface, points (n, 3) mm and triangles (m, 3); kept while it is the same."""
    kept = _measured(scene, tissue)
    return kept.points, kept.triangles


def cell_count(scene: bpy.types.Scene) -> float | None:
    """About how many cells the lattice will have, or None where there is no tissue to be read."""
    tissue, _ = tissue_value(scene)
    if tissue is None:
        return None
    return _measured(scene, tissue).measure.lattice(tissue.spacing).cells


def expected_seconds(scene: bpy.types.Scene) -> float | None:
    """About how long all frames will take, or None where there is no tissue to be read."""
    cells = cell_count(scene)
    if cells is None:
        return None
    per_frame = speed_estimate().seconds(cells)
    if per_frame is None:
        per_frame = _SECONDS_PER_CELL * cells
    return per_frame * (scene.frame_end - scene.frame_start + 1)


def _measured(scene: bpy.types.Scene, tissue: Tissue) -> _Kept:
    kept = _kept.get(scene.session_uid)
    if kept is None or not _same(kept.points, tissue.points):
        counts, indices = tissue.face_vertex_counts.astype(np.int64), tissue.face_vertex_indices.astype(np.int64)
        triangles, _, _ = triangulate(tissue.points, counts, indices)
        kept = _Kept(tissue.points, triangles, TissueMeasure(tissue.points, triangles))
        _kept[scene.session_uid] = kept
    return kept


def _same(a: NDArray[np.float64], b: NDArray[np.float64]) -> bool:
    return a is b or (a.shape == b.shape and np.array_equal(a, b))


def forget() -> None:
    """Lets go of everything."""
    _kept.clear()
