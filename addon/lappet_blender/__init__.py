"""Lappet in Blender: draw a flap operation on a skin model, solve it, scrub and render it.

The only package of Lappet that imports bpy. Blender calls `register` and `unregister`. Pictures without a window need
neither: `python -m lappet_blender.figure` draws a skin cache, and `lappet render` starts it.
"""

from __future__ import annotations

from functools import partial
from importlib import import_module

# In this order; each has a module `registration` with its `CLASSES`, and `register` and `unregister` for the rest.
_PARTS = (
    "model",
    "tissue",
    "events",
    "files",
    "solving",
    "display",
    "tools",
    "strips",
    "plates",
    "start",
    "translation",
)


def register() -> None:
    """Add the properties, operators, tools, panels and handlers; what a failure leaves half done is taken back."""
    utils = import_module("bpy").utils
    begun: list[str] = []
    try:
        for part in _PARTS:
            begun.append(part)
            registration = import_module(f"{__package__}.{part}.registration")
            for each in registration.CLASSES:
                utils.register_class(each)
            registration.register()
    except BaseException:
        _unregister(begun)  # what it complains about was not there yet
        raise


def unregister() -> None:
    """Take everything away again, whatever is at work. Raises the first error, once all that can go is gone."""
    errors = _unregister(list(_PARTS))
    if errors:
        raise errors[0]


def _unregister(parts: list[str]) -> list[Exception]:
    """Take parts away, the last first; an error of one does not keep the others, for half an add-on is worse."""
    utils = import_module("bpy").utils
    # The panels are gone by then, the properties that they show are not.
    before = {"model": [import_module(f"{__package__}.interface.redraw_windows").redraw_windows]}
    errors: list[Exception] = []
    for part in reversed(parts):
        registration = import_module(f"{__package__}.{part}.registration")
        classes = (partial(utils.unregister_class, each) for each in reversed(registration.CLASSES))
        for step in (*before.get(part, ()), registration.unregister, *classes):
            try:
                step()
            except Exception as error:
                errors.append(error)
    return errors
