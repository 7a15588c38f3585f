"""Have Blender translate the interface."""

from __future__ import annotations

from typing import Any

import bpy

from .dictionary import blender_dictionary

CLASSES: tuple[Any, ...] = ()
_NAME = (__package__ or "").rpartition(".")[0]


def register() -> None:
    """Add the messages."""
    bpy.app.translations.register(_NAME, blender_dictionary())


def unregister() -> None:
    """Take them away."""
    bpy.app.translations.unregister(_NAME)
