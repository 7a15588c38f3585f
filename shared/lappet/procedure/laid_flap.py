"""A design of the flap library as it was laid: where, how turned, with which measures, and which events it made.

The events act; this only remembers what they were made of, so that the design can be moved or changed later.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from lappet.procedure.exact_values import Point, double_point, set_fields

FlapLines = Literal["", "along", "across"]


@dataclass(frozen=True)
class LaidFlap:
    """A design of the flap library on the skin of a procedure (`LappetFlapAPI`).

    Parameters
    ----------
    name
        Its name, unique among the laid flaps.
    design
        Name of the design in the library.
    at
        Where it lies in mm; the design says what of it.
    direction
        Its direction along the skin.
    measures
        The measures of the design, pairs of name and value.
    mirrored
        Whether it is mirrored about its direction.
    start
        Time code before the first cut.
    lines
        How the direction follows the lines of the skin when the flap is moved: "along", "across", or "" where it does
        not.
    events
        Names of the events that it made.
    """

    name: str
    design: str
    at: Point
    direction: Point
    measures: tuple[tuple[str, float], ...] = ()
    mirrored: bool = False
    start: float = 1.0
    lines: FlapLines = ""
    events: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        measures = tuple((str(name), float(value) + 0.0) for name, value in self.measures)
        set_fields(
            self,
            at=double_point(self.at),
            direction=double_point(self.direction),
            measures=measures,
            start=float(self.start),
            events=tuple(self.events),
        )
