"""The empties that hooks and retractors follow: making, deleting and copying them, and shifting their keyframes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import bpy

from .keyframes import curves_of

EVENT_TAG = "lappet_event"  # custom property of an empty that was made for an event: the event's uid
COLLECTION_TAG = "lappet_targets"  # custom property of the collection that a scene's empties are put into


def make_target(scene: bpy.types.Scene, name: str, uid: str, size: float) -> bpy.types.Object:
    """An empty for an event, in the scene's collection of targets. size: how large it is drawn, in units."""
    empty = bpy.data.objects.new(name, None)
    empty.empty_display_type = "SPHERE"
    empty.empty_display_size = size
    empty[EVENT_TAG] = uid
    target_collection(scene).objects.link(empty)
    return empty


def target_collection(scene: bpy.types.Scene) -> bpy.types.Collection:
    """The collection of a scene's targets; made where there is none."""
    for child in scene.collection.children:
        if child.get(COLLECTION_TAG):
            return child
    fresh = bpy.data.collections.new("Lappet targets")
    fresh[COLLECTION_TAG] = True
    scene.collection.children.link(fresh)
    return fresh


def copy_target(scene: bpy.types.Scene, target: bpy.types.Object, uid: str) -> bpy.types.Object:
    """A copy of an empty with keyframes of its own, for the event `uid` of a scene."""
    copied = target.copy()
    copied[EVENT_TAG] = uid
    data = copied.animation_data
    if data is not None and data.action is not None:
        slot = getattr(data, "action_slot", None)
        data.action = data.action.copy()
        if slot is not None:
            data.action_slot = next(each for each in data.action.slots if each.identifier == slot.identifier)
    target_collection(scene).objects.link(copied)
    return copied


def remove_target(target: bpy.types.Object, uid: str) -> None:
    """Delete an empty that was made for the event `uid`, once no event follows it."""
    if target.get(EVENT_TAG) != uid or target.library is not None or followers(target):
        return
    action = target.animation_data.action if target.animation_data is not None else None
    bpy.data.objects.remove(target)
    if action is not None and action.users == 0:
        bpy.data.actions.remove(action)


def followers(target: bpy.types.Object) -> list[tuple[str, str]]:
    """(name of the scene, uid) of every event that follows a target."""
    return [
        (scene.name, event.uid) for scene in bpy.data.scenes for event in scene.lappet.events if event.target == target
    ]


def is_there(scene: bpy.types.Scene, target: bpy.types.Object | None) -> bool:
    """Whether a target is still in the scene: a deleted object lives on while an event points to it."""
    return target is not None and scene.objects.get(target.name) == target


def active_fcurves(owner: bpy.types.Object) -> dict[tuple[str, int], Any]:
    """The F-curves that move an object, by (data path, array index): neither muted nor without a keyframe."""
    return {
        (curve.data_path, curve.array_index): curve
        for curve in curves_of(owner)
        if not curve.mute and len(curve.keyframe_points)
    }


def shift_keyframes(target: bpy.types.Object, shift: float) -> None:
    """Move every keyframe of an object by so many frames; one of a library stays as it is."""
    if target.library is not None:
        return
    for curve in curves_of(target):
        for key in curve.keyframe_points:
            before = key.co[0]
            left, right = key.handle_left[:], key.handle_right[:]
            key.co[0] = round(before + shift, 4)
            moved = key.co[0] - before
            key.handle_left = (left[0] + moved, left[1])
            key.handle_right = (right[0] + moved, right[1])
        curve.update()


def set_keyframes(target: bpy.types.Object, path: str, samples: Sequence[tuple[float, Sequence[float]]]) -> None:
    """Give a property of an object these (frame, values) and straight lines between them; one sample stands still."""
    for curve in curves_of(target):
        if curve.data_path == path:
            for key in reversed(list(curve.keyframe_points)):
                target.keyframe_delete(path, index=curve.array_index, frame=key.co[0])
    for frame, values in samples:
        setattr(target, path, values)
        if len(samples) > 1:
            target.keyframe_insert(path, frame=frame, options=set())
    for curve in curves_of(target):
        if curve.data_path == path:
            for key in curve.keyframe_points:
                key.interpolation = "LINEAR"
            curve.update()
