"""The vessels in the skin cache: for each epoch the curves of what its cuts leave of them, moving with the tissue."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from lappet.anatomy.vessel_pieces import VesselPieces
from lappet.daemon.solved_frame import SolvedFrame
from lappet.geometry.vectors import bounds
from lappet.output.shown_frames import show_at
from lappet.procedure import Vessel
from lappet.procedure.vessel import VESSEL_COLORS
from lappet.program.program import Program
from lappet.usd.arrays import vectors
from lappet.usd.stage import pxr

ROOT = "/Procedure/Skin/Vessels"


def write_vessels(stage: Any, program: Program, frames: Sequence[SolvedFrame]) -> None:
    """Write the vessels of each epoch, shown at its own frames alone.

    Parameters
    ----------
    stage
        The stage of the cache.
    program
        What the solver was told.
    frames
        The frames that are written.
    """
    if not program.vessels:
        return
    pxr().UsdGeom.Scope.Define(stage, ROOT)
    times = [frame.time for frame in frames]
    epochs = {constraints.time: constraints.epoch for constraints in program.frames}
    for epoch, pieces in zip(program.epochs, program.vessels_at, strict=True):
        own = [frame for frame in frames if epochs[frame.time] == epoch.index]
        if own and len(pieces.counts):
            curves = _define(stage, f"{ROOT}/epoch_{epoch.index:02d}", program.vessels, pieces)
            _animate(curves, own, max(vessel.radius for vessel in program.vessels))
            show_at(curves, {frame.time for frame in own}, times)


def _define(stage: Any, path: str, vessels: Sequence[Vessel], pieces: VesselPieces) -> Any:
    """The curves at rest with what does not change: a curve for each piece."""
    usd = pxr()
    types, tokens = usd.Sdf.ValueTypeNames, usd.UsdGeom.Tokens
    curves = usd.UsdGeom.BasisCurves.Define(stage, path)
    curves.CreateTypeAttr(tokens.linear)
    curves.CreateCurveVertexCountsAttr(usd.Vt.IntArray.FromNumpy(np.asarray(pieces.counts, np.int32)))
    own = [vessels[number] for number in pieces.vessel]
    curves.CreateWidthsAttr(usd.Vt.FloatArray([2.0 * vessel.radius for vessel in own]))
    curves.SetWidthsInterpolation(tokens.uniform)
    primvars = usd.UsdGeom.PrimvarsAPI(curves)
    # Not primvars: programs that cannot draw text complain of primvars that are.
    for name, kind, values in (
        ("label", types.StringArray, [vessel.title for vessel in own]),
        ("kind", types.TokenArray, [vessel.kind for vessel in own]),
    ):
        uniform = usd.Sdf.VariabilityUniform
        curves.GetPrim().CreateAttribute(f"lappet:{name}", kind, custom=False, variability=uniform).Set(values)
    colors = [VESSEL_COLORS[vessel.kind] for vessel in own]
    primvars.CreatePrimvar("displayColor", types.Color3fArray, tokens.uniform).Set(vectors(np.array(colors)))
    divided = np.asarray(pieces.divided, np.int32)
    for column, name in enumerate(("beginDivided", "endDivided")):
        primvar = primvars.CreatePrimvar(name, types.IntArray, tokens.uniform)
        primvar.Set(usd.Vt.IntArray.FromNumpy(np.ascontiguousarray(divided[:, column])))
    curves.CreatePointsAttr().Set(vectors(pieces.points))
    return curves


def _animate(curves: Any, frames: Sequence[SolvedFrame], radius: float) -> None:
    for frame in frames:
        curves.GetPointsAttr().Set(vectors(frame.vessel_points), frame.time)
        box = bounds(np.asarray(frame.vessel_points, np.float64)) + np.array([[-radius], [radius]])
        curves.CreateExtentAttr().Set(vectors(box), frame.time)
