"""Write solved frames as a USD layer over the procedure (docs/skin_cache.md has the layout).

One mesh prim per epoch, with constant topology and time-sampled points; an animated visibility shows the one whose
frame it is.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.anatomy.tissue_layers import layer_search
from lappet.core.version import version
from lappet.daemon.solved_frame import SolvedFrame
from lappet.output.boundary_forces import write_boundary_forces
from lappet.output.dressed_cache import dress
from lappet.output.epoch_mesh import write_epoch
from lappet.output.force_errors import write_force_errors
from lappet.output.layer_table import write_layers
from lappet.output.seam_curves import write_seams
from lappet.output.vessel_curves import write_vessels
from lappet.procedure import Hook, Landmark, Procedure
from lappet.program.program import Program
from lappet.solve.bite_forces import bite_points
from lappet.solve.measures import FrameMeasures
from lappet.usd.arrays import vectors
from lappet.usd.stage import pxr, save_layer

_THREAD_MM, _STEEL_MM, _MARK_MM = 0.3, 0.5, 1.0


def write_skin_cache(
    output: Path,
    procedure_path: Path,
    procedure: Procedure,
    program: Program,
    frames: Sequence[SolvedFrame],
    last_key: str,
    measures: Sequence[FrameMeasures] = (),
) -> None:
    """Write the skin cache of consecutive frames, atomically.

    Parameters
    ----------
    output
        The file (.usdc, .usda or .usd).
    procedure_path
        The procedure's file, which the cache refers to by a path relative to `output`.
    procedure
        The procedure.
    program
        What the solver was told.
    frames
        The solved frames, one after the other.
    last_key
        Key of the last one.
    measures
        What is measured at each of the frames; nothing where none is given.

    Raises
    ------
    RefusedError
        If the suffix is another one.
    OSError
        If the file system refuses.
    """
    output = Path(output)
    layer = pxr().Sdf.Layer.CreateAnonymous(".usda")
    _author(layer, procedure, program, frames, last_key)
    _add_measures(pxr().Usd.Stage.Open(layer), program, frames, measures)
    dress(layer, Path(procedure_path), procedure, program, frames)
    # Only now that no stage is open on it: the path means nothing to a layer in memory.
    below = os.path.relpath(Path(procedure_path).resolve(), output.resolve().parent)
    layer.subLayerPaths.append(below if below.startswith(".") else f"./{below}")
    save_layer(layer, output)


def _add_measures(
    stage: Any, program: Program, frames: Sequence[SolvedFrame], measures: Sequence[FrameMeasures]
) -> None:
    write_seams(stage, frames, [state for each in measures for state in each.seams])
    write_force_errors(stage, program, frames, measures)
    write_boundary_forces(stage, program, frames)


def _author(layer: Any, procedure: Procedure, program: Program, frames: Sequence[SolvedFrame], last_key: str) -> None:
    usd = pxr()
    stage = usd.Usd.Stage.Open(layer)
    usd.UsdGeom.Xform.Define(stage, "/Procedure")
    _metadata(stage, procedure, program, frames, last_key)
    usd.UsdGeom.Xform.Define(stage, "/Procedure/Skin")
    times = [frame.time for frame in frames]
    epochs = {constraints.time: constraints.epoch for constraints in program.frames}
    shown = [epoch for epoch in program.epochs if epoch.index in {epochs[time] for time in times}]
    layers = layer_search(procedure.tissue, procedure.materials)
    write_layers(stage, layers.layers)
    for epoch in shown:
        own = [frame for frame in frames if epochs[frame.time] == epoch.index]
        write_epoch(stage, epoch, layers, own, times, program.fps, bool(procedure.scenery))
    _write_sutures(stage, program, frames)
    _write_threads(stage, program, frames)
    _write_hooks(stage, procedure, program, frames)
    _write_landmarks(stage, procedure, program, frames)
    write_vessels(stage, program, frames)


def _metadata(stage: Any, procedure: Procedure, program: Program, frames: Sequence[SolvedFrame], last_key: str) -> None:
    usd = pxr()
    usd.UsdGeom.SetStageMetersPerUnit(stage, 0.001)
    usd.UsdGeom.SetStageUpAxis(stage, usd.UsdGeom.Tokens.z)
    stage.SetStartTimeCode(frames[0].time)
    stage.SetEndTimeCode(frames[-1].time)
    stage.SetTimeCodesPerSecond(procedure.fps)
    stage.SetFramesPerSecond(procedure.fps)
    stage.SetDefaultPrim(stage.GetPrimAtPath("/Procedure"))
    layer = stage.GetRootLayer()
    layer.comment = "A skin cache, written by lappet solve. Do not edit: it is written anew."
    layer.customLayerData = {"lappet": {"version": version(), "spacing": program.settings.spacing, "lastKey": last_key}}


def _write_sutures(stage: Any, program: Program, frames: Sequence[SolvedFrame]) -> None:
    """Two points per suture, in the order in which they are placed; on one spot until then."""
    if not program.sutures:
        return
    held = np.array([[suture.anchors[0]] * 2 for suture in program.stitches], np.float64)
    curves = _curves(stage, "/Procedure/Skin/Sutures", program.sutures, _THREAD_MM, (0.08, 0.12, 0.35))
    usd = pxr()
    pull = usd.UsdGeom.PrimvarsAPI(curves).CreatePrimvar(
        "force", usd.Sdf.ValueTypeNames.FloatArray, usd.UsdGeom.Tokens.uniform
    )
    vector = _force_vectors(curves)
    for frame in frames:
        forces = np.zeros(len(program.sutures), np.float32)
        forces[frame.suture_index] = frame.suture_forces
        pull.Set(usd.Vt.FloatArray.FromNumpy(forces), frame.time)
        if len(frame.suture_force_vectors) == len(frame.suture_index):
            vector.Set(vectors(_rows(len(program.sutures), frame.suture_index, frame.suture_force_vectors)), frame.time)
        active = np.zeros(len(program.sutures), np.int32)
        active[frame.suture_index] = 1
        held[frame.suture_index] = frame.suture_points
        _set_curves(curves, held, active, frame.time)


def _write_threads(stage: Any, program: Program, frames: Sequence[SolvedFrame]) -> None:
    """All bites of the threads that have more than two, in the order of each; on one spot until they are placed."""
    threads = [suture for suture in program.stitches if len(suture.anchors) > 2]
    if not threads:
        return
    names = [suture.name for suture in threads]
    held = {suture.name: np.array(suture.anchors[:1] * len(suture.anchors), np.float64) for suture in threads}
    curves = _curves(stage, "/Procedure/Skin/Threads", names, _THREAD_MM, (0.08, 0.12, 0.35))
    counts = np.array([len(held[name]) for name in names], np.int32)
    curves.GetCurveVertexCountsAttr().Set(pxr().Vt.IntArray.FromNumpy(counts))
    for frame in frames:
        placed = {program.sutures[i]: at for i, at in zip(frame.suture_index, bite_points(frame), strict=True)}
        held.update((name, placed[name]) for name in names if name in placed)
        active = np.array([name in placed for name in names], np.int32)
        _set_curves(curves, np.concatenate([held[name] for name in names]), active, frame.time)


def _write_hooks(stage: Any, procedure: Procedure, program: Program, frames: Sequence[SolvedFrame]) -> None:
    """Two points per hook, on the tissue and where it pulls to; on one spot while it does not act."""
    if not program.hooks:
        return
    constraints = {each.time: each for each in program.frames}
    anchors = {event.name: event.anchor for event in procedure.events if isinstance(event, Hook)}
    held = np.array([[anchors[name]] * 2 for name in program.hooks], np.float64)
    curves = _curves(stage, "/Procedure/Skin/Hooks", program.hooks, _STEEL_MM, (0.55, 0.57, 0.6))
    vector = _force_vectors(curves)
    for frame in frames:
        active = np.zeros(len(program.hooks), np.int32)
        active[frame.hook_index] = 1
        held[:, 1] = held[:, 0]
        held[frame.hook_index, 0] = frame.hook_points
        if len(frame.hook_forces) == len(frame.hook_index):
            vector.Set(vectors(_rows(len(program.hooks), frame.hook_index, frame.hook_forces)), frame.time)
        pulled = constraints[frame.time]
        held[pulled.hook_index, 1] = pulled.hook_targets
        _set_curves(curves, held, active, frame.time)


def _write_landmarks(stage: Any, procedure: Procedure, program: Program, frames: Sequence[SolvedFrame]) -> None:
    """The landmarks; one whose tissue is excised stays where it was last and is marked inactive."""
    if not program.landmarks:
        return
    usd = pxr()
    count = len(program.landmarks)
    positions = np.array([point for event in procedure.events if isinstance(event, Landmark) for point in event.points])
    marks = usd.UsdGeom.Points.Define(stage, "/Procedure/Skin/Landmarks")
    marks.CreateWidthsAttr(usd.Vt.FloatArray.FromNumpy(np.full(count, _MARK_MM, np.float32)))
    types, tokens = usd.Sdf.ValueTypeNames, usd.UsdGeom.Tokens
    marks.SetWidthsInterpolation(tokens.vertex)
    primvars = usd.UsdGeom.PrimvarsAPI(marks)
    primvars.CreatePrimvar("label", types.StringArray, tokens.vertex).Set(list(program.landmarks))
    active = primvars.CreatePrimvar("active", types.IntArray, tokens.vertex)
    primvars.CreatePrimvar("displayColor", types.Color3fArray, tokens.constant).Set([(0.1, 0.1, 0.1)])
    for frame in frames:
        index, time = frame.landmark_index, frame.time
        positions[index] = frame.landmarks
        flags = np.zeros(count, np.int32)
        flags[index] = 1
        marks.CreatePointsAttr().Set(vectors(positions), time)
        active.Set(usd.Vt.IntArray.FromNumpy(flags), time)
        marks.CreateExtentAttr().Set(_box(positions, _MARK_MM), time)


def _curves(stage: Any, path: str, names: Sequence[str], width: float, color: tuple[float, float, float]) -> Any:
    usd = pxr()
    curves = usd.UsdGeom.BasisCurves.Define(stage, path)
    curves.CreateTypeAttr(usd.UsdGeom.Tokens.linear)
    curves.CreateCurveVertexCountsAttr(usd.Vt.IntArray.FromNumpy(np.full(len(names), 2, np.int32)))
    curves.CreateWidthsAttr([width])
    curves.SetWidthsInterpolation(usd.UsdGeom.Tokens.constant)
    types, tokens = usd.Sdf.ValueTypeNames, usd.UsdGeom.Tokens
    primvars = usd.UsdGeom.PrimvarsAPI(curves)
    primvars.CreatePrimvar("label", types.StringArray, tokens.uniform).Set(list(names))
    primvars.CreatePrimvar("displayColor", types.Color3fArray, tokens.constant).Set([color])
    primvars.CreatePrimvar("active", types.IntArray, tokens.uniform)
    return curves


def _force_vectors(curves: Any) -> Any:
    usd = pxr()
    kind = usd.Sdf.ValueTypeNames.Vector3fArray
    return usd.UsdGeom.PrimvarsAPI(curves).CreatePrimvar("forceVector", kind, usd.UsdGeom.Tokens.uniform)


def _rows(count: int, index: NDArray[np.int32], values: NDArray[np.float64]) -> NDArray[np.float64]:
    """The values in rows of their own numbers; zero in the others."""
    rows = np.zeros((count, 3))
    rows[index] = values
    return rows


def _set_curves(curves: Any, ends: NDArray[np.float64], active: NDArray[np.int32], time: float) -> None:
    usd = pxr()
    points = ends.reshape(-1, 3)
    curves.GetPointsAttr().Set(vectors(points), time)
    curves.CreateExtentAttr().Set(_box(points, float(curves.GetWidthsAttr().Get()[0])), time)
    usd.UsdGeom.PrimvarsAPI(curves).GetPrimvar("active").Set(usd.Vt.IntArray.FromNumpy(active), time)


def _box(points: NDArray[np.float64], width: float) -> Any:
    return vectors(np.stack([points.min(axis=0) - width / 2, points.max(axis=0) + width / 2]))
