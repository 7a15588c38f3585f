"""The procedure: a tissue, its materials and the timeline of surgical events.

Everything here is immutable and compares by value; an edit makes a new `Procedure` (see `lappet.procedure.history`).
Units are mm, kPa, mN and seconds. Wrong values are accepted here and reported by `lappet.checks`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from lappet.procedure.events import Event
from lappet.procedure.storyboard import storyboard
from lappet.procedure.tissue import Bone, Material, Tissue


@dataclass(frozen=True, eq=False, repr=False)
class Procedure:
    """A tissue, its materials and the events of an operation; frames are the integer time codes.

    Events keep the order in which they are given (the order of the prims), whatever their times. `==` compares every
    value exactly; `repr` is a storyboard.
    """

    tissue: Tissue
    materials: tuple[Material, ...] = (Material(),)
    events: tuple[Event, ...] = ()
    bones: tuple[Bone, ...] = ()
    start_time: float = 1.0
    end_time: float = 1.0
    fps: float = 24.0

    def with_events(self, *events: Event) -> Procedure:
        """The same procedure with these events added."""
        return replace(self, events=(*self.events, *events))

    def event(self, name: str) -> Event:
        """The event of that name; KeyError if there is none."""
        for event in self.events:
            if event.name == name:
                return event
        raise KeyError(name)

    def material(self, name: str) -> Material:
        """The material of that name; KeyError if there is none."""
        for material in self.materials:
            if material.name == name:
                return material
        raise KeyError(name)

    def materials_in_use(self) -> tuple[Material, ...]:
        """The tissue's material, then those of its regions in their order, each once; names without one are left
        out."""
        names = dict.fromkeys([self.tissue.material, *(region.material for region in self.tissue.regions)])
        known = {material.name: material for material in reversed(self.materials)}
        return tuple(known[name] for name in names if name in known)

    def frames(self) -> range:
        """The frames: every whole time code from `start_time` to `end_time`, both included."""
        if not (math.isfinite(self.start_time) and math.isfinite(self.end_time)):
            return range(0)
        return range(math.ceil(self.start_time), math.floor(self.end_time) + 1)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Procedure):
            return NotImplemented
        return (
            (self.start_time, self.end_time, self.fps) == (other.start_time, other.end_time, other.fps)
            and self.events == other.events
            and self.materials == other.materials
            and self.bones == other.bones
            and self.tissue == other.tissue
        )

    def __hash__(self) -> int:
        return hash((self.tissue, self.materials, self.events, self.start_time, self.end_time))

    def __repr__(self) -> str:
        return storyboard(self)
