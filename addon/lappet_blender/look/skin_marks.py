"""What a surgeon draws on the skin with the marking pen: planned incisions, and the area to undermine, dashed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .dashed_line import dashes
from .skin_fields import SKIN
from .skin_source import SkinSource
from .suture_bites import Bite, bites_at, carried

INCISION_RADIUS = 0.24
UNDERMINE_RADIUS = 0.16
STEP = 0.8
HELD = ("Hook", "Retractor", "Suture")


class SkinMarks:
    """The pen marks; they ride on the skin."""

    def __init__(self, source: SkinSource) -> None:
        """Incisions are marked while the skin is whole; undermining from its event until hooks or sutures act."""
        self._source = source
        self._incisions = source.planned_incisions(STEP)
        self._dashes = [dash for area in source.undermined_areas(STEP / 2) for dash in dashes(area)]
        undermined = [e.start for e in source.events if e.kind == "Undermine"]
        held = [e.start for e in source.events if e.kind in HELD]
        self._cut = min((e.start for e in source.events if e.kind == "Incision"), default=np.inf)
        self._from, self._until = min(undermined, default=np.inf), min(held, default=np.inf)
        self._courses: dict[str, list[Bite]] = {}

    def knows(self, time: float) -> bool:
        """Whether where the marks of a frame ride was found before, or there are none."""
        which, lines, _ = self._which(time)
        return not lines or self._key(which, time) in self._courses

    def tubes(self, time: float) -> tuple[list[NDArray[np.float64]], list[float]]:
        """The marks (k, 3) of a frame and their radii, mm."""
        which, lines, radius = self._which(time)
        return self._drawn(time, which, lines, radius) if lines else ([], [])

    def _which(self, time: float) -> tuple[str, list[NDArray[np.float64]], float]:
        whole = self._source.epoch_at(time) is self._source.epochs[0]
        if whole and time < self._cut and self._incisions:
            return "incisions", self._incisions, INCISION_RADIUS
        if self._from <= time < self._until and self._dashes:
            return "undermining", self._dashes, UNDERMINE_RADIUS
        return "", [], 0.0

    def _key(self, name: str, time: float) -> str:
        return f"{name} {self._source.epoch_at(time).name}"

    def _drawn(
        self, time: float, name: str, lines: list[NDArray[np.float64]], radius: float
    ) -> tuple[list[NDArray[np.float64]], list[float]]:
        epoch = self._source.epoch_at(time)
        key = self._key(name, time)
        if key not in self._courses:
            first = self._source.rest(epoch)
            self._courses[key] = bites_at(first, epoch.triangles[epoch.origin == SKIN], np.concatenate(lines))
        placed = carried(self._courses[key], self._source.positions(epoch, time))
        return np.split(placed, np.cumsum([len(line) for line in lines])[:-1]), [radius] * len(lines)
