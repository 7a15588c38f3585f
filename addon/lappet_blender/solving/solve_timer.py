"""The timer of the solving side: takes in what workers tell, reads scenes that changed, follows a dragged hook."""

from __future__ import annotations

import time
import traceback

import bpy

from ..model.tissue_values import tissue_is_ready
from .controller import Controller, controller_of, controllers, drop, find_controller, scene_of
from .frames import follow_up, notify_listeners
from .live_drag import step_live
from .reconcile import due, finish_copying
from .scene_watch import check_polled_state, read_now
from .worker_events import handle_worker_events

FIRST_INTERVAL = 0.1
_LIVE, _BUSY, _IDLE = 0.01, 0.04, 0.25  # seconds until the timer comes by again
_STILL_SECONDS = 1.0  # after the last target and the last frame of live mode
_REDRAW_SECONDS = 0.1
_DRAGGING = ("TRANSFORM_OT_",)  # modal operators during which nothing is read: their end is a change as well
_drawn_at = 0.0
_redraw_wanted = False


def run_timer(timeout: float = 0.0) -> bool:
    """Do what the timer does: once, or until nothing is under way or `timeout` seconds have passed.

    Returns whether something is still under way: a job, a change that was not read yet, a picture to be finished.
    """
    end = time.monotonic() + timeout
    while True:
        busy = _once()
        if not busy or time.monotonic() >= end:
            return busy
        time.sleep(0.005)


def _once() -> bool:
    global _redraw_wanted
    busy = notified = False
    dragging = _is_dragging()
    for scene in list(bpy.data.scenes):
        controller = find_controller(scene)
        if controller is None:
            if scene.lappet.tissue.object is None:
                continue
            controller = controller_of(scene)
        check_polled_state(scene, controller)
        heard = handle_worker_events(controller)
        finish_copying(controller)
        step_live(scene, controller)
        if due(controller) and not dragging and controller.live is None and tissue_is_ready(scene):
            read_now(scene, notify=False)
            busy = True
            continue  # what was read is shown in a turn of its own
        busy |= _busy(controller)
        notified |= controller.notified != controller.revision
        _redraw_wanted |= heard or notified
        notify_listeners(scene, controller)
    for controller in controllers():
        if scene_of(controller) is None:
            drop(controller)
    busy |= notified or follow_up()  # one of them per slice
    if _redraw_wanted:
        _redraw()
    return busy


def _busy(controller: Controller) -> bool:
    waiting = controller.dirty_since is not None or controller.copying is not None
    return waiting or any(True for _ in controller.jobs())


def _follows(controller: Controller) -> bool:
    """Whether the skin follows a target now; one that lies still is looked at as seldom as a solve."""
    return controller.live is not None and time.monotonic() - controller.live.stirred_at < _STILL_SECONDS


def _is_dragging() -> bool:
    """Whether the user is moving something with the mouse right now."""
    manager = bpy.context.window_manager
    for window in manager.windows if manager is not None else ():
        for operator in getattr(window, "modal_operators", ()):
            if operator.bl_idname.startswith(_DRAGGING):
                return True
    return False


def _redraw() -> None:
    """Have the views and timelines drawn again, ten times a second at most."""
    global _drawn_at, _redraw_wanted
    now = time.monotonic()
    if bpy.app.background or now - _drawn_at < _REDRAW_SECONDS:
        return
    _drawn_at, _redraw_wanted = now, False
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type in ("VIEW_3D", "DOPESHEET_EDITOR"):
                area.tag_redraw()


def _timer() -> float:
    if bpy.app.is_job_running("RENDER"):
        return _IDLE  # what is rendered must not change under its hands
    try:
        busy = run_timer()
    except Exception:  # an exception would end the timer, and with it every solve of the session
        traceback.print_exc()
        return 1.0
    if any(_follows(controller) for controller in controllers()):
        return _LIVE
    return _BUSY if busy else _IDLE


def register() -> None:
    """Start the timer."""
    bpy.app.timers.register(_timer, first_interval=FIRST_INTERVAL, persistent=True)


def unregister() -> None:
    """Stop the timer."""
    if bpy.app.timers.is_registered(_timer):
        bpy.app.timers.unregister(_timer)
