"""Bring the properties of a scene that an earlier version saved up to this one."""

from __future__ import annotations

from collections.abc import Callable

import bpy

from .plate_values import plates_from_version_1
from .procedure_properties import VERSION

# What to do to a scene of the version that is the key, to make it one of the next. Version 1 is the first: files before
# it hold the same properties without the mark.
STEPS: dict[int, Callable[[bpy.types.Scene], None]] = {1: plates_from_version_1}


def migrate(scene: bpy.types.Scene) -> bool:
    """Bring the scene's procedure up to this version, one at a time; whether anything was to be done.

    Scenes of a library, scenes without a procedure and those of a newer version stay as they are.
    """
    procedure = scene.lappet
    if scene.library is not None or procedure.version >= VERSION:
        return False
    if procedure.version == 0 and procedure.tissue.object is None and len(procedure.events) == 0:
        return False
    while procedure.version < VERSION:
        step = STEPS.get(procedure.version)
        if step is not None:
            step(scene)
        procedure.version += 1
    return True


def from_newer_version(scene: bpy.types.Scene) -> bool:
    """Whether a newer Lappet saved the scene, so that parts of it may be missing here."""
    return bool(scene.lappet.version > VERSION)
