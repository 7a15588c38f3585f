"""Lappet in Blender: draw a flap operation on a skin model, solve it, scrub and render it.

The only package of Lappet that imports bpy. Blender calls `register` and `unregister`. Pictures without a window need
neither: `python -m lappet_blender.figure` draws a skin cache, and `lappet render` starts it.
"""

from __future__ import annotations

from importlib import import_module

# In this order; each has a module `registration` with its `CLASSES`, and `register` and `unregister` for the rest.
_PARTS = ("model", "tissue", "events", "files", "solving", "display", "tools")


def register() -> None:
    """Add the properties, operators, tools, panels and handlers; what a failure leaves half done is taken back."""
    utils = import_module("bpy").utils
    done: list[str] = []
    try:
        for part in _PARTS:
            registration = import_module(f"{__package__}.{part}.registration")
            for each in registration.CLASSES:
                utils.register_class(each)
            registration.register()
            done.append(part)
    except BaseException:
        _unregister(done)
        raise


def unregister() -> None:
    """Take everything away again."""
    _unregister(list(_PARTS))


def _unregister(parts: list[str]) -> None:
    utils = import_module("bpy").utils
    for part in reversed(parts):
        registration = import_module(f"{__package__}.{part}.registration")
        registration.unregister()
        for each in reversed(registration.CLASSES):
            utils.unregister_class(each)
