"""Vessels and nerves as tubes; where one is cut its stump stands out of the wound's wall and shows its lumen."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.drawing.skin_source import SkinSource

STUMP = 0.35  # mm, how far a cut end stands out
LUMEN = 0.55  # of the radius
_DEEP = 0.1  # mm
HOLLOW = ("artery", "vein", "lymphatic")
Tubes = tuple[list[NDArray[np.float64]], list[float]]


class VesselTubes:
    """The vessels of one kind; `lumen`: not they but the openings of their cut ends.

    `source` may be changed for one of equal epochs.
    """

    def __init__(self, source: SkinSource, kind: str, lumen: bool = False) -> None:
        self.source, self._kind, self._lumen = source, kind, lumen

    def tubes(self, time: float) -> Tubes:
        """The lines (k, 3) of a frame and their radii, mm."""
        lines: list[NDArray[np.float64]] = []
        radii: list[float] = []
        for line in self.source.vessels(time):
            if line.kind != self._kind and not (self._lumen and line.kind in HOLLOW):
                continue
            ends = [stump(line.points, at_end) for at_end, cut in zip((False, True), line.divided, strict=True) if cut]
            if self._lumen:
                lines += [np.stack([end - _DEEP * way, end + 0.02 * way]) for end, way in ends]
                radii += [LUMEN * line.radius] * len(ends)
                continue
            before = [stump(line.points, False)[0][None]] if line.divided[0] else []
            after = [stump(line.points, True)[0][None]] if line.divided[1] else []
            lines.append(np.concatenate([*before, line.points, *after]))
            radii.append(line.radius)
        return lines, radii


def stump(points: NDArray[np.float64], at_end: bool) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Where the stump of a cut end of a line (k, 3) ends, and the direction in which it points: (3,) each."""
    tip, behind = (points[-1], points[-2]) if at_end else (points[0], points[1])
    way = tip - behind
    way = way / max(float(np.linalg.norm(way)), 1e-12)
    return tip + STUMP * way, way
