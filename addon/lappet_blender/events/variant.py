"""Variants: a copy of a scene with a procedure of its own."""

from __future__ import annotations

import bpy

from ..model.changes import changed
from ..model.event_list import target_name
from ..model.event_target import COLLECTION_TAG, copy_target


def copy_scene(scene: bpy.types.Scene, name: str) -> bpy.types.Scene:
    """A copy of a scene in which every event can be changed without changing the original.

    Tissue, bones, lights and cameras are the same objects in both; the empties that hooks and retractors follow are
    copied with their keyframes, and the copy shows a skin of its own.
    """
    fresh = scene.copy()
    fresh.name = name
    fresh.lappet.skin = None
    for child in list(fresh.collection.children):
        if child.get(COLLECTION_TAG):
            fresh.collection.children.unlink(child)
    copied: dict[bpy.types.Object, bpy.types.Object] = {}
    for event in fresh.lappet.events:
        target = event.target
        if target is None:
            continue
        if target not in copied:
            copied[target] = copy_target(fresh, target, event.uid)
            copied[target].name = target_name(event.name)
            if target.name in fresh.collection.objects:
                fresh.collection.objects.unlink(target)
        event.target = copied[target]
    for each in copied.values():
        if each.parent in copied:
            each.parent = copied[each.parent]
    changed(fresh)
    return fresh
