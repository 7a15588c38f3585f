"""The procedure: a tissue, its materials and the timeline of surgical events.

Everything here is immutable and compares by value; an edit makes a new `Procedure` (see `lappet.procedure.history`).
Units are mm, kPa, mN and seconds. Wrong values are accepted here and reported by `lappet.checks`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from lappet.procedure.events import Event
from lappet.procedure.laid_flap import LaidFlap
from lappet.procedure.muscle import Muscle
from lappet.procedure.plate import Plate
from lappet.procedure.scenery import Scenery
from lappet.procedure.skin_line import SkinLine
from lappet.procedure.storyboard import storyboard
from lappet.procedure.tissue import DEFAULT_SKIN, Bone, Material, Tissue
from lappet.procedure.vessel import Vessel


@dataclass(frozen=True, eq=False, repr=False)
class Procedure:
    """A tissue, its materials and the events of an operation; frames are the integer time codes.

    Events keep the order in which they are given (the order of the prims), whatever their times. `==` compares every
    value exactly; `repr` is a storyboard.

    Parameters
    ----------
    tissue
        The tissue that is operated on.
    materials
        Materials that the tissue and its regions name.
    events
        The timeline, in the order of the prims.
    bones
        Rigid meshes that the tissue may not enter.
    start_time
        First time code.
    end_time
        Last time code.
    fps
        Time codes per second.
    skin_lines
        Lines along which the skin's fibers run; without any, `fiber_direction` and `prestretch` of the materials hold
        everywhere.
    vessels
        Vessels and nerves in the tissue.
    scenery
        Meshes that are shown around the tissue and not solved.
    flaps
        What of the events the flap library made, and how; they act without it.
    plates
        Pages of drawings for print; they do not act.
    muscles
        Parts of the tissue of other materials, whose fibers run from an origin to an insertion.

    Examples
    --------
    >>> from lappet import Incision, Procedure
    >>> from lappet.tissue import flat_patch
    >>> cut = Incision("cut", 2, [(-10, 0, 4), (10, 0, 4)])
    >>> procedure = Procedure(flat_patch((40.0, 30.0, 4.0), spacing=2.0), events=(cut,), end_time=3)
    >>> procedure.event("cut").kerf, list(procedure.frames())
    (0.05, [1, 2, 3])
    """

    tissue: Tissue
    materials: tuple[Material, ...] = (DEFAULT_SKIN,)
    events: tuple[Event, ...] = ()
    bones: tuple[Bone, ...] = ()
    start_time: float = 1.0
    end_time: float = 1.0
    fps: float = 24.0
    skin_lines: tuple[SkinLine, ...] = ()
    vessels: tuple[Vessel, ...] = ()
    scenery: tuple[Scenery, ...] = ()
    flaps: tuple[LaidFlap, ...] = ()
    plates: tuple[Plate, ...] = ()
    muscles: tuple[Muscle, ...] = ()

    def with_events(self, *events: Event) -> Procedure:
        """Make the same procedure with events added at the end of the timeline.

        Parameters
        ----------
        *events
            The events to add.

        Returns
        -------
        Procedure
            The longer procedure.
        """
        return replace(self, events=(*self.events, *events))

    def event(self, name: str) -> Event:
        """Look up an event.

        Parameters
        ----------
        name
            Name of the event.

        Returns
        -------
        Event
            The event.

        Raises
        ------
        KeyError
            If there is none of that name.
        """
        for event in self.events:
            if event.name == name:
                return event
        raise KeyError(name)

    def material(self, name: str) -> Material:
        """Look up a material.

        Parameters
        ----------
        name
            Name of the material.

        Returns
        -------
        Material
            The material.

        Raises
        ------
        KeyError
            If there is none of that name.
        """
        for material in self.materials:
            if material.name == name:
                return material
        raise KeyError(name)

    def materials_in_use(self) -> tuple[Material, ...]:
        """List the tissue's material, then those of its regions and muscles.

        Returns
        -------
        tuple[Material, ...]
            Each material once, in the order of the regions and muscles; names that no material has are left out.
        """
        names = dict.fromkeys([self.tissue.material, *(region.material for region in self.tissue.regions)])
        names |= dict.fromkeys(muscle.material for muscle in self.muscles)
        known = {material.name: material for material in reversed(self.materials)}
        return tuple(known[name] for name in names if name in known)

    def frames(self) -> range:
        """List the frames: every whole time code from `start_time` to `end_time`, both included.

        Returns
        -------
        range
            The time codes; none where an end is not finite.
        """
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
            and self.skin_lines == other.skin_lines
            and self.vessels == other.vessels
            and self.scenery == other.scenery
            and self.flaps == other.flaps
            and self.plates == other.plates
            and self.muscles == other.muscles
            and self.tissue == other.tissue
        )

    def __hash__(self) -> int:
        return hash((self.tissue, self.materials, self.events, self.start_time, self.end_time))

    def __repr__(self) -> str:
        return storyboard(self)
