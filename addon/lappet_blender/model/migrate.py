"""Brings the properties of a scene that an earlier version saved up to this one."""

from __future__ import annotations

import bpy

from .procedure_properties import VERSION


def migrate(scene: bpy.types.Scene) -> None:
    """Marks the scene's procedure as one of this version; a newer one stays as it is (`from_newer_version`).

    Version 1 is the first: files before it hold the same properties without the mark.
    """
    if scene.library is None and scene.lappet.version < VERSION and scene.lappet.tissue.object is not None:
        scene.lappet.version = VERSION


def from_newer_version(scene: bpy.types.Scene) -> bool:
    """Whether a newer Lappet saved the scene, so that parts of it may be missing here."""
    return bool(scene.lappet.version > VERSION)
