"""What a surgeon draws on the skin with the marking pen: planned incisions, and the area to undermine, dashed."""

from __future__ import annotations

import bpy
import numpy as np
from numpy.typing import NDArray

from .dashed_line import dashes
from .skin_fields import SKIN
from .skin_read import SkinCache
from .suture_bites import Bite, bites_at
from .tube import add_tubes, remove_tubes

INCISION_RADIUS = 0.24
UNDERMINE_RADIUS = 0.16
STEP = 0.8
HELD = ("Hook", "Retractor", "Suture")


class SkinMarks:
    """The pen marks in the scene; they ride on the skin."""

    def __init__(self, cache: SkinCache, material: bpy.types.Material) -> None:
        """Incisions are marked while the skin is whole; undermining from its event until hooks or sutures act."""
        self._cache, self._material = cache, material
        self._incisions = cache.planned_incisions(STEP)
        self._dashes = [dash for area in cache.undermined_areas(STEP / 2) for dash in dashes(area)]
        undermined = [e.start for e in cache.events if e.kind == "Undermine"]
        held = [e.start for e in cache.events if e.kind in HELD]
        self._from, self._until = min(undermined, default=np.inf), min(held, default=np.inf)
        self._courses: dict[str, list[list[Bite]]] = {}
        self._object: bpy.types.Object | None = None

    def show(self, time: float) -> None:
        """Draw the marks of a frame and no others."""
        remove_tubes(self._object)
        self._object = None
        whole = self._cache.epoch_at(time) is self._cache.epochs[0]
        cut = min((e.start for e in self._cache.events if e.kind == "Incision"), default=np.inf)
        if whole and time < cut and self._incisions:
            self._draw(time, "incisions", self._incisions, INCISION_RADIUS)
        elif self._from <= time < self._until and self._dashes:
            self._draw(time, "undermining", self._dashes, UNDERMINE_RADIUS)

    def _draw(self, time: float, name: str, lines: list[NDArray[np.float64]], radius: float) -> None:
        epoch = self._cache.epoch_at(time)
        key = f"{name} {epoch.name}"
        if key not in self._courses:
            first = self._cache.positions(epoch, epoch.frames[0])
            found = iter(bites_at(first, epoch.triangles[epoch.origin == SKIN], np.concatenate(lines)))
            self._courses[key] = [[next(found) for _ in line] for line in lines]
        points = self._cache.positions(epoch, time)
        drawn = [np.array([bite.carried(points) for bite in course]) for course in self._courses[key]]
        self._object = add_tubes("Marks", drawn, [radius] * len(drawn), self._material, 1)
