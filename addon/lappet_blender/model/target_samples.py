"""Where the empty of a hook or retractor is, frame by frame, as the samples that a procedure takes.

Straight keyframes are taken as they are. What moves otherwise (curved keyframes, a parent, constraints, drivers) is
sampled at every frame; what only Blender's own evaluation knows is looked up in a scene made for it and removed again,
so that the user's scene, its frame and poses without a keyframe stay untouched.
"""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
from mathutils import Euler, Matrix, Quaternion, Vector
from numpy.typing import NDArray

from lappet.procedure import Pose

from .decimals import decimal
from .event_target import active_fcurves
from .units import mm_per_unit

Triple = tuple[float, float, float]
_ROTATIONS = ("rotation_euler", "rotation_quaternion", "rotation_axis_angle")
_stamp = 0
_evaluated: dict[tuple[object, ...], tuple[int, list[Matrix]]] = {}


def mark_dirty() -> None:
    """Have targets sampled again: objects that they depend on may move differently now."""
    global _stamp
    _stamp += 1


def hook_samples(
    scene: bpy.types.Scene, target: bpy.types.Object, start: float, release: float
) -> tuple[tuple[float, Triple], ...]:
    """(frame, place in mm) samples of a hook's target, to be joined by straight lines."""
    unit = mm_per_unit(scene)

    def at(place: Any) -> Triple:
        x, y, z = (decimal(v) * unit for v in place)
        return (x, y, z)

    if not is_plain(target):
        frames = _frames(scene, start, release)
        matrices = _matrices(scene, target, frames)
        return tuple((frame, at(matrix.translation)) for frame, matrix in zip(frames, matrices, strict=True))
    curves = active_fcurves(target)
    places = [curve for (path, _), curve in curves.items() if path == "location"]
    times = _key_times(places) if _are_straight(places) else _frames(scene, start, release)
    return tuple((time, at(_location(target, curves, time))) for time in times or [start])


def motion_samples(
    scene: bpy.types.Scene, target: bpy.types.Object, start: float, release: float
) -> tuple[tuple[float, tuple[float, ...]], ...]:
    """Sample a retractor's motion, without scale.

    The samples are (frame, 4x4 row-major matrix in USD's row-vector convention, mm).
    """
    unit = mm_per_unit(scene)
    if not is_plain(target):
        frames = _frames(scene, start, release)
        matrices = _matrices(scene, target, frames)
        return tuple(
            (frame, rigid_pose(matrix.translation, matrix.to_quaternion(), unit))
            for frame, matrix in zip(frames, matrices, strict=True)
        )
    curves = active_fcurves(target)
    moving = [curve for (path, _), curve in curves.items() if path == "location" or path in _ROTATIONS]
    turns = any(_turns(curve) for (path, _), curve in curves.items() if path in _ROTATIONS)
    # Between keyframes Blender turns along Euler angles or along a chord, a procedure along the shortest arc.
    times = _key_times(moving) if _are_straight(moving) and not turns else _frames(scene, start, release)
    return tuple(
        (time, rigid_pose(_location(target, curves, time), _rotation(target, curves, time), unit))
        for time in times or [start]
    )


def is_plain(target: bpy.types.Object) -> bool:
    """Whether its own channels are all that places it in the world."""
    data = target.animation_data
    return (
        target.parent is None
        and not len(target.constraints)
        and not any(target.delta_location)
        and not any(target.delta_rotation_euler)
        and tuple(target.delta_rotation_quaternion) == (1.0, 0.0, 0.0, 0.0)
        and target.rigid_body is None
        and (data is None or (not len(data.drivers) and not len(data.nla_tracks) and data.action_influence == 1.0))
    )


def _are_straight(curves: list[Any]) -> bool:
    """Whether straight lines between the keyframes, held at the ends, are what these F-curves do."""
    return all(
        curve.extrapolation == "CONSTANT"
        and not len(curve.modifiers)
        and all(key.interpolation == "LINEAR" for key in list(curve.keyframe_points)[:-1])
        for curve in curves
    )


def _turns(curve: Any) -> bool:
    return bool(len(curve.modifiers)) or len({key.co[1] for key in curve.keyframe_points}) > 1


def _key_times(curves: list[Any]) -> list[float]:
    return sorted({decimal(key.co[0]) for curve in curves for key in curve.keyframe_points})


def _frames(scene: bpy.types.Scene, start: float, release: float) -> list[float]:
    """The start and every whole frame from there to the release, as far as the scene goes."""
    last = min(release, max(float(scene.frame_end), start))
    return sorted({start, *(float(frame) for frame in range(int(np.ceil(start)), int(np.floor(last)) + 1))})


def _channel(target: bpy.types.Object, curves: dict[tuple[str, int], Any], path: str, time: float) -> list[float]:
    fixed = getattr(target, path)
    return [curves[path, i].evaluate(time) if (path, i) in curves else fixed[i] for i in range(len(fixed))]


def _location(target: bpy.types.Object, curves: dict[tuple[str, int], Any], time: float) -> list[float]:
    return _channel(target, curves, "location", time)


def _rotation(target: bpy.types.Object, curves: dict[tuple[str, int], Any], time: float) -> Quaternion:
    mode = target.rotation_mode
    if mode == "QUATERNION":
        return Quaternion(_channel(target, curves, "rotation_quaternion", time)).normalized()
    if mode == "AXIS_ANGLE":
        angle, *axis = _channel(target, curves, "rotation_axis_angle", time)
        return Quaternion(Vector(axis), angle)
    return Euler(_channel(target, curves, "rotation_euler", time), mode).to_quaternion()


def rigid_pose(place: Any, turn: Quaternion, unit: float) -> Pose:
    """The pose of something at a place, in units of `unit` mm, with a turn."""
    w, x, y, z = np.array(turn[:], np.float64) / np.linalg.norm(np.array(turn[:], np.float64))
    rows: NDArray[np.float64] = np.eye(4)
    # The transpose of the column-vector rotation matrix of a quaternion.
    rows[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
        [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
        [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)],
    ]
    rows[3, :3] = [decimal(v) * unit for v in place]
    return tuple(float(v) for v in rows.ravel())


def _matrices(scene: bpy.types.Scene, target: bpy.types.Object, frames: list[float]) -> list[Matrix]:
    """The world matrices of an object as Blender evaluates them at frames."""
    key = (scene.session_uid, target.session_uid, *frames)
    known = _evaluated.get(key)
    if known is not None and known[0] == _stamp:
        return known[1]
    try:
        matrices = _evaluate(scene, target, frames)
    except (AttributeError, RuntimeError):  # nothing may be made while Blender draws: what was last known, or here
        return known[1] if known is not None else [target.matrix_world.copy()] * len(frames)
    _evaluated[key] = (_stamp, matrices)
    return matrices


def _evaluate(scene: bpy.types.Scene, target: bpy.types.Object, frames: list[float]) -> list[Matrix]:
    view = bpy.data.scenes.new("Lappet sampling")
    try:
        view.frame_start, view.frame_end = scene.frame_start, scene.frame_end
        view.render.fps, view.render.fps_base = scene.render.fps, scene.render.fps_base
        view.collection.objects.link(target)
        matrices = []
        for frame in frames:
            whole = int(np.floor(frame))
            view.frame_set(whole, subframe=frame - whole)
            evaluated = target.evaluated_get(view.view_layers[0].depsgraph)
            matrices.append(evaluated.matrix_world.copy())
    finally:
        bpy.data.scenes.remove(view)
    return matrices
