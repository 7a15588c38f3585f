"""Live mode: while a hook's target is dragged, the skin follows as fast as it is solved."""

from __future__ import annotations

import math
from dataclasses import replace

import bpy

from lappet.core.problem import RefusedError, refused
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Hook, Procedure

from ..model.decimals import decimal
from ..model.event_list import find_event
from ..model.scene_procedure import read_scene
from ..model.units import mm_per_unit
from .controller import Controller, Job, Live, controller_of
from .frames import problems_of
from .reconcile import reconcile
from .solve_jobs import refuse_problems, worst_first
from .solve_settings import solve_settings

LEAST_MOVE = 1e-4  # mm


def start_live(scene: bpy.types.Scene, hook: str = "") -> Live:
    """Open the current frame with the hook of that name or uid (the active event when "") ready to be dragged.

    Raises RefusedError for an event that is no hook, that does not pull at this frame or that has no target.
    """
    controller = controller_of(scene)
    if controller.job is not None and not controller.job.cancelled:
        raise refused(ProblemCode.SOLVE_RUNNING)
    reconcile(scene, controller, ask=False)
    refuse_problems(controller.problems)
    if controller.procedure is None or not controller.key:
        raise RefusedError(worst_first(problems_of(scene)))
    event = _hook(scene, hook)
    time = scene.frame_current
    try:
        number = controller.solver().live(controller.procedure, controller.settings, time, event.name)
    except (RuntimeError, OSError) as error:
        raise refused(ProblemCode.SOLVER_NOT_STARTED, "", error) from error
    job = Job(number, "live", controller.key, controller.procedure, controller.settings, manifest=controller.manifest)
    controller.job, controller.listing, controller.failure = job, None, None
    controller.live = Live(event.name, event.uid, time, number, target=_place(scene, event.target))
    scene.lappet.solving.live = True
    controller.notify()
    return controller.live


def step_live(scene: bpy.types.Scene, controller: Controller) -> None:
    """Send the target's place where it has moved; ends live mode where it was switched off or its ground is gone."""
    live = controller.live
    if live is None:
        if scene.lappet.solving.live:
            scene.lappet.solving.live = False
        return
    if live.placing:
        if scene.frame_current != live.time:
            stop_live(scene, controller)
        return
    event = find_event(scene, live.event_uid or live.hook)
    if not scene.lappet.solving.live or event is None or event.target is None or scene.frame_current != live.time:
        stop_live(scene, controller)
        return
    if live.needs_check:
        live.needs_check = False
        if not _still_holds(scene, controller, live):
            stop_live(scene, controller)
            return
    place = _place(scene, event.target)
    if live.target is None or math.dist(place, live.target) > LEAST_MOVE:
        live.target, live.moved = place, True
        controller.solver().live_target(live.job, place)


def stop_live(scene: bpy.types.Scene, controller: Controller, *, may_key: bool = True) -> bool:
    """End live mode, and return whether a keyframe was set.

    The target stays where it was dragged: one that is animated is keyed there, at the frame that was shown, unless
    `may_key` is off.
    """
    live, controller.live = controller.live, None
    if live is None:
        return False
    if controller.client is not None:
        controller.client.cancel(live.job)
    if controller.job is not None and controller.job.number == live.job:
        controller.job.cancelled = True
    if live.placing:
        controller.notify()
        return False
    scene.lappet.solving.live = False
    event = find_event(scene, live.event_uid or live.hook)
    target = None if event is None else event.target
    keyed = may_key and live.moved and target is not None and _key(scene, target, live)
    controller.mark_dirty()
    controller.notify()
    return keyed


def _key(scene: bpy.types.Scene, target: bpy.types.Object, live: Live) -> bool:
    """Key an animated target where it was last dragged.

    Elsewhere than at that frame only one that hangs on nothing, since its place in the world is all that is known by
    then.
    """
    data = target.animation_data
    if data is None or data.action is None or target.library is not None or live.target is None:
        return False
    if scene.frame_current != live.time:
        if target.parent is not None or len(target.constraints):
            return False
        now = target.location.copy()
        target.location = [value / mm_per_unit(scene) for value in live.target]
        target.keyframe_insert("location", frame=live.time)
        target.location = now
        return True
    return bool(target.keyframe_insert("location", frame=live.time))


def _still_holds(scene: bpy.types.Scene, controller: Controller, live: Live) -> bool:
    """Whether the procedure is what live mode began with, but for where the dragged hook pulls."""
    procedure, job = read_scene(scene).procedure, controller.job
    if procedure is None or job is None or solve_settings(scene) != job.settings:
        return False

    def without_target(of: Procedure) -> Procedure:
        events = (replace(e, targets=()) if isinstance(e, Hook) and e.name == live.hook else e for e in of.events)
        return replace(of, events=tuple(events))

    return without_target(procedure) == without_target(job.procedure)


def _hook(scene: bpy.types.Scene, hook: str):  # type: ignore[no-untyped-def]
    events = scene.lappet.events
    active = scene.lappet.active_event
    event = find_event(scene, hook) if hook else events[active] if 0 <= active < len(events) else None
    if event is None:
        raise refused(ProblemCode.LIVE_NO_EVENT, "", hook or "none is active")
    if event.kind != "HOOK":
        raise refused(ProblemCode.LIVE_NOT_A_HOOK, event.name)
    if not event.enabled or not decimal(event.start) <= scene.frame_current < decimal(event.end):
        span = {"start": event.start, "end": event.end}
        raise refused(ProblemCode.HOOK_NOT_PULLING, event.name, scene.frame_current, **span)
    if event.target is None:
        raise refused(ProblemCode.EVENT_TARGET_MISSING, event.name, "is not set")
    return event


def _place(scene: bpy.types.Scene, target: bpy.types.Object) -> tuple[float, float, float]:
    """Where a target is, in mm, as evaluated with what it hangs on."""
    for layer in scene.view_layers:
        layer.update()
        place = target.evaluated_get(layer.depsgraph).matrix_world.translation
        x, y, z = (decimal(v) * mm_per_unit(scene) for v in place)
        return (x, y, z)
    raise AssertionError("a scene has a view layer")
