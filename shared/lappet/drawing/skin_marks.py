"""What a surgeon draws on the skin with the marking pen: planned incisions, and the area to undermine, dashed."""

from __future__ import annotations

from time import monotonic
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from lappet.drawing.dashed_line import dashes
from lappet.drawing.epoch_searches import EpochSearches
from lappet.drawing.skin_source import SkinEpoch, SkinSource
from lappet.drawing.suture_bites import Bite, carried

INCISION_RADIUS = 0.24
UNDERMINE_RADIUS = 0.16
STEP = 0.8
_AT_ONCE = 8  # places that are found between two looks at the clock
HELD = ("Hook", "Retractor", "Suture")


class SkinMarks:
    """The pen marks; they ride on the skin.

    until: the monotonic second at which `tubes` stops to find where they ride, None: it finds all; the rest is
    `unfinished`.

    Parameters
    ----------
    source
        The solved procedure.
    before
        Marks of the same epochs; where a line is still the same, where it rides is not searched again.
    searches
        What is known of its epochs; None: what `before` knows.
    """

    def __init__(
        self, source: SkinSource, before: SkinMarks | None = None, searches: EpochSearches | None = None
    ) -> None:
        self._source = source
        own = EpochSearches() if before is None else before._searches
        self._searches: EpochSearches = own if searches is None else searches
        self._incisions = source.planned_incisions(STEP)
        self._dashes = [dash for area in source.undermined_areas(STEP / 2) for dash in dashes(area)]
        undermined = [e.start for e in source.events if e.kind == "Undermine"]
        held = [e.start for e in source.events if e.kind in HELD]
        self._cut = min((e.start for e in source.events if e.kind == "Incision"), default=np.inf)
        self._from, self._until = min(undermined, default=np.inf), min(held, default=np.inf)
        self._courses: dict[str, list[Bite]] = (
            before._courses if before is not None and len(before._courses) < 32 else {}
        )
        self.until: float | None = None
        self.unfinished = False

    def tubes(self, time: float) -> tuple[list[NDArray[np.float64]], list[float]]:
        """Draw the marks of a frame.

        Parameters
        ----------
        time
            Time code of the frame.

        Returns
        -------
        tuple[list[NDArray[np.float64]], list[float]]
            Their courses in mm, each of shape (k, 3), and their radii in mm; none while where they ride is not all
            found.
        """
        self.unfinished = False
        lines, radius = self._which(time)
        return self._drawn(time, lines, radius) if lines else ([], [])

    def rides_on(self, epoch: SkinEpoch) -> bool:
        """Tell whether marks are drawn in an epoch.

        Parameters
        ----------
        epoch
            The epoch.

        Returns
        -------
        bool
            Whether a frame of it shows some.
        """
        return any(self._which(time)[0] for time in epoch.frames)

    def _which(self, time: float) -> tuple[list[NDArray[np.float64]], float]:
        whole = self._source.epoch_at(time) is self._source.epochs[0]
        if whole and time < self._cut and self._incisions:
            return self._incisions, INCISION_RADIUS
        if self._from <= time < self._until and self._dashes:
            return self._dashes, UNDERMINE_RADIUS
        return [], 0.0

    def _drawn(
        self, time: float, lines: list[NDArray[np.float64]], radius: float
    ) -> tuple[list[NDArray[np.float64]], list[float]]:
        epoch = self._source.epoch_at(time)
        places = np.concatenate(lines)
        course = self._find(f"{epoch.name} {crc32(places.tobytes())}", epoch, places)
        if self.unfinished:
            return [], []
        placed = carried(course, self._source.positions(epoch, time))
        return np.split(placed, np.cumsum([len(line) for line in lines])[:-1]), [radius] * len(lines)

    def _find(self, key: str, epoch: SkinEpoch, places: NDArray[np.float64]) -> list[Bite]:
        course = self._courses.setdefault(key, [])
        while len(course) < len(places):
            into = self._searches.bites(epoch, self._source.rest(epoch))
            course += into.at(places[len(course) : len(course) + _AT_ONCE])
            if self.until is not None and monotonic() > self.until:
                self.unfinished = len(course) < len(places)
                break
        return course
