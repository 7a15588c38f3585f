"""An event of a scene as the value that a procedure holds (`lappet.procedure.procedure`), and back."""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.geometry.rigid_motion import RigidMotion
from lappet.procedure import (
    Event,
    Excision,
    Hook,
    Incision,
    Landmark,
    Point,
    Retractor,
    Suture,
    SutureRun,
    Thin,
    Undermine,
)

from .changes import changed
from .decimals import decimal
from .event_kinds import BASIS_OF, MODE_OF, THREAD_OF
from .event_list import add_event, event_time, numbered_name, set_points, target_name, unique_name
from .event_target import is_there, make_target, set_keyframes
from .exact_numbers import keep_exact, with_exact
from .suture_run_values import run_value, set_run
from .target_samples import hook_samples, motion_samples
from .units import mm_per_unit, to_world

_BASIS_NAMES = {basis: name for name, basis in BASIS_OF.items()}
TARGET_MM = 1.0  # radius at which a target is drawn


def event_value(scene: bpy.types.Scene, event: Any) -> Event:
    """The value of an event; whether it makes sense is for `lappet.checks.validation` to say.

    Raises RefusedError ("what is wrong; the remedy") where the target of a hook or retractor is not in the scene, or a
    hook or suture has not the points that it needs.
    """
    value: Event = with_exact(event, _shown_value(scene, event))
    return value


def _shown_value(scene: bpy.types.Scene, event: Any) -> Event:
    """The value that the properties show."""
    name, time = str(event.name), event_time(event)
    points = _points(event)
    basis = BASIS_OF[event.basis]
    match event.kind:
        case "INCISION":
            depth = None if event.through else decimal(event.depth)
            x, y, z = (decimal(value) for value in event.direction)
            direction = (x, y, z) if (x, y, z) != (0.0, 0.0, 0.0) else None
            return Incision(name, time, points, depth, decimal(event.kerf), basis, bool(event.closed), direction)
        case "EXCISION":
            return Excision(name, time, points)
        case "UNDERMINE":
            return Undermine(name, time, points, basis)
        case "THIN":
            dressing, duration = decimal(event.dressing), decimal(event.duration)
            return Thin(name, time, points, decimal(event.thickness), basis, dressing, duration)
        case "HOOK":
            (anchor,) = _exactly(event, points, 1)
            release = decimal(event.end)
            targets = hook_samples(scene, _followed(scene, event), time, release)
            return Hook(name, anchor, targets, time, release, decimal(event.stiffness))
        case "RETRACTOR":
            release = decimal(event.end)
            motion = motion_samples(scene, _followed(scene, event), time, release)
            return Retractor(name, str(event.grip), motion, time, release)
        case "SUTURE":
            if len(points) < 2:
                raise refused(ProblemCode.EVENT_POINT_COUNT, event.name, len(points), need=2)
            return Suture(
                name,
                points,
                time,
                decimal(event.duration),
                decimal(event.stiffness),
                MODE_OF[event.mode],
                THREAD_OF[event.thread],
                decimal(event.length),
                decimal(event.tension),
                decimal(event.pull_through),
            )
        case "SUTURE_RUN":
            return run_value(event, name, time, points)
        case _:
            return Landmark(name, points, str(event.label))


def free_name(scene: bpy.types.Scene, kind: str, name: str = "", taken: Collection[str] = ()) -> str:
    """The name that a new event of a kind gets: as near to `name` as may be, "" = kind and number.

    taken: names that others are about to get.
    """
    names = {*taken, *(event.name for event in scene.lappet.events)}
    return unique_name(name, names) if name else numbered_name(kind, names)


def kind_of(value: Event) -> str:
    """The kind of the event that holds a value."""
    return "SUTURE_RUN" if isinstance(value, SutureRun) else type(value).__name__.upper()


def add_value(scene: bpy.types.Scene, value: Event) -> Any:
    """Add a value as an event of its kind, by its own name where that is free, and return the event."""
    event = add_event(scene, kind_of(value), value.name)
    set_event(scene, event, value)
    return event


def set_event(scene: bpy.types.Scene, event: Any, value: Event) -> None:
    """Give an event the values of a procedure's; its kind must be the value's and its name is left alone.

    The empty of a hook gets straight keyframes at the samples, that of a retractor keyframes that follow its motion at
    every whole frame while it turns; both are made where the event has none.
    """
    match value:
        case Incision():
            event.start, event.kerf, event.closed = value.time, value.kerf, value.closed
            event.through = value.depth is None
            if value.depth is not None:
                event.depth = value.depth
            event.basis = _BASIS_NAMES[value.basis]
            event.direction = value.direction or (0.0, 0.0, 0.0)
            set_points(event, value.points)
        case Excision():
            event.start = value.time
            set_points(event, value.seeds)
        case Undermine():
            event.start, event.basis = value.time, _BASIS_NAMES[value.basis]
            set_points(event, value.points)
        case Thin():
            event.start, event.basis = value.time, _BASIS_NAMES[value.basis]
            event.thickness, event.dressing, event.duration = value.thickness, value.dressing, value.duration
            set_points(event, value.points)
        case Hook():
            event.start, event.end, event.stiffness = value.start, value.release, value.stiffness
            set_points(event, [value.anchor])
            places = [(time, to_world(scene, place)) for time, place in sorted(value.targets)]
            set_keyframes(_target(scene, event), "location", places)
        case Retractor():
            event.start, event.end, event.grip = value.start, value.release, value.grip
            _set_motion(scene, _target(scene, event), value)
        case Suture():
            event.start, event.duration, event.stiffness = value.start, value.duration, value.stiffness
            event.mode = next(name for name, mode in MODE_OF.items() if mode == value.mode)
            event.thread = next((name for name, thread in THREAD_OF.items() if thread == value.thread), "NONE")
            event.length, event.tension, event.pull_through = value.length, value.tension, value.pull_through
            set_points(event, value.anchors)
        case SutureRun():
            set_run(event, value)
        case Landmark():
            event.start = scene.frame_start
            event.label = value.label
            set_points(event, value.points)
    keep_exact(event, value)
    changed(scene)


def _points(event: Any) -> tuple[Point, ...]:
    return tuple((decimal(x), decimal(y), decimal(z)) for x, y, z in (point.co for point in event.points))


def _exactly(event: Any, points: tuple[Point, ...], count: int) -> tuple[Point, ...]:
    if len(points) != count:
        raise refused(ProblemCode.EVENT_POINT_COUNT, event.name, len(points), need=count)
    return points


def _followed(scene: bpy.types.Scene, event: Any) -> bpy.types.Object:
    if not is_there(scene, event.target):
        what = "is not set" if event.target is None else f"{event.target.name!r} is not in the scene any more"
        raise refused(ProblemCode.EVENT_TARGET_MISSING, event.name, what)
    return event.target


def _target(scene: bpy.types.Scene, event: Any) -> bpy.types.Object:
    if event.target is None:
        event.target = make_target(scene, target_name(event.name), event.uid, TARGET_MM / mm_per_unit(scene))
    return event.target


def _set_motion(scene: bpy.types.Scene, target: bpy.types.Object, value: Retractor) -> None:
    """Keyframes of place and turn; quaternions, with a keyframe at each whole frame between samples that turn."""
    samples = sorted(value.motion)
    matrices = {time: np.array(matrix, np.float64).reshape(4, 4).T for time, matrix in samples}
    rotations = [matrix[:3, :3] for matrix in matrices.values()]
    if any(not np.allclose(rotation, rotations[0], atol=1e-7) for rotation in rotations):
        motion, first = RigidMotion(value.motion), matrices[samples[0][0]]
        low, high = min(matrices), max(matrices)
        for frame in range(math.ceil(low), math.floor(high) + 1):
            matrices.setdefault(float(frame), motion.at(frame) @ first)
    target.rotation_mode = "QUATERNION"
    places: list[tuple[float, Any]] = []
    turns: list[tuple[float, Any]] = []
    for time in sorted(matrices):
        matrix = Matrix(matrices[time].tolist())
        turn = matrix.to_quaternion()
        if turns and turn.dot(turns[-1][1]) < 0.0:
            turn.negate()
        places.append((time, to_world(scene, matrix.translation)))
        turns.append((time, turn))
    set_keyframes(target, "location", places)
    set_keyframes(target, "rotation_quaternion", turns)
