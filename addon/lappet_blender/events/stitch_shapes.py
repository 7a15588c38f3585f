"""The shapes that a suture may have, and the stitches of each between two edges of a wound."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.procedure import stitches
from lappet.procedure.stitches import Station, Stitch

from .add_events import point_value

SHAPES = (
    ("POINTS", "Two Points", "It holds one point of each edge"),
    ("SIMPLE", "Simple", "A loop across the wound in the tissue and back over it"),
    ("RUNNING", "Running", "One thread through all places, which slides"),
    ("VERTICAL_MATTRESS", "Vertical Mattress", "Far-far-near-near: the edges turn out"),
    ("HORIZONTAL_MATTRESS", "Horizontal Mattress", "Across, along the edge and back: the edges turn out"),
    ("HALF_BURIED", "Half-Buried Mattress", "On the second edge it stays in the tissue, as in the tip of a flap"),
    ("DEEP_DERMAL", "Deep Dermal", "Buried, tied below"),
    ("FIGURE_OF_EIGHT", "Figure of Eight", "Two passes whose threads cross above the wound"),
)
DEPTH = 2.0  # mm, where none is given; chosen
DRAWN = 0.9  # of the length at which the edges just meet: soft skin gives way at the bites


@dataclass(frozen=True)
class Shape:
    """What stitches are made.

    kind: one of `SHAPES`. bite: from the wound's edge, mm; 0 = as is usual. depth: mm; 0 = `DEPTH`. drawn: share of the
    length at which the edges just meet.
    """

    kind: str = "POINTS"
    bite: float = 0.0
    depth: float = 0.0
    drawn: float = DRAWN

    @property
    def is_loop(self) -> bool:
        """Whether it has more than a point on each edge."""
        return self.kind != "POINTS"

    def stitches(self, stations: Sequence[Station]) -> list[Stitch]:
        """Return the stitches at some places; a running suture is one through all."""
        depth = self.depth or DEPTH
        if self.kind == "RUNNING":
            return [stitches.running(stations, self.bite or stitches.BITE, depth)]
        return [self._stitch(at, depth) for at in stations]

    def _stitch(self, at: Station, depth: float) -> Stitch:
        match self.kind:
            case "VERTICAL_MATTRESS":
                return stitches.vertical_mattress(at, depth, self.bite or stitches.FAR)
            case "HORIZONTAL_MATTRESS":
                return stitches.horizontal_mattress(at, depth, self.bite or stitches.MATTRESS)
            case "HALF_BURIED":
                return stitches.half_buried_mattress(at, depth, self.bite or stitches.MATTRESS)
            case "DEEP_DERMAL":
                return stitches.deep_dermal(at, depth, bite=self.bite or stitches.BITE)
            case "FIGURE_OF_EIGHT":
                return stitches.figure_of_eight(at, depth, self.bite or stitches.BITE)
        return stitches.simple(at, self.bite or stitches.BITE, depth)


def stations_between(
    first: NDArray[np.float64], second: NDArray[np.float64], outward: NDArray[np.float64]
) -> list[Station]:
    """Return the places between points of two edges (k, 3) at rest, mm. outward: normals of the skin there (k, 3)."""
    return [
        Station(point_value(0.5 * (a + b)), point_value(b - a), point_value(up), float(np.linalg.norm(b - a)))
        for a, b, up in zip(first, second, outward, strict=True)
    ]
