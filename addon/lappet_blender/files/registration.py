"""Registers this part of the add-on."""

from __future__ import annotations


def register() -> None:
    """Nothing to register yet."""


def unregister() -> None:
    """Nothing to take away yet."""
