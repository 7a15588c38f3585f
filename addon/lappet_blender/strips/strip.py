"""What a strip is: an event as a bar from the frame at which it begins to the frame at which it has ended.

Knows neither Blender's windows nor its scenes: times are frames, places are pixels of a region.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum

# The lanes from top to bottom: what cuts, what pulls, what sews.
LANES = (("INCISION", "EXCISION", "UNDERMINE", "THIN"), ("HOOK", "RETRACTOR"), ("SUTURE", "SUTURE_RUN"))
_ENDING = frozenset({*LANES[1], *LANES[2]})


class Part(StrEnum):
    """What the mouse takes hold of."""

    BODY = "BODY"
    START = "START"
    END = "END"
    STEP = "STEP"


@dataclass(frozen=True)
class Strip:
    """An event on the timeline.

    uid: the event's. start, end: frames; what happens at once ends when it begins. enabled: whether it takes place.
    """

    uid: str
    name: str
    kind: str
    start: float
    end: float
    enabled: bool = True
    selected: bool = False
    active: bool = False

    @property
    def lane(self) -> int:
        """The lane of its kind, from the top."""
        return next(index for index, kinds in enumerate(LANES) if self.kind in kinds)

    @property
    def has_end(self) -> bool:
        """Whether its end can be dragged: cuts happen at once."""
        return self.kind in _ENDING


@dataclass(frozen=True)
class Step:
    """A step of the operation: from a marker to the next one.

    start: the marker's frame; end: that of the next marker, or the end of the scene.
    """

    name: str
    start: float
    end: float

    def holds(self, strip: Strip) -> bool:
        """Whether a strip belongs to it: it begins in it."""
        return self.start <= strip.start < self.end


def steps_of(markers: Iterable[tuple[str, float]], end: float) -> tuple[Step, ...]:
    """The steps that markers (name, frame) begin, in order of time; the last lasts until after the frame `end`.

    Of markers on one frame the first in order of names counts.
    """
    ordered = sorted(markers, key=lambda each: (each[1], each[0]))
    first = [each for index, each in enumerate(ordered) if index == 0 or each[1] > ordered[index - 1][1]]
    if not first:
        return ()
    ends = [frame for _, frame in first[1:]] + [max(end, first[-1][1]) + 1.0]
    return tuple(Step(name, frame, until) for (name, frame), until in zip(first, ends, strict=True))


def strips_of_step(step: Step, strips: Sequence[Strip]) -> list[str]:
    """The uids of the strips that begin in a step."""
    return [strip.uid for strip in strips if step.holds(strip)]
