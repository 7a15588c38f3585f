"""Register the operators on events, the timeline panel and the watch over targets."""

from __future__ import annotations

from ..solving import frames
from . import (
    add_menu,
    cut_operators,
    edit_operators,
    flap_asset_operators,
    flap_operators,
    flap_thumbnails,
    hold_operators,
    point_operators,
    suture_operators,
    target_watch,
    timeline_panel,
)
from .event_check import begin_rest_space

CLASSES = (
    *hold_operators.CLASSES,
    *cut_operators.CLASSES,
    *suture_operators.CLASSES,
    *edit_operators.CLASSES,
    *point_operators.CLASSES,
    *flap_operators.CLASSES,
    *flap_asset_operators.CLASSES,
    *add_menu.CLASSES,
    *timeline_panel.CLASSES,
)


def register() -> None:
    """Add the part."""
    target_watch.register()
    frames.subscribe(begin_rest_space)
    add_menu.register()


def unregister() -> None:
    """Take it away."""
    add_menu.unregister()
    flap_thumbnails.unregister()
    frames.unsubscribe(begin_rest_space)
    target_watch.unregister()
