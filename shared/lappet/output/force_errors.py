"""What the skin cache says of its forces: the estimated error of each, and which sutures the lattice resolves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from lappet.daemon.solved_frame import SolvedFrame
from lappet.program.program import Program
from lappet.solve.measures import FrameMeasures
from lappet.usd.stage import pxr


def write_force_errors(
    stage: Any, program: Program, frames: Sequence[SolvedFrame], measures: Sequence[FrameMeasures]
) -> None:
    """Write the errors as primvars of the curves of sutures and hooks, in mN; NaN where there is none.

    Of the sutures that are placed those that the lattice does not resolve are marked: their force is none of the wound.

    Parameters
    ----------
    stage
        The stage, with the curves.
    program
        What the solver was told.
    frames
        The frames that are written.
    measures
        What is measured at each of them; none are written without.
    """
    if not measures:
        return
    _write_resolved(stage, program, frames, measures)
    sutures = [{row.suture: row.force_error_mn for row in each.sutures} for each in measures]
    hooks = [{row.hook: row.force_error_mn for row in each.hooks} for each in measures]
    for path, names, errors in (("Sutures", program.sutures, sutures), ("Hooks", program.hooks, hooks)):
        if not any(error is not None for own in errors for error in own.values()):
            continue
        usd = pxr()
        curves = stage.GetPrimAtPath(f"/Procedure/Skin/{path}")
        primvar = usd.UsdGeom.PrimvarsAPI(curves).CreatePrimvar(
            "forceError", usd.Sdf.ValueTypeNames.FloatArray, usd.UsdGeom.Tokens.uniform
        )
        for frame, own in zip(frames, errors, strict=True):
            values = [own.get(name) for name in names]
            primvar.Set(usd.Vt.FloatArray([float("nan") if each is None else each for each in values]), frame.time)


def _write_resolved(
    stage: Any, program: Program, frames: Sequence[SolvedFrame], measures: Sequence[FrameMeasures]
) -> None:
    if not program.sutures:
        return
    usd = pxr()
    primvar = usd.UsdGeom.PrimvarsAPI(stage.GetPrimAtPath("/Procedure/Skin/Sutures")).CreatePrimvar(
        "resolved", usd.Sdf.ValueTypeNames.IntArray, usd.UsdGeom.Tokens.uniform
    )
    for frame, each in zip(frames, measures, strict=True):
        unresolved = {row.suture for row in each.sutures if not row.resolved}
        primvar.Set(usd.Vt.IntArray([int(name not in unresolved) for name in program.sutures]), frame.time)
