"""When the skin is shown anew: the frame changes (also in renders), frames come, the look changes, undo, loading."""

from __future__ import annotations

import bpy
from bpy.app.handlers import persistent

from ..model import changes
from ..solving import frames
from . import skin_display
from .display_collection import take_away

_looks: dict[int, tuple] = {}
_WINDOWS = object()


def _look_of(scene: bpy.types.Scene) -> tuple:
    look, shown = scene.lappet.look, scene.lappet
    other = shown.compare_with
    toggles = tuple(getattr(look, name) for name in dir(look) if name.startswith("show_"))
    return (
        look.color,
        toggles,
        None if other is None else other.session_uid,
        round(shown.compare_gap, 6),
        scene.unit_settings.scale_length,
    )


def _frame_changed(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph | None = None) -> None:
    # A render has a dependency graph of its own; its scene is the one that is rendered.
    shown = scene if depsgraph is None else depsgraph.scene.original
    skin_display.show(shown, shown.frame_current)


def _render_begins(scene: bpy.types.Scene, *_: object) -> None:
    skin_display.prepare_render(scene)


def _render_ended(scene: bpy.types.Scene, *_: object) -> None:
    skin_display.render_ended(scene)


def _before_undo(*_: object) -> None:
    for scene in bpy.data.scenes:
        if scene.library is None:
            take_away(scene)


def _undone(*_: object) -> None:
    skin_display.refresh_all()


def _before_load(*_: object) -> None:
    skin_display.clear_all()
    _looks.clear()


def _loaded(*_: object) -> None:
    _watch_windows()
    skin_display.refresh_all()


def _watch_windows() -> None:
    """A window may turn to a scene whose tissue another scene hid: variants share it."""
    bpy.msgbus.clear_by_owner(_WINDOWS)
    bpy.msgbus.subscribe_rna(
        key=(bpy.types.Window, "scene"), owner=_WINDOWS, args=(), notify=_window_turned, options={"PERSISTENT"}
    )


def _window_turned() -> None:
    scene = bpy.context.scene
    if scene is not None:
        skin_display.refresh(scene)


def _procedure_changed(scene: bpy.types.Scene) -> None:
    """A property changed: only those of the look concern the display at once; a new manifest comes by itself."""
    skin_display.events_changed(scene)
    look = _look_of(scene)
    if _looks.get(scene.session_uid) != look:
        _looks[scene.session_uid] = look
        skin_display.refresh(scene)


_HANDLERS = (
    ("frame_change_pre", persistent(_frame_changed)),
    ("render_init", persistent(_render_begins)),
    ("render_complete", persistent(_render_ended)),
    ("render_cancel", persistent(_render_ended)),
    ("undo_pre", persistent(_before_undo)),
    ("redo_pre", persistent(_before_undo)),
    ("undo_post", persistent(_undone)),
    ("redo_post", persistent(_undone)),
    ("load_pre", persistent(_before_load)),
    ("load_post", persistent(_loaded)),
)


def register() -> None:
    """Add the handlers; those of the solving side come first."""
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)
    changes.subscribe(_procedure_changed)
    frames.subscribe(skin_display.refresh_soon)
    frames.add_follow_up(skin_display.continue_drawing)
    _watch_windows()


def unregister() -> None:
    """Take them away."""
    bpy.msgbus.clear_by_owner(_WINDOWS)
    frames.unsubscribe(skin_display.refresh_soon)
    frames.remove_follow_up(skin_display.continue_drawing)
    changes.unsubscribe(_procedure_changed)
    for name, handler in _HANDLERS:
        handlers = getattr(bpy.app.handlers, name)
        if handler in handlers:
            handlers.remove(handler)
    skin_display.stop()
