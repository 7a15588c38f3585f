"""The edge of the wound as fine dark red lines, so that a closed wound still reads; and planned incisions in ink."""

from __future__ import annotations

import bpy
import numpy as np

from .skin_fields import WOUND_WALL, border_chains
from .skin_read import SkinCache
from .suture_path import Bite, nearest_bite
from .tube import add_tubes, remove_tubes

EDGE_RADIUS = 0.13
INK_RADIUS = 0.26
INK_STEP = 0.8


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


class PlannedIncision:
    """The incisions of the procedure as a surgeon marks them, shown while the skin is still whole."""

    def __init__(self, cache: SkinCache, material: bpy.types.Material) -> None:
        self._cache, self._material = cache, material
        self._object: bpy.types.Object | None = None
        first = cache.epochs[0]
        self._courses: list[list[Bite]] = []
        if (first.origin == WOUND_WALL).any() or not first.frames:
            return
        rest = cache.positions(first, first.frames[0])
        for line in cache.planned_incisions(INK_STEP):
            course = [nearest_bite(rest, first.triangles, first.origin, point) for point in line]
            self._courses.append(course)

    def show(self, time: float) -> None:
        """Draw the marks where the frame belongs to the first epoch; remove them otherwise."""
        remove_tubes(self._object)
        self._object = None
        epoch = self._cache.epoch_at(time)
        if epoch is not self._cache.epochs[0] or not self._courses:
            return
        points = self._cache.positions(epoch, time)
        lines = [np.array([bite.carried(points) for bite in course]) for course in self._courses]
        self._object = add_tubes("Planned incisions", lines, [INK_RADIUS] * len(lines), self._material, 2)
