"""The list of events in a scene: adding, finding, ordering, naming and moving them.

An item of a collection may lie elsewhere in memory once another is added: keep names or uids, not items.
"""

from __future__ import annotations

import re
import unicodedata
import uuid
from collections.abc import Iterable, Sequence
from typing import Any

import bpy

from .changes import changed
from .decimals import decimal
from .event_kinds import HOLD_KINDS, KINDS, SEWN_KINDS
from .event_target import EVENT_TAG, followers, remove_target, shift_keyframes

KIND_NAMES = tuple(kind[0] for kind in KINDS)


def add_event(scene: bpy.types.Scene, kind: str, name: str = "", **fields: Any) -> Any:
    """Add an event of a kind ("HOOK") at the end of the list, make it the active one and return it.

    name: what it should be called (made a USD identifier that no other event has; "" = kind and number). fields: values
    of `LappetEvent`; points is a sequence of (x, y, z) in mm at rest.
    """
    if kind not in KIND_NAMES:
        raise ValueError(f"There is no kind of event {kind!r}; there are {', '.join(KIND_NAMES)}.")
    events = scene.lappet.events
    taken = {each.name for each in events}
    event = events.add()
    event.uid = uuid.uuid4().hex
    event.name = unique_name(name, taken) if name else numbered_name(kind, taken)
    event.kind = kind
    points = fields.pop("points", ())
    for field, value in fields.items():
        setattr(event, field, value)
    set_points(event, points)
    scene.lappet.active_event = len(events) - 1
    changed(scene)
    return event


def set_points(event: Any, points: Iterable[Sequence[float]]) -> None:
    """Replace the points of an event by (x, y, z) in mm at rest."""
    event.points.clear()
    for point in points:
        event.points.add().co = point


def find_event(scene: bpy.types.Scene, name_or_uid: str) -> Any | None:
    """The event of that name, else of that uid, else None."""
    index = event_index(scene, name_or_uid)
    return None if index < 0 else scene.lappet.events[index]


def event_index(scene: bpy.types.Scene, name_or_uid: str) -> int:
    """The index of the event of that name, else of that uid, else -1."""
    events = scene.lappet.events
    index = int(events.find(name_or_uid)) if name_or_uid else -1
    if index < 0 and name_or_uid:
        index = next((i for i, event in enumerate(events) if event.uid == name_or_uid), -1)
    return index


def remove_event(scene: bpy.types.Scene, event: Any) -> None:
    """Take an event out of the list, and the empty that was made for it and that nothing else follows."""
    events = scene.lappet.events
    uid, target = event.uid, event.target
    index = event_index(scene, uid)
    event.target = None
    events.remove(index)
    if target is not None:
        remove_target(target, uid)
    active = scene.lappet.active_event
    if active >= index:
        scene.lappet.active_event = min(max(active - 1, 0), len(events) - 1)
    changed(scene)


def sorted_events(scene: bpy.types.Scene) -> list[int]:
    """Indices of the events in order of time; those of one time stay as they are in the list."""
    events = scene.lappet.events
    return sorted(range(len(events)), key=lambda i: event_time(events[i]))


def event_time(event: Any) -> float:
    """The frame at which an event happens or begins."""
    return decimal(event.start)


def event_end(event: Any) -> float:
    """The frame at which an event has ended: a release, a suture closed; else its time."""
    if event.kind in HOLD_KINDS:
        return decimal(event.end)
    return event_time(event) + (decimal(event.duration) if event.kind in SEWN_KINDS else 0.0)


def move_event(scene: bpy.types.Scene, event: Any, new_start: float) -> None:
    """Move an event to another frame, its release and the keyframes of its target with it.

    The keyframes of a target that another event follows too, or that is of a library, stay where they are.
    """
    new_start = decimal(round(new_start, 4))
    shift = new_start - event_time(event)
    if shift == 0.0:
        return
    event.start = new_start
    if event.kind in HOLD_KINDS:
        event.end = round(decimal(event.end) + shift, 4)
        if event.target is not None and followers(event.target) == [(scene.name, event.uid)]:
            shift_keyframes(event.target, shift)
    changed(scene)


def rename_event(scene: bpy.types.Scene, event: Any, name: str) -> str:
    """Rename an event as near to `name` as USD and the other events let it, and return the name it got."""
    taken = {each.name for each in scene.lappet.events if each.uid != event.uid}
    event.name = unique_name(name, taken) if identifier(name) else numbered_name(event.kind, taken)
    if event.target is not None and event.target.get(EVENT_TAG) == event.uid:
        event.target.name = target_name(event.name)
    changed(scene)
    return str(event.name)


def target_name(event_name: str) -> str:
    """What the empty of an event is called."""
    return f"{event_name} target"


def identifier(name: str) -> str:
    """The nearest name that a prim of USD may have: letters, digits and underscores, no digit first; "" for nothing."""
    plain = unicodedata.normalize("NFKD", name.strip()).encode("ascii", "ignore").decode()
    plain = re.sub(r"[^A-Za-z0-9_]+", "_", plain)
    if not plain.strip("_"):
        return ""
    return f"_{plain}" if plain[0].isdigit() else plain


def unique_name(name: str, taken: Iterable[str]) -> str:
    """The nearest identifier that is not taken: a number is counted up, or one is put behind it."""
    taken = set(taken)
    wanted = identifier(name) or "event"
    if wanted not in taken:
        return wanted
    stem, _, number = wanted.rpartition("_")
    if not (stem and number.isdigit()):
        stem, number = wanted, "1"
    count = int(number) + 1
    while f"{stem}_{count}" in taken:
        count += 1
    return f"{stem}_{count}"


def numbered_name(kind: str, taken: Iterable[str]) -> str:
    """hook_1, hook_2 ...: the first number that is free."""
    taken = set(taken)
    count = 1
    while f"{kind.lower()}_{count}" in taken:
        count += 1
    return f"{kind.lower()}_{count}"
