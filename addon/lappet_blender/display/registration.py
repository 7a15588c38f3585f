"""Registers this part of the add-on."""

from __future__ import annotations

from . import skin_handlers


def register() -> None:
    """Adds the handlers."""
    skin_handlers.register()


def unregister() -> None:
    """Takes them away."""
    skin_handlers.unregister()
