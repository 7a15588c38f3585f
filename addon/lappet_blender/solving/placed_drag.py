"""The skin follows a hook or retractor that a tool still places: live mode for what no event of the scene holds yet."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from lappet.procedure import Hook, Pose, Procedure, Retractor, pose_at

from ..model.tissue_values import tissue_is_ready
from .controller import Controller, Job, Live, controller_of, find_controller
from .frames import frame_state, notify_listeners
from .live_drag import send_target, stop_live
from .reconcile import reconcile
from .scene_watch import reading

_QUICK = 0.1  # seconds; a scene that took longer to read is not read while the mouse waits


def place_live(
    scene: bpy.types.Scene, event: Hook | Retractor, grip: NDArray[np.integer[Any]] | None = None
) -> Live | None:
    """Have the skin of the current frame follow a hook or retractor that takes hold in it.

    grip: the faces that a retractor holds, where its group is not made yet. None where somebody would wait for it: the
    frame before is not solved, the worker has another job, the scene has changed and is long to read, or cannot be
    solved.
    """
    controller, time = controller_of(scene), scene.frame_current
    busy = controller.job is not None and not controller.job.cancelled
    if busy or controller.live is not None or not _is_read(scene, controller):
        return None
    known = controller.procedure
    if known is None or not controller.key or not _starts_from_known(scene, time):
        return None
    asked = replace(_gripped(known, event, grip), events=(*known.events, event))
    try:
        number = controller.solver().live(asked, controller.settings, time, event.name, before=known)
    except (RuntimeError, OSError):
        return None  # who solves is told why
    controller.job = Job(number, "live", f"live {number}", asked, controller.settings)
    controller.live = Live(event.name, "", time, number, target=_first_target(event), placing=True)
    controller.notify()
    notify_listeners(scene, controller)
    return controller.live


def pull_live(scene: bpy.types.Scene, live: Live, target: Pose) -> None:
    """Pull it to a place; only the newest counts, and none once the live mode has ended."""
    controller = find_controller(scene)
    if controller is not None and controller.live is live:
        send_target(controller, live, target)


def end_placing(scene: bpy.types.Scene, live: Live | None) -> None:
    """The tool has let go: the skin is shown again as it was."""
    controller = find_controller(scene)
    if live is not None and controller is not None and controller.live is live:
        stop_live(scene, controller, may_key=False)
        notify_listeners(scene, controller)


def _first_target(event: Hook | Retractor) -> Pose:
    return pose_at(event.targets[0][1]) if isinstance(event, Hook) else event.motion[0][1]


def _gripped(procedure: Procedure, event: Hook | Retractor, grip: NDArray[np.integer[Any]] | None) -> Procedure:
    """The procedure with the faces that a retractor holds as a group of its tissue."""
    tissue = procedure.tissue
    if isinstance(event, Hook) or event.grip in tissue.subsets or grip is None:
        return procedure
    return replace(
        procedure, tissue=replace(tissue, subsets={**tissue.subsets, event.grip: np.asarray(grip, np.int32)})
    )


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
