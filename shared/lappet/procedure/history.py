"""The edits of a procedure as commands, with unlimited and exact undo and redo.

A command makes a new procedure from an old one. Since procedures are immutable and share what did not change, the
history keeps every state itself: undo returns the very state from before, bit for bit.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Protocol

from lappet.core.problem import Problem, RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.procedure.events import Event, Excision, Hook, Incision, Landmark, Retractor, Suture, Undermine
from lappet.procedure.prim_paths import BONE, MATERIALS, ROOT, TIMELINE, TISSUE
from lappet.procedure.procedure import Procedure
from lappet.procedure.tissue import Bone, Material, Region, Tissue


class Command(Protocol):
    """An edit. `label` is what an undo menu shows; `apply` raises RefusedError where the edit makes no sense."""

    @property
    def label(self) -> str: ...

    def apply(self, procedure: Procedure) -> Procedure: ...


class History:
    """A procedure and the commands that led to it."""

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
        """What `undo` would take back, None where there is nothing."""
        return self._labels[self._at - 1] if self._at else None

    @property
    def redo_label(self) -> str | None:
        """What `redo` would do again, None where there is nothing."""
        return self._labels[self._at] if self._at < len(self._labels) else None

    def do(self, command: Command) -> Procedure:
        """Applies a command and forgets what was undone; a command that is refused changes nothing."""
        after = command.apply(self.procedure)
        del self._states[self._at + 1 :], self._labels[self._at :]
        self._states.append(after)
        self._labels.append(command.label)
        self._at += 1
        return after

    def undo(self) -> Procedure:
        """Goes back to before the last command; raises IndexError where there is none."""
        if not self._at:
            raise IndexError("There is nothing to undo.")
        self._at -= 1
        return self.procedure

    def redo(self) -> Procedure:
        """Does again what was undone last; raises IndexError where nothing was."""
        if self._at == len(self._labels):
            raise IndexError("There is nothing to redo.")
        self._at += 1
        return self.procedure


@dataclass(frozen=True)
class AddEvent:
    """Adds an event before the event at `index` of the timeline, or at its end."""

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
    """Removes the event of that name."""

    name: str

    @property
    def label(self) -> str:
        return f"Remove {self.name}"

    def apply(self, procedure: Procedure) -> Procedure:
        return replace(procedure, events=_without(procedure.events, self.name, TIMELINE))


@dataclass(frozen=True)
class ReplaceEvent:
    """Puts another event, of any kind and name, in the place of the event of that name."""

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
    """Moves an event to another place in the order of the timeline."""

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
    """Shifts an event in time, all its samples included; landmarks have no time and are refused."""

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
    """Replaces the material of the same name, or adds it."""

    material: Material

    @property
    def label(self) -> str:
        return f"Set material {self.material.name}"

    def apply(self, procedure: Procedure) -> Procedure:
        return replace(procedure, materials=_set(procedure.materials, self.material))


@dataclass(frozen=True)
class RemoveMaterial:
    """Removes a material that neither the tissue nor a region of it is made of."""

    name: str

    @property
    def label(self) -> str:
        return f"Remove material {self.name}"

    def apply(self, procedure: Procedure) -> Procedure:
        if procedure.tissue.material == self.name:
            sentence = f"The tissue is made of {self.name!r}."
            remedy = "Give the tissue another material first."
            raise RefusedError([Problem(ProblemCode.UNSORTED, f"{MATERIALS}/{self.name}", self.name, sentence, remedy)])
        for region in procedure.tissue.regions:
            if region.material == self.name:
                sentence = f"The region {region.faces!r} is made of {self.name!r}."
                remedy = "Give the region another material first, or remove it."
                raise RefusedError(
                    [Problem(ProblemCode.UNSORTED, f"{MATERIALS}/{self.name}", self.name, sentence, remedy)]
                )
        return replace(procedure, materials=_without(procedure.materials, self.name, MATERIALS))


@dataclass(frozen=True)
class SetRegion:
    """Gives a face subset of the tissue a region, in place of the one that it has."""

    region: Region

    @property
    def label(self) -> str:
        return f"Set region {self.region.faces}"

    def apply(self, procedure: Procedure) -> Procedure:
        tissue = procedure.tissue
        if self.region.faces not in tissue.subsets:
            known = ", ".join(tissue.subsets) or "none"
            sentence = f"The tissue has no face subset {self.region.faces!r}."
            remedy = f"Add it first; there are: {known}."
            raise RefusedError(
                [Problem(ProblemCode.UNSORTED, f"{TISSUE}/{self.region.faces}", self.region.faces, sentence, remedy)]
            )
        others = tuple(region for region in tissue.regions if region.faces != self.region.faces)
        return replace(procedure, tissue=replace(tissue, regions=(*others, self.region)))


@dataclass(frozen=True)
class RemoveRegion:
    """Takes the region off a face subset; the subset stays."""

    faces: str

    @property
    def label(self) -> str:
        return f"Remove region {self.faces}"

    def apply(self, procedure: Procedure) -> Procedure:
        tissue = procedure.tissue
        others = tuple(region for region in tissue.regions if region.faces != self.faces)
        if len(others) == len(tissue.regions):
            known = ", ".join(region.faces for region in tissue.regions) or "none"
            sentence = f"The face subset {self.faces!r} has no region."
            raise RefusedError(
                [Problem(ProblemCode.UNSORTED, f"{TISSUE}/{self.faces}", self.faces, sentence, f"There are: {known}.")]
            )
        return replace(procedure, tissue=replace(tissue, regions=others))


@dataclass(frozen=True)
class SetTissue:
    """Replaces the tissue."""

    tissue: Tissue
    label: str = "Set tissue"

    def apply(self, procedure: Procedure) -> Procedure:
        return replace(procedure, tissue=self.tissue)


@dataclass(frozen=True)
class SetBone:
    """Replaces the bone of the same name, or adds it."""

    bone: Bone

    @property
    def label(self) -> str:
        return f"Set bone {self.bone.name}"

    def apply(self, procedure: Procedure) -> Procedure:
        return replace(procedure, bones=_set(procedure.bones, self.bone))


@dataclass(frozen=True)
class RemoveBone:
    """Removes a bone."""

    name: str

    @property
    def label(self) -> str:
        return f"Remove bone {self.name}"

    def apply(self, procedure: Procedure) -> Procedure:
        return replace(procedure, bones=_without(procedure.bones, self.name, BONE))


@dataclass(frozen=True)
class SetTimeline:
    """Sets start and end (time codes) and time codes per second; None leaves as it is."""

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
            remedy = "Let it end at its start or later."
            raise RefusedError(
                [Problem(ProblemCode.UNSORTED, ROOT, span, f"The timeline would run from {span}.", remedy)]
            )
        return after


@dataclass(frozen=True)
class Together:
    """Several commands as one step of the history; all are applied, or none."""

    commands: tuple[Command, ...]
    label: str

    def apply(self, procedure: Procedure) -> Procedure:
        for command in self.commands:
            procedure = command.apply(procedure)
        return procedure


@dataclass(frozen=True)
class Edit:
    """Any other edit: a function from the old procedure to the new one."""

    edit: Callable[[Procedure], Procedure]
    label: str

    def apply(self, procedure: Procedure) -> Procedure:
        return self.edit(procedure)


def retimed(event: Event, shift: float) -> Event:
    """The event `shift` time codes later, its samples too. Raises RefusedError for a landmark."""
    match event:
        case Incision() | Excision() | Undermine():
            return replace(event, time=event.time + shift)
        case Hook():
            targets = tuple((time + shift, target) for time, target in event.targets)
            return replace(event, start=event.start + shift, release=event.release + shift, targets=targets)
        case Retractor():
            motion = tuple((time + shift, matrix) for time, matrix in event.motion)
            return replace(event, start=event.start + shift, release=event.release + shift, motion=motion)
        case Suture():
            return replace(event, start=event.start + shift)
        case Landmark():
            sentence = f"The landmark {event.name} has no time to move."
            raise RefusedError(
                [
                    Problem(
                        ProblemCode.UNSORTED, f"{TIMELINE}/{event.name}", "landmark", sentence, "Retime another event."
                    )
                ]
            )


def _find(things: tuple[Any, ...], name: str, place: str) -> int:
    for i, thing in enumerate(things):
        if thing.name == name:
            return i
    known = ", ".join(thing.name for thing in things) or "nothing"
    sentence = f"Nothing there is named {name!r}."
    raise RefusedError([Problem(ProblemCode.UNSORTED, f"{place}/{name}", name, sentence, f"There is {known}.")])


def _refuse_taken(things: tuple[Any, ...], name: str, place: str) -> None:
    if any(thing.name == name for thing in things):
        sentence = f"The name {name!r} is taken."
        raise RefusedError([Problem(ProblemCode.UNSORTED, f"{place}/{name}", name, sentence, "Choose another name.")])


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
