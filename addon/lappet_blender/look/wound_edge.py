"""The edge of the wound as fine dark red lines, so that a closed wound still reads."""

from __future__ import annotations

import bpy
import numpy as np

from .skin_fields import border_chains
from .skin_read import SkinCache
from .tube import add_tubes, remove_tubes

EDGE_RADIUS = 0.1


class WoundEdge:
    """The lines along the lips of the wound; they follow the skin."""

    def __init__(self, cache: SkinCache, material: bpy.types.Material) -> None:
        self._cache, self._material = cache, material
        self._chains = {e.name: border_chains(e.triangles, e.origin) for e in cache.epochs}
        self._object: bpy.types.Object | None = None

    def show(self, time: float) -> None:
        """Draw the lines of a frame and no others."""
        remove_tubes(self._object)
        epoch = self._cache.epoch_at(time)
        points = self._cache.positions(epoch, time).astype(np.float64)
        lines = [points[chain] for chain in self._chains[epoch.name]]
        self._object = add_tubes("Wound edge", lines, [EDGE_RADIUS] * len(lines), self._material, 1) if lines else None
