"""The seams of wounds in the skin cache: a curve for each, with what is measured at its places."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from lappet.daemon.solved_frame import SolvedFrame
from lappet.solve.seam_measures import SeamState
from lappet.solve.seams import SAMPLES
from lappet.usd.arrays import vectors
from lappet.usd.stage import pxr

_WIDTH_MM = 0.4
_BY_PLACE = ("gap", "step", "mismatch")
_WHOLE = {
    "tension": "tension_n_per_mm",
    "scarLength": "scar_length_mm",
    "openArea": "open_area_mm2",
    "startDogEar": "start_dog_ear_mm",
    "endDogEar": "end_dog_ear_mm",
    "tensionError": "tension_error_n_per_mm",
    "scarLengthError": "scar_length_error_mm",
    "openAreaError": "open_area_error_mm2",
    "gapError": "greatest_gap_error_mm",
    "stepError": "step_off_error_mm",
    "mismatchError": "edge_mismatch_error_mm",
    "startDogEarError": "start_dog_ear_error_mm",
    "endDogEarError": "end_dog_ear_error_mm",
}


def write_seams(stage: Any, frames: Sequence[SolvedFrame], states: Sequence[SeamState]) -> None:
    """Write a curve for each seam, midway between its lips; on the spot where it begins until the tissue is cut there.

    Parameters
    ----------
    stage
        The stage.
    frames
        The frames that are written.
    states
        The seams of these frames, maybe of others too.
    """
    times = {frame.time for frame in frames}
    own = [state for state in states if state.measure.time in times]
    names = list(dict.fromkeys(state.measure.seam for state in own))
    if not names:
        return
    usd = pxr()
    types, tokens = usd.Sdf.ValueTypeNames, usd.UsdGeom.Tokens
    curves = usd.UsdGeom.BasisCurves.Define(stage, "/Procedure/Skin/Seams")
    curves.CreateTypeAttr(tokens.linear)
    curves.CreateCurveVertexCountsAttr(usd.Vt.IntArray.FromNumpy(np.full(len(names), SAMPLES, np.int32)))
    curves.CreateWidthsAttr([_WIDTH_MM])
    curves.SetWidthsInterpolation(tokens.constant)
    # They measure; what is shown of a scar are its lips.
    curves.CreatePurposeAttr(tokens.guide)
    primvars = usd.UsdGeom.PrimvarsAPI(curves)
    primvars.CreatePrimvar("label", types.StringArray, tokens.uniform).Set(names)
    active = primvars.CreatePrimvar("active", types.IntArray, tokens.uniform)
    by_place = {name: primvars.CreatePrimvar(name, types.FloatArray, tokens.vertex) for name in _BY_PLACE}
    whole = {name: primvars.CreatePrimvar(name, types.FloatArray, tokens.uniform) for name in _WHOLE}
    first = {state.measure.seam: state for state in reversed(own)}
    points = np.stack([np.tile(first[name].points[:1], (SAMPLES, 1)) for name in names])
    found = {(state.measure.time, state.measure.seam): state for state in own}
    for frame in frames:
        known = [found.get((frame.time, name)) for name in names]
        for k, state in enumerate(known):
            if state is not None:
                points[k] = state.points
        curves.CreatePointsAttr().Set(vectors(points.reshape(-1, 3)), frame.time)
        low, high = points.min(axis=(0, 1)) - 0.5 * _WIDTH_MM, points.max(axis=(0, 1)) + 0.5 * _WIDTH_MM
        curves.CreateExtentAttr().Set(vectors(np.stack([low, high])), frame.time)
        active.Set(usd.Vt.IntArray([int(state is not None) for state in known]), frame.time)
        for name, primvar in by_place.items():
            rows = [np.zeros(SAMPLES) if state is None else getattr(state, name) for state in known]
            primvar.Set(usd.Vt.FloatArray.FromNumpy(np.concatenate(rows).astype(np.float32)), frame.time)
        for name, primvar in whole.items():
            values = [None if state is None else getattr(state.measure, _WHOLE[name]) for state in known]
            primvar.Set(usd.Vt.FloatArray([float("nan") if value is None else value for value in values]), frame.time)
