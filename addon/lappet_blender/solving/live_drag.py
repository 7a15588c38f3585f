"""Live mode: while the target of a hook or retractor is dragged, the skin follows as fast as it is solved."""

from __future__ import annotations

import math
from dataclasses import replace
from time import monotonic

import bpy
from mathutils import Matrix, Vector

from lappet.core.problem import RefusedError, refused
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Event, Hook, Pose, Procedure, Retractor, place_of, pose_matrix

from ..model.decimals import decimal
from ..model.event_kinds import HOLD_KINDS
from ..model.event_list import find_event
from ..model.scene_procedure import read_scene
from ..model.target_samples import rigid_pose
from ..model.units import mm_per_unit
from .controller import Controller, Job, Live, controller_of
from .frames import problems_of
from .reconcile import reconcile
from .solve_jobs import refuse_problems, worst_first
from .solve_settings import solve_settings

LEAST_MOVE = 1e-4  # mm


def start_live(scene: bpy.types.Scene, held: str = "") -> Live:
    """Open the current frame with the event of that name or uid (the active one when "") ready to be dragged.

    Raises RefusedError for an event that is neither hook nor retractor, that does not pull at this frame or that has
    no target.
    """
    controller = controller_of(scene)
    if controller.job is not None and not controller.job.cancelled:
        raise refused(ProblemCode.SOLVE_RUNNING)
    reconcile(scene, controller, ask=False)
    refuse_problems(controller.problems)
    if controller.procedure is None or not controller.key:
        raise RefusedError(worst_first(problems_of(scene)))
    event = _held(scene, held)
    time = scene.frame_current
    try:
        number = controller.solver().live(controller.procedure, controller.settings, time, event.name)
    except (RuntimeError, OSError) as error:
        raise refused(ProblemCode.SOLVER_NOT_STARTED, "", error) from error
    job = Job(number, "live", controller.key, controller.procedure, controller.settings, manifest=controller.manifest)
    controller.job, controller.listing, controller.failure = job, None, None
    controller.live = Live(event.name, event.uid, time, number, target=_pose(scene, event.target))
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
    event = find_event(scene, live.event_uid or live.held)
    if not scene.lappet.solving.live or event is None or event.target is None or scene.frame_current != live.time:
        stop_live(scene, controller)
        return
    if live.needs_check:
        live.needs_check = False
        if not _still_holds(scene, controller, live):
            stop_live(scene, controller)
            return
    send_target(controller, live, _pose(scene, event.target))


def send_target(controller: Controller, live: Live, target: Pose) -> None:
    """Have the solver follow to a target, if it is another one than before."""
    if live.target is None or math.dist(target, live.target) > LEAST_MOVE:
        live.target, live.moved, live.stirred_at = target, True, monotonic()
        controller.solver().live_target(live.job, target)


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
    event = find_event(scene, live.event_uid or live.held)
    target = None if event is None else event.target
    turns = event is not None and event.kind == "RETRACTOR"
    keyed = may_key and live.moved and target is not None and _key(scene, target, live, turns)
    controller.mark_dirty()
    controller.notify()
    return keyed


def _key(scene: bpy.types.Scene, target: bpy.types.Object, live: Live, turns: bool) -> bool:
    """Key an animated target where it was last dragged; turns: and how it was turned.

    Elsewhere than at that frame only one that hangs on nothing, since its place in the world is all that is known by
    then.
    """
    data = target.animation_data
    if data is None or data.action is None or target.library is not None or live.target is None:
        return False
    if scene.frame_current != live.time:
        if target.parent is not None or len(target.constraints):
            return False
        now = target.matrix_basis.copy()
        target.matrix_basis = _basis(scene, target, live.target)
        _insert(target, live.time, turns)
        target.matrix_basis = now
        return True
    return _insert(target, live.time, turns)


def _insert(target: bpy.types.Object, time: int, turns: bool) -> bool:
    rotation = {"QUATERNION": "rotation_quaternion", "AXIS_ANGLE": "rotation_axis_angle"}
    paths = ["location", *([rotation.get(target.rotation_mode, "rotation_euler")] if turns else [])]
    inserted = [target.keyframe_insert(path, frame=time) for path in paths]
    return all(inserted)


def _basis(scene: bpy.types.Scene, target: bpy.types.Object, pose: Pose) -> Matrix:
    """What places an object that hangs on nothing at a pose."""
    place = Vector(place_of(pose)) / mm_per_unit(scene)
    return Matrix.LocRotScale(place, Matrix(pose_matrix(pose).tolist()).to_quaternion(), target.scale)


def _still_holds(scene: bpy.types.Scene, controller: Controller, live: Live) -> bool:
    """Whether the procedure is what live mode began with, but for where it is dragged."""
    procedure, job = read_scene(scene).procedure, controller.job
    if procedure is None or job is None or solve_settings(scene) != job.settings:
        return False

    def without_target(of: Procedure) -> Procedure:
        return replace(of, events=tuple(_without_target(e) if e.name == live.held else e for e in of.events))

    return without_target(procedure) == without_target(job.procedure)


def _without_target(event: Event) -> Event:
    if isinstance(event, Hook):
        return replace(event, targets=())
    return replace(event, motion=()) if isinstance(event, Retractor) else event


def _held(scene: bpy.types.Scene, name: str):  # type: ignore[no-untyped-def]
    events = scene.lappet.events
    active = scene.lappet.active_event
    event = find_event(scene, name) if name else events[active] if 0 <= active < len(events) else None
    if event is None:
        raise refused(ProblemCode.LIVE_NO_EVENT, "", name or "none is active")
    if event.kind not in HOLD_KINDS:
        raise refused(ProblemCode.LIVE_NOT_A_HOOK, event.name)
    if not event.enabled or not decimal(event.start) <= scene.frame_current < decimal(event.end):
        span = {"start": event.start, "end": event.end}
        raise refused(ProblemCode.HOOK_NOT_PULLING, event.name, scene.frame_current, **span)
    if event.target is None:
        raise refused(ProblemCode.EVENT_TARGET_MISSING, event.name, "is not set")
    return event


def _pose(scene: bpy.types.Scene, target: bpy.types.Object) -> Pose:
    """Where a target is, in mm, and how it is turned, as evaluated with what it hangs on."""
    for layer in scene.view_layers:
        layer.update()
        matrix = target.evaluated_get(layer.depsgraph).matrix_world
        return rigid_pose(matrix.translation, matrix.to_quaternion(), mm_per_unit(scene))
    raise AssertionError("a scene has a view layer")
