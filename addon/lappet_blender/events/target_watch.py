"""Have targets sampled anew once they, or what they hang on, were moved or keyframed.

The solving side watches the same updates for its own sake; here only what `target_samples` remembers is at stake.
"""

from __future__ import annotations

from typing import Any

import bpy
from bpy.app.handlers import persistent

from ..model import target_samples

_placed: dict[int, tuple[object, ...]] = {}  # how objects stood when they were seen last, by session_uid


def moved(updates: Any, targets: set[bpy.types.Object], depend: bool) -> bool:
    """Whether these updates of a dependency graph may move a target.

    depend: some target depends on other objects. Rebuilding a graph names objects that stay where they are; those do
    not count.
    """
    found = False
    for update in updates:
        owner = update.id.original
        if isinstance(owner, bpy.types.Action):
            found = found or depend or any(_action(target) == owner for target in targets)
        elif isinstance(owner, bpy.types.Object) and (depend or owner in targets):
            now = _place(owner)
            found = found or _placed.get(owner.session_uid) != now
            _placed[owner.session_uid] = now
    return found


def _action(target: bpy.types.Object) -> bpy.types.Action | None:
    return target.animation_data.action if target.animation_data is not None else None


def _place(owner: bpy.types.Object) -> tuple[object, ...]:
    constraints = tuple((each.type, each.enabled, each.influence) for each in owner.constraints)
    parent = owner.parent.session_uid if owner.parent is not None else 0
    return (tuple(tuple(row) for row in owner.matrix_world), parent, constraints)


def _after_update(_scene: bpy.types.Scene, depsgraph: Any) -> None:
    every = {event.target for scene in bpy.data.scenes for event in scene.lappet.events if event.target is not None}
    if every and moved(depsgraph.updates, every, any(not target_samples.is_plain(target) for target in every)):
        target_samples.mark_dirty()


def _after_step(*_: object) -> None:
    target_samples.mark_dirty()
    _placed.clear()


# Kept when another file is loaded.
for _handler in (_after_update, _after_step):
    persistent(_handler)

_STEPS = ("undo_post", "redo_post", "load_post")


def register() -> None:
    """Add the handlers."""
    bpy.app.handlers.depsgraph_update_post.append(_after_update)
    for name in _STEPS:
        getattr(bpy.app.handlers, name).append(_after_step)


def unregister() -> None:
    """Take them off."""
    for name, handler in (("depsgraph_update_post", _after_update), *((name, _after_step) for name in _STEPS)):
        handlers = getattr(bpy.app.handlers, name)
        if handler in handlers:
            handlers.remove(handler)
