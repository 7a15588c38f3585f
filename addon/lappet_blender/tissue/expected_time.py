"""How many cells the lattice of a scene will have and how long a solve will take."""

from __future__ import annotations

import bpy

from ..model import tissue_size
from ..model.tissue_values import tissue_value
from ..solving.speed_estimate import speed_estimate

# Of the Z-plasty in README.md: 11 s for 32 160 cells and 40 frames; until this machine has solved something itself.
_SECONDS_PER_CELL = 11.0 / (32_160 * 40)


def cell_count(scene: bpy.types.Scene) -> float | None:
    """Return about how many cells the lattice will have, or None where there is no tissue to be read."""
    tissue, _ = tissue_value(scene)
    return None if tissue is None else tissue_size.cell_count(tissue)


def expected_seconds(scene: bpy.types.Scene) -> float | None:
    """Return about how long all frames will take, or None where there is no tissue to be read."""
    cells = cell_count(scene)
    if cells is None:
        return None
    per_frame = speed_estimate().seconds(cells)
    if per_frame is None:
        per_frame = _SECONDS_PER_CELL * cells
    return per_frame * (scene.frame_end - scene.frame_start + 1)
