"""Register the template's and the library's operators, and presets of one's own."""

from __future__ import annotations

from . import asset_operators, own_presets, template_offer

CLASSES = (*asset_operators.CLASSES, *own_presets.CLASSES)


def register() -> None:
    """Take up what is dropped from the library from now on, and offer the template."""
    asset_operators.register()
    template_offer.register()


def unregister() -> None:
    """Take it away."""
    own_presets.unregister()
    template_offer.unregister()
    asset_operators.unregister()
