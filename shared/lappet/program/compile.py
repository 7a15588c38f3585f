"""Compile a procedure and its epochs to the program that the daemon is told: per frame, the constraints."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Place, refused
from lappet.core.problem_code import ProblemCode
from lappet.cutting.epoch import Epoch
from lappet.cutting.epochs import build_epochs
from lappet.geometry.rigid_motion import RigidMotion
from lappet.procedure import Event, Hook, Landmark, Point, Procedure, Retractor, Suture
from lappet.procedure.prim_paths import ROOT
from lappet.program.anchors import AnchorTie, Tied, TissueLoss
from lappet.program.bones import over_bone, united_bones
from lappet.program.materials import activation, materials_in_use, parameters, region_program
from lappet.program.program import FrameConstraints, Landmarks, Program
from lappet.program.settings import SolverSettings

DEFAULT = SolverSettings()


def compile_program(
    procedure: Procedure,
    epochs: Sequence[Epoch] | None = None,
    settings: SolverSettings = DEFAULT,
    *,
    until: float | None = None,
) -> Program:
    """Compile a procedure: a frame for every integer time code from its start to its end.

    A frame belongs to the last epoch that starts at or before it. Hook targets are linear between samples and held at
    the ends. A hook or retractor acts from `start` until before `release`; a suture from `start` on, its closure
    growing linearly over `duration`.

    Parameters
    ----------
    procedure
        The procedure.
    epochs
        Its epochs in order, as `lappet.cutting.epochs` makes them; made here when None.
    settings
        How to solve; what they say of the tissue is replaced by the procedure's own.
    until
        Time code after which frames are left out.

    Returns
    -------
    Program
        The program.

    Raises
    ------
    RefusedError
        If an anchor is off the tissue or its tissue is excised, two retractors grip one face, a motion is not rigid, a
        bone is not closed, the timeline has no frame, or a material or the faces of a region are not there; names the
        prim.
    """
    spacing = settings.spacing or procedure.tissue.spacing
    if epochs is None:
        # The spacing also says how finely the surface is divided.
        epochs = build_epochs(replace(procedure, tissue=replace(procedure.tissue, spacing=spacing)))
    materials = materials_in_use(procedure)
    regions = region_program(procedure, materials)
    bones = united_bones(procedure.bones)
    epochs = [replace(epoch, regions=regions, over_bone=over_bone(epoch.surface, bones)) for epoch in epochs]
    times = frame_times(procedure)
    if until is not None:
        times = [time for time in times if time <= until]
    belongs = [_epoch_at(epochs, time) for time in times]
    hooks = [event for event in procedure.events if isinstance(event, Hook)]
    by_start = sorted(hooks, key=lambda event: event.start)
    numbers = {hook.name: number for number, hook in enumerate(by_start)}
    sutures = sorted((event for event in procedure.events if isinstance(event, Suture)), key=lambda event: event.start)
    retractors = sorted(
        (event for event in procedure.events if isinstance(event, Retractor)), key=lambda event: event.start
    )
    marks = [(event, point) for event in procedure.events if isinstance(event, Landmark) for point in event.points]
    motions = [_motion(retractor) for retractor in retractors]
    loss = TissueLoss(procedure)
    _refuse_off_tissue(procedure, loss)
    # All anchors: those of hooks, two of each suture, landmarks.
    anchored = [
        *(hook.anchor for hook in hooks),
        *(anchor for suture in sutures for anchor in suture.anchors),
        *(point for _, point in marks),
    ]
    anchors = np.array(anchored, np.float64).reshape(-1, 3)
    first_suture, first_mark = len(hooks), len(hooks) + 2 * len(sutures)
    frames: list[FrameConstraints] = []
    grips: list[NDArray[np.int32]] = []
    landmarks: list[Landmarks] = []
    for epoch in epochs:
        own = [time for time, index in zip(times, belongs, strict=True) if index == epoch.index]
        grips.append(_grips(epoch, retractors, own))
        tied = AnchorTie(epoch.surface, loss.margin).tie(anchors)
        lost = loss.is_lost(anchors, tied)
        landmarks.append(_landmarks(tied[first_mark:], lost[first_mark:]))
        hook_ties = {
            i: _tied(hook, slice(i, i + 1), hook.start, hook.release, own, tied, lost) for i, hook in enumerate(hooks)
        }
        suture_ties = {
            i: _tied(suture, slice(row, row + 2), suture.start, math.inf, own, tied, lost)
            for i, (suture, row) in enumerate(zip(sutures, range(first_suture, first_mark, 2), strict=True))
        }
        for time in own:
            pulled = [i for i, hook in enumerate(hooks) if hook.start <= time < hook.release]
            frames.append(
                FrameConstraints(
                    time=float(time),
                    epoch=epoch.index,
                    hook_index=np.array([numbers[hooks[i].name] for i in pulled], np.int32),
                    **_hook_arrays(hooks, pulled, hook_ties, time),
                    **_suture_arrays(sutures, suture_ties, time),
                    **_retractor_arrays(retractors, motions, time),
                    activation=activation(materials, time),
                )
            )
    gravity = procedure.tissue.gravity
    origin = np.asarray(procedure.tissue.points, np.float64).min(axis=0)
    return Program(
        epochs=tuple(epochs),
        frames=tuple(frames),
        settings=replace(
            settings,
            spacing=spacing,
            origin=(float(origin[0]), float(origin[1]), float(origin[2])),
            bed_stiffness=procedure.tissue.bed_stiffness,
            gravity=(0.0, 0.0, -gravity if gravity else 0.0),
            sutures=len(sutures),
            retractors=len(retractors),
            materials=tuple(parameters(material) for material in materials),
        ),
        fps=procedure.fps,
        hooks=tuple(hook.name for hook in by_start),
        sutures=tuple(suture.name for suture in sutures),
        retractors=tuple(retractor.name for retractor in retractors),
        landmarks=_labels(marks),
        grips=tuple(grips),
        landmarks_at=tuple(landmarks),
        bones=bones,
    )


def frame_times(procedure: Procedure) -> list[int]:
    """List the integer time codes from the procedure's start to its end.

    Parameters
    ----------
    procedure
        The procedure.

    Returns
    -------
    list[int]
        The time codes.

    Raises
    ------
    RefusedError
        If there is none.
    """
    first, last = math.ceil(procedure.start_time), math.floor(procedure.end_time)
    if first > last:
        start, end = procedure.start_time, procedure.end_time
        raise refused(ProblemCode.TIMELINE_NO_FRAME, ROOT, f"{start:g} to {end:g}", start=start, end=end)
    return list(range(first, last + 1))


def _epoch_at(epochs: Sequence[Epoch], time: float) -> int:
    """The index of the last epoch that starts at or before `time`; the first one before that."""
    past = [epoch.index for epoch in epochs if epoch.start_time <= time]
    return past[-1] if past else epochs[0].index


def _refuse_off_tissue(procedure: Procedure, loss: TissueLoss) -> None:
    placed: list[tuple[Event, Sequence[Point]]] = []
    for event in procedure.events:
        if isinstance(event, Hook):
            placed.append((event, [event.anchor]))
        elif isinstance(event, Suture):
            placed.append((event, event.anchors))
        elif isinstance(event, Landmark):
            placed.append((event, event.points))
    if not placed:
        return
    every = loss.distance([point for _, points in placed for point in points])
    ends = np.cumsum([len(points) for _, points in placed])
    for (event, points), distances in zip(placed, np.split(every, ends[:-1]), strict=True):
        if loss.is_off(distances).any():
            worst = int(np.argmax(distances))
            at, code = points[worst], ProblemCode.PROGRAM_POINT_OFF_TISSUE
            raise refused(code, _path(event), _mm(at), place=Place.at(at), off=distances[worst])


def _tied(
    event: Hook | Suture,
    rows: slice,
    start: float,
    release: float,
    own: Sequence[int],
    every: Tied,
    is_lost: NDArray[np.bool_],
) -> Tied | None:
    """The anchors of an event on an epoch's surface, or None where the event does not act in the epoch's frames.

    rows: of the event in `every` anchor tied to the surface and in which of them are lost.
    """
    acts = [time for time in own if start <= time < release]
    if not acts:
        return None
    points = [event.anchor] if isinstance(event, Hook) else list(event.anchors)
    tied = every[rows]
    lost = np.flatnonzero(is_lost[rows])
    if len(lost):
        at, hook = points[lost[0]], isinstance(event, Hook)
        code = ProblemCode.PROGRAM_HOOK_EXCISED if hook else ProblemCode.PROGRAM_ANCHOR_EXCISED
        raise refused(code, _path(event), _mm(at), place=Place.at(at), time=acts[0])
    if len(points) == 2 and float(np.linalg.norm(tied.point[0] - tied.point[1])) == 0.0:
        at, code = tied.point[0], ProblemCode.PROGRAM_ANCHORS_FALL_TOGETHER
        raise refused(code, _path(event), _mm(at), place=Place.at(at))
    return tied


def _hook_arrays(
    hooks: Sequence[Hook], pulled: Sequence[int], ties: dict[int, Tied | None], time: float
) -> dict[str, NDArray[Any]]:
    tied = [found for i in pulled if (found := ties[i]) is not None]
    if not tied:
        return {}
    return {
        "hook_anchors": np.concatenate([found.point for found in tied]),
        "hook_triangles": np.concatenate([found.triangle for found in tied]),
        "hook_targets": np.array([_target(hooks[i], time) for i in pulled], np.float64),
        "hook_stiffness": np.array([hooks[i].stiffness for i in pulled], np.float64),
    }


def _target(hook: Hook, time: float) -> NDArray[np.float64]:
    if not hook.targets:
        raise refused(ProblemCode.HOOK_NO_TARGET, _path(hook))
    samples = sorted(hook.targets)
    when = [sample[0] for sample in samples]
    where = np.array([sample[1] for sample in samples], np.float64)
    return np.array([np.interp(time, when, where[:, axis]) for axis in range(3)])


def _suture_arrays(sutures: Sequence[Suture], ties: dict[int, Tied | None], time: float) -> dict[str, NDArray[Any]]:
    placed = [(i, found) for i, suture in enumerate(sutures) if suture.start <= time and (found := ties[i]) is not None]
    if not placed:
        return {}
    return {
        "suture_index": np.array([i for i, _ in placed], np.int32),
        "suture_anchors": np.array([found.point for _, found in placed], np.float64),
        "suture_triangles": np.array([found.triangle for _, found in placed], np.int32),
        "suture_closure": np.array([_closure(sutures[i], time) for i, _ in placed], np.float64),
        "suture_stiffness": np.array([sutures[i].stiffness for i, _ in placed], np.float64),
    }


def _closure(suture: Suture, time: float) -> float:
    if suture.duration <= 0.0:
        return 1.0
    return min(max((time - suture.start) / suture.duration, 0.0), 1.0)


def _motion(retractor: Retractor) -> RigidMotion:
    return RigidMotion(retractor.motion, _path(retractor))


def _retractor_arrays(
    retractors: Sequence[Retractor], motions: Sequence[RigidMotion], time: float
) -> dict[str, NDArray[Any]]:
    held = [i for i, retractor in enumerate(retractors) if retractor.start <= time < retractor.release]
    if not held:
        return {}
    return {
        "retractor_index": np.array(held, np.int32),
        "retractor_motion": np.array([motions[i].between(retractors[i].start, time) for i in held], np.float64),
    }


def _grips(epoch: Epoch, retractors: Sequence[Retractor], own: Sequence[int]) -> NDArray[np.int32]:
    """The retractor that grips each triangle of an epoch, or -1; only those that act in one of its frames."""
    surface = epoch.surface
    grip = np.full(len(surface.triangles), -1, np.int32)
    for i, retractor in enumerate(retractors):
        acts = [time for time in own if retractor.start <= time < retractor.release]
        if not acts:
            continue
        mask = surface.grips.get(retractor.grip)
        if mask is None:
            known = ", ".join(surface.grips) or "none"
            raise refused(ProblemCode.GRIP_UNKNOWN, _path(retractor), retractor.grip, known=known)
        if not mask.any():
            raise refused(ProblemCode.GRIP_EXCISED, _path(retractor), retractor.grip, time=acts[0])
        taken = np.unique(grip[mask & (grip >= 0)])
        if len(taken):
            other = _path(retractors[int(taken[0])])
            raise refused(ProblemCode.GRIP_SHARED, _path(retractor), retractor.grip, other=other)
        grip[mask] = i
    return grip


def _landmarks(tied: Tied, lost: NDArray[np.bool_]) -> Landmarks:
    kept = np.flatnonzero(~lost)
    return Landmarks(kept.astype(np.int32), tied.point[kept], tied.triangle[kept])


def _labels(marks: Sequence[tuple[Landmark, Point]]) -> tuple[str, ...]:
    """A label per landmark point: no two alike.

    A label that several prims share gets the prim's name, and the points of a prim with several are numbered from 1.
    """
    prims = {mark.name: mark for mark, _ in marks}
    shared = Counter(mark.label or mark.name for mark in prims.values())
    labels = []
    for mark in prims.values():
        label = mark.label or mark.name
        if shared[label] > 1:
            label = f"{label} ({mark.name})"
        labels += [label] if len(mark.points) == 1 else [f"{label} {i + 1}" for i in range(len(mark.points))]
    return tuple(labels)


def _path(event: Event) -> str:
    return f"/Procedure/Timeline/{event.name}"


def _mm(point: Sequence[float] | NDArray[np.float64]) -> str:
    return "(" + ", ".join(f"{float(value):.4g}" for value in point) + ") mm"
