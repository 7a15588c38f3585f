"""Register this part of the add-on."""

from __future__ import annotations

from . import (
    controller,
    live_operator,
    opened_files,
    preferences,
    reconcile,
    scene_watch,
    solve_operators,
    solve_panel,
    solve_timer,
)

CLASSES = (*preferences.CLASSES, *solve_operators.CLASSES, *live_operator.CLASSES, *solve_panel.CLASSES)


def register() -> None:
    """Add operators, panels, handlers and the timer."""
    scene_watch.register()
    opened_files.register()  # after the watch has read them
    solve_timer.register()
    reconcile.warm_up()


def unregister() -> None:
    """Take them away again and end every worker."""
    solve_timer.unregister()
    opened_files.unregister()
    scene_watch.unregister()
    controller.frame_cache.close()
