"""The skin follows a hook that a tool is still placing: live mode for a hook that no event of the scene holds yet."""

from __future__ import annotations

import math
from dataclasses import replace

import bpy

from lappet.procedure import Hook, Point

from ..model.tissue_values import tissue_is_ready
from .controller import Controller, Job, Live, controller_of, find_controller
from .frames import frame_state, notify_listeners
from .live_hook import LEAST_MOVE, stop_live
from .reconcile import reconcile
from .scene_watch import reading

_QUICK = 0.1  # seconds; a scene that took longer to read is not read while the mouse waits


def place_live(scene: bpy.types.Scene, hook: Hook) -> Live | None:
    """Have the skin of the current frame follow a hook that takes hold in it.

    None where somebody would wait for it: the frame before is not solved, the worker has another job, the scene has
    changed and is long to read, or cannot be solved.
    """
    controller, time = controller_of(scene), scene.frame_current
    busy = controller.job is not None and not controller.job.cancelled
    if busy or controller.live is not None or not _is_read(scene, controller):
        return None
    procedure = controller.procedure
    if procedure is None or not controller.key or not _starts_from_known(scene, time):
        return None
    asked = replace(procedure, events=(*procedure.events, hook))
    try:
        number = controller.solver().live(asked, controller.settings, time, hook.name)
    except (RuntimeError, OSError):
        return None  # who solves is told why
    controller.job = Job(number, "live", f"live {number}", asked, controller.settings)
    controller.live = Live(hook.name, "", time, number, target=hook.targets[0][1], placing=True)
    controller.notify()
    notify_listeners(scene, controller)
    return controller.live


def pull_live(scene: bpy.types.Scene, live: Live, target: Point) -> None:
    """Pull the hook to a place, mm; only the newest counts, and none once the live mode has ended."""
    controller = find_controller(scene)
    if controller is None or controller.live is not live:
        return
    if live.target is None or math.dist(target, live.target) > LEAST_MOVE:
        live.target, live.moved = target, True
        controller.solver().live_target(live.job, target)


def end_placing(scene: bpy.types.Scene, live: Live | None) -> None:
    """The tool has let go of the hook: the skin is shown again as it was."""
    controller = find_controller(scene)
    if live is not None and controller is not None and controller.live is live:
        stop_live(scene, controller, may_key=False)
        notify_listeners(scene, controller)


def _is_read(scene: bpy.types.Scene, controller: Controller) -> bool:
    """Whether the procedure is known as it is now; read here where that is quick."""
    if controller.dirty_since is None:
        return True
    if controller.read_seconds > _QUICK or not tissue_is_ready(scene):
        return False
    with reading():
        reconcile(scene, controller, ask=False)
    return True


def _starts_from_known(scene: bpy.types.Scene, time: int) -> bool:
    """Whether the state from which the frame is solved is there: that of the frame before, or rest."""
    return time == scene.frame_start or (time > scene.frame_start and frame_state(scene, time - 1) == "solved")
