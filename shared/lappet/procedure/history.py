"""The edits of a procedure as commands, with unlimited and exact undo and redo.

A command makes a new procedure from an old one. Since procedures are immutable and share what did not change, the
history keeps every state itself: undo returns the very state from before, bit for bit.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Protocol

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.procedure.events import Event, retimed
from lappet.procedure.prim_paths import BONE, MATERIALS, ROOT, TIMELINE, TISSUE
from lappet.procedure.procedure import Procedure
from lappet.procedure.tissue import Bone, Material, Region, Tissue


class Command(Protocol):
    """An edit of a procedure."""

    @property
    def label(self) -> str:
        """What an undo menu shows."""

    def apply(self, procedure: Procedure) -> Procedure:
        """Make the edited procedure.

        Parameters
        ----------
        procedure
            The procedure before the edit; it stays as it is.

        Returns
        -------
        Procedure
            The procedure after it.

        Raises
        ------
        RefusedError
            If the edit makes no sense for this procedure.
        """


class History:
    """A procedure and the commands that led to it.

    Parameters
    ----------
    procedure
        The procedure to start from.
    """

    def __init__(self, procedure: Procedure) -> None:
        self._states = [procedure]
        self._labels: list[str] = []
        self._at = 0

    @property
    def procedure(self) -> Procedure:
        """The procedure as it is now."""
        return self._states[self._at]

    @property
    def undo_label(self) -> str | None:
        """Label of the command that `undo` would take back, or None."""
        return self._labels[self._at - 1] if self._at else None

    @property
    def redo_label(self) -> str | None:
        """Label of the command that `redo` would apply again, or None."""
        return self._labels[self._at] if self._at < len(self._labels) else None

    def do(self, command: Command) -> Procedure:
        """Apply a command and drop what could be redone; a command that is refused changes nothing.

        Parameters
        ----------
        command
            The edit.

        Returns
        -------
        Procedure
            The procedure after it.

        Raises
        ------
        RefusedError
            If the command refuses.
        """
        after = command.apply(self.procedure)
        del self._states[self._at + 1 :], self._labels[self._at :]
        self._states.append(after)
        self._labels.append(command.label)
        self._at += 1
        return after

    def undo(self) -> Procedure:
        """Go back to before the last command.

        Returns
        -------
        Procedure
            The procedure as it was.

        Raises
        ------
        IndexError
            If there is nothing to undo.
        """
        if not self._at:
            raise IndexError("There is nothing to undo.")
        self._at -= 1
        return self.procedure

    def redo(self) -> Procedure:
        """Apply again what was undone last.

        Returns
        -------
        Procedure
            The procedure as it was before `undo`.

        Raises
        ------
        IndexError
            If there is nothing to redo.
        """
        if self._at == len(self._labels):
            raise IndexError("There is nothing to redo.")
        self._at += 1
        return self.procedure


@dataclass(frozen=True)
class AddEvent:
    """Add an event before the event at `index` of the timeline, or at its end.

    Parameters
    ----------
    event
        The new event.
    index
        Place in the order of the timeline, or None for its end.
    """

    event: Event
    index: int | None = None

    @property
    def label(self) -> str:
        return f"Add {self.event.kind.lower()} {self.event.name}"

    def apply(self, procedure: Procedure) -> Procedure:
        _refuse_taken(procedure.events, self.event.name, TIMELINE)
        events = list(procedure.events)
        events.insert(len(events) if self.index is None else self.index, self.event)
        return replace(procedure, events=tuple(events))


@dataclass(frozen=True)
class RemoveEvent:
    """Remove the event of that name.

    Parameters
    ----------
    name
        Name of the event.
    """

    name: str

    @property
    def label(self) -> str:
        return f"Remove {self.name}"

    def apply(self, procedure: Procedure) -> Procedure:
        return replace(procedure, events=_without(procedure.events, self.name, TIMELINE))


@dataclass(frozen=True)
class ReplaceEvent:
    """Put another event, of any kind and name, in the place of the event of that name.

    Parameters
    ----------
    name
        Name of the event that goes.
    event
        The event that comes.
    """

    name: str
    event: Event

    @property
    def label(self) -> str:
        return f"Edit {self.name}"

    def apply(self, procedure: Procedure) -> Procedure:
        if self.event.name != self.name:
            _refuse_taken(procedure.events, self.event.name, TIMELINE)
        return replace(procedure, events=_with(procedure.events, self.name, self.event, TIMELINE))


@dataclass(frozen=True)
class MoveEvent:
    """Move an event to another place in the order of the timeline.

    Parameters
    ----------
    name
        Name of the event.
    index
        Its new place.
    """

    name: str
    index: int

    @property
    def label(self) -> str:
        return f"Move {self.name}"

    def apply(self, procedure: Procedure) -> Procedure:
        event = procedure.events[_find(procedure.events, self.name, TIMELINE)]
        events = list(_without(procedure.events, self.name, TIMELINE))
        events.insert(self.index, event)
        return replace(procedure, events=tuple(events))


@dataclass(frozen=True)
class Retime:
    """Shift an event in time with all its samples; landmarks have no time and are refused.

    Parameters
    ----------
    name
        Name of the event.
    shift
        Time codes to add.
    """

    name: str
    shift: float

    @property
    def label(self) -> str:
        return f"Move {self.name} by {self.shift:+g}"

    def apply(self, procedure: Procedure) -> Procedure:
        event = procedure.events[_find(procedure.events, self.name, TIMELINE)]
        return replace(procedure, events=_with(procedure.events, self.name, retimed(event, self.shift), TIMELINE))


@dataclass(frozen=True)
class SetMaterial:
    """Replace the material of the same name, or add it.

    Parameters
    ----------
    material
        The material.
    """

    material: Material

    @property
    def label(self) -> str:
        return f"Set material {self.material.name}"

    def apply(self, procedure: Procedure) -> Procedure:
        return replace(procedure, materials=_set(procedure.materials, self.material))


@dataclass(frozen=True)
class RemoveMaterial:
    """Remove a material of which neither the tissue nor a region of it is made.

    Parameters
    ----------
    name
        Name of the material.
    """

    name: str

    @property
    def label(self) -> str:
        return f"Remove material {self.name}"

    def apply(self, procedure: Procedure) -> Procedure:
        if procedure.tissue.material == self.name:
            raise refused(ProblemCode.MATERIAL_IN_USE, f"{MATERIALS}/{self.name}", self.name, user="The tissue")
        for region in procedure.tissue.regions:
            if region.material == self.name:
                user = f"The region {region.faces!r}"
                raise refused(ProblemCode.MATERIAL_IN_USE, f"{MATERIALS}/{self.name}", self.name, user=user)
        return replace(procedure, materials=_without(procedure.materials, self.name, MATERIALS))


@dataclass(frozen=True)
class SetRegion:
    """Give a face subset of the tissue a region, in place of the one that it has.

    Parameters
    ----------
    region
        The region; its `faces` name the subset.
    """

    region: Region

    @property
    def label(self) -> str:
        return f"Set region {self.region.faces}"

    def apply(self, procedure: Procedure) -> Procedure:
        tissue = procedure.tissue
        if self.region.faces not in tissue.subsets:
            known = ", ".join(tissue.subsets) or "none"
            prim = f"{TISSUE}/{self.region.faces}"
            raise refused(ProblemCode.REGION_NO_SUBSET, prim, repr(self.region.faces), known=known)
        others = tuple(region for region in tissue.regions if region.faces != self.region.faces)
        return replace(procedure, tissue=replace(tissue, regions=(*others, self.region)))


@dataclass(frozen=True)
class RemoveRegion:
    """Take the region off a face subset; the subset stays.

    Parameters
    ----------
    faces
        Name of the subset.
    """

    faces: str

    @property
    def label(self) -> str:
        return f"Remove region {self.faces}"

    def apply(self, procedure: Procedure) -> Procedure:
        tissue = procedure.tissue
        others = tuple(region for region in tissue.regions if region.faces != self.faces)
        if len(others) == len(tissue.regions):
            known = ", ".join(region.faces for region in tissue.regions) or "none"
            raise refused(ProblemCode.REGION_UNKNOWN, f"{TISSUE}/{self.faces}", self.faces, known=known)
        return replace(procedure, tissue=replace(tissue, regions=others))


@dataclass(frozen=True)
class SetTissue:
    """Replace the tissue.

    Parameters
    ----------
    tissue
        The new tissue.
    label
        What an undo menu shows.
    """

    tissue: Tissue
    label: str = "Set tissue"

    def apply(self, procedure: Procedure) -> Procedure:
        return replace(procedure, tissue=self.tissue)


@dataclass(frozen=True)
class SetBone:
    """Replace the bone of the same name, or add it.

    Parameters
    ----------
    bone
        The bone.
    """

    bone: Bone

    @property
    def label(self) -> str:
        return f"Set bone {self.bone.name}"

    def apply(self, procedure: Procedure) -> Procedure:
        return replace(procedure, bones=_set(procedure.bones, self.bone))


@dataclass(frozen=True)
class RemoveBone:
    """Remove a bone.

    Parameters
    ----------
    name
        Name of the bone.
    """

    name: str

    @property
    def label(self) -> str:
        return f"Remove bone {self.name}"

    def apply(self, procedure: Procedure) -> Procedure:
        return replace(procedure, bones=_without(procedure.bones, self.name, BONE))


@dataclass(frozen=True)
class SetTimeline:
    """Set the timeline's start, end and rate; None leaves a value as it is.

    Parameters
    ----------
    start_time
        First time code.
    end_time
        Last time code.
    fps
        Time codes per second.
    label
        What an undo menu shows.
    """

    start_time: float | None = None
    end_time: float | None = None
    fps: float | None = None
    label: str = "Set timeline"

    def apply(self, procedure: Procedure) -> Procedure:
        given = {"start_time": self.start_time, "end_time": self.end_time, "fps": self.fps}
        changes: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
        after = replace(procedure, **changes)
        if not after.start_time <= after.end_time:
            span = f"{after.start_time:g} to {after.end_time:g}"
            raise refused(ProblemCode.TIMELINE_REVERSED, ROOT, span)
        return after


@dataclass(frozen=True)
class Together:
    """Several commands as one step of the history: all are applied, or none.

    Parameters
    ----------
    commands
        The commands in order.
    label
        What an undo menu shows.
    """

    commands: tuple[Command, ...]
    label: str

    def apply(self, procedure: Procedure) -> Procedure:
        for command in self.commands:
            procedure = command.apply(procedure)
        return procedure


@dataclass(frozen=True)
class Edit:
    """Any other edit, as a function.

    Parameters
    ----------
    edit
        Makes the new procedure from the old one.
    label
        What an undo menu shows.
    """

    edit: Callable[[Procedure], Procedure]
    label: str

    def apply(self, procedure: Procedure) -> Procedure:
        return self.edit(procedure)


def _find(things: tuple[Any, ...], name: str, place: str) -> int:
    for i, thing in enumerate(things):
        if thing.name == name:
            return i
    known = ", ".join(thing.name for thing in things) or "nothing"
    raise refused(ProblemCode.NAME_UNKNOWN, f"{place}/{name}", name, known=known)


def _refuse_taken(things: tuple[Any, ...], name: str, place: str) -> None:
    if any(thing.name == name for thing in things):
        raise refused(ProblemCode.NAME_TAKEN, f"{place}/{name}", name)


def _without(things: tuple[Any, ...], name: str, place: str) -> tuple[Any, ...]:
    at = _find(things, name, place)
    return things[:at] + things[at + 1 :]


def _with(things: tuple[Any, ...], name: str, new: Any, place: str) -> tuple[Any, ...]:
    at = _find(things, name, place)
    return (*things[:at], new, *things[at + 1 :])


def _set(things: tuple[Any, ...], new: Any) -> tuple[Any, ...]:
    if any(thing.name == new.name for thing in things):
        return tuple(new if thing.name == new.name else thing for thing in things)
    return (*things, new)
