"""Who is told that a scene's procedure may have changed.

Property updates, operators and handlers call `changed`; the solving side subscribes and looks what it means.
"""

from __future__ import annotations

from collections.abc import Callable

import bpy

Listener = Callable[[bpy.types.Scene], None]
_listeners: list[Listener] = []


def subscribe(listener: Listener) -> None:
    """Call `listener(scene)` after every change, on the main thread; it must be quick."""
    if listener not in _listeners:
        _listeners.append(listener)


def unsubscribe(listener: Listener) -> None:
    """Take a listener off; one that is not there is no error."""
    if listener in _listeners:
        _listeners.remove(listener)


def changed(scene: bpy.types.Scene) -> None:
    """The procedure of a scene may have changed."""
    for listener in list(_listeners):
        listener(scene)


def property_changed(owner: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    """The `update` of every property that the procedure depends on."""
    scene = owner.id_data
    if isinstance(scene, bpy.types.Scene):
        changed(scene)
