"""Laid flaps in a scene: how the flap library's events were made, so that a flap can be changed later.

A scene keeps the values as they are in the procedure; which events belong to a flap, each event says itself, since
their names may change.
"""

from __future__ import annotations

import base64
import binascii
from collections.abc import Collection
from dataclasses import replace

import bpy

from lappet.core.array_codec import CodecError
from lappet.core.value_codec import pack, unpack
from lappet.procedure import LaidFlap

from .changes import changed


def flap_values(scene: bpy.types.Scene, events: Collection[str]) -> tuple[LaidFlap, ...]:
    """The scene's laid flaps, each with the names that its events have now.

    events: the names of those that the procedure has; others are off. Flaps whose events were all deleted, and those
    that cannot be read, are left out.
    """
    found = []
    for each in scene.lappet.flaps:
        value = _value(each)
        names = events_of(scene, each.name)
        if value is not None and names:
            found.append(replace(value, name=str(each.name), events=tuple(n for n in names if n in events)))
    return tuple(found)


def events_of(scene: bpy.types.Scene, flap: str) -> list[str]:
    """The names of the events that belong to a flap."""
    return [str(event.name) for event in scene.lappet.events if flap and event.flap == flap]


def keep_flap(scene: bpy.types.Scene, value: LaidFlap) -> None:
    """Keep a flap in the scene, in place of one of its name, and mark its events, which the scene has by now."""
    flaps = scene.lappet.flaps
    index = flaps.find(value.name)
    each = flaps[index] if index >= 0 else flaps.add()
    each.name, each.value = value.name, base64.b64encode(pack(replace(value, events=()))).decode("ascii")
    for event in scene.lappet.events:
        if event.name in value.events:
            event.flap = value.name
    changed(scene)


def active_flap(scene: bpy.types.Scene) -> str:
    """The name of the flap that the active event belongs to, "" for none."""
    events, active = scene.lappet.events, scene.lappet.active_event
    name = str(events[active].flap) if 0 <= active < len(events) else ""
    return name if name and scene.lappet.flaps.find(name) >= 0 else ""


def design_of(scene: bpy.types.Scene, flap: str) -> str:
    """The name of the design of a flap, "" where it cannot be read."""
    index = scene.lappet.flaps.find(flap) if flap else -1
    value = _value(scene.lappet.flaps[index]) if index >= 0 else None
    return "" if value is None else value.design


def _value(each: bpy.types.PropertyGroup) -> LaidFlap | None:
    try:
        return unpack(base64.b64decode(str(each.value), validate=True), LaidFlap)
    except (CodecError, binascii.Error, ValueError):
        return None
