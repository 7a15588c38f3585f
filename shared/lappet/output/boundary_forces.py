"""What holds the tissue and what crosses its sections, in the skin cache: forces as primvars of two scopes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from lappet.daemon.solved_frame import SolvedFrame
from lappet.program.program import Program
from lappet.solve.reactions import Reaction, reactions
from lappet.solve.section_tension import section_tensions
from lappet.usd.arrays import vectors
from lappet.usd.stage import pxr


def write_boundary_forces(stage: Any, program: Program, frames: Sequence[SolvedFrame]) -> None:
    """Write the reactions and the forces across sections, in mN and N/mm.

    Parameters
    ----------
    stage
        The stage.
    program
        What the solver was told.
    frames
        The frames that are written.
    """
    _write_reactions(stage, frames, [reactions(program, frame) for frame in frames])
    _write_sections(stage, program, frames)


def _write_reactions(stage: Any, frames: Sequence[SolvedFrame], rows: Sequence[Sequence[Reaction]]) -> None:
    """A force for whatever holds or loads the tissue in any of the frames; zero in those in which it does not."""
    held = list(dict.fromkeys((row.holder, row.name) for own in rows for row in own))
    if not held:
        return
    usd = pxr()
    primvars = _primvars(stage, "Reactions")
    _primvar(primvars, "holder", usd.Sdf.ValueTypeNames.StringArray, len(held)).Set([holder for holder, _ in held])
    _primvar(primvars, "label", usd.Sdf.ValueTypeNames.StringArray, len(held)).Set([name for _, name in held])
    force = _primvar(primvars, "force", usd.Sdf.ValueTypeNames.Vector3fArray, len(held))
    for frame, own in zip(frames, rows, strict=True):
        values = np.zeros((len(held), 3))
        for row in own:
            values[held.index((row.holder, row.name))] = row.force_x_mn, row.force_y_mn, row.force_z_mn
        force.Set(vectors(values), frame.time)


def _write_sections(stage: Any, program: Program, frames: Sequence[SolvedFrame]) -> None:
    count = len(program.sections)
    if not count:
        return
    usd = pxr()
    types = usd.Sdf.ValueTypeNames
    primvars = _primvars(stage, "Sections")
    _primvar(primvars, "label", types.StringArray, count).Set(list(program.sections))
    force = _primvar(primvars, "force", types.Vector3fArray, count)
    tension = _primvar(primvars, "tension", types.FloatArray, count)
    epochs = {each.time: each.epoch for each in program.frames}
    rows = section_tensions(program, [(epochs[frame.time], frame) for frame in frames])
    for index, frame in enumerate(frames):
        own = rows[index * count : (index + 1) * count]
        force.Set(vectors(np.array([(row.force_x_mn, row.force_y_mn, row.force_z_mn) for row in own])), frame.time)
        known = [row.tension_n_per_mm for row in own]
        tension.Set(usd.Vt.FloatArray([float("nan") if each is None else each for each in known]), frame.time)


def _primvars(stage: Any, name: str) -> Any:
    usd = pxr()
    return usd.UsdGeom.PrimvarsAPI(usd.UsdGeom.Scope.Define(stage, f"/Procedure/Skin/{name}"))


def _primvar(primvars: Any, name: str, kind: Any, count: int) -> Any:
    """A primvar of one value with an element for each of a scope's rows: a scope has nothing to vary over."""
    return primvars.CreatePrimvar(name, kind, pxr().UsdGeom.Tokens.constant, count)
