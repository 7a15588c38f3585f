"""What a solve did otherwise than it was told, and what its lattice leaves out: nothing of it happens in silence."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lappet.core.problem import Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.cutting.epoch import Epoch
from lappet.daemon.lattice_counts import LatticeCounts
from lappet.geometry.surface_check import signed_volume
from lappet.procedure.prim_paths import TISSUE
from lappet.program.program import Program
from lappet.program.settings import SolverSettings
from lappet.solve.frame_span import span_of
from lappet.solve.solve_frames import FrameResult

MOST_OFF = 0.02  # of the tissue's volume, by which that of its lattice may differ

WHY_FROM_REST = {
    "invalid_start": "too many cells of the frame before are inverted or flat",
    "no_equilibrium": "no equilibrium was found from the frame before",
    "inverted": "what was found from the frame before has inverted cells",
}
"""What a `restart` of PROTOCOL.md means."""


def fallbacks(program: Program, frames: Sequence[FrameResult]) -> list[Problem]:
    """Find what was done otherwise than the program says.

    These are frames that were solved from rest, lattices that leave out tips or hold another volume than the tissue,
    and a `region` that cannot be had.

    Parameters
    ----------
    program
        The program.
    frames
        Its solved frames.

    Returns
    -------
    list[Problem]
        Notes, and a warning where a volume is off by more than `MOST_OFF`.
    """
    found = _from_rest(frames)
    lattices = {frame.constraints.epoch: frame.solved.lattice for frame in frames}
    known = [(epoch, own) for epoch in program.epochs if (own := lattices.get(epoch.index)) is not None]
    found += [*_dropped(known, program.settings), *_volume_off(known)]
    if frames and program.settings.region == "auto":
        found += _neighborhood(program)
    return found


def volume_ratio(epoch: Epoch, lattice: LatticeCounts) -> float:
    """Compare the volume of a lattice with that of its tissue.

    Parameters
    ----------
    epoch
        The epoch with the surface of the tissue.
    lattice
        Counts of its lattice.

    Returns
    -------
    float
        Volume of the tissue in the cells over that inside the surface; NaN where that is 0.
    """
    tissue = signed_volume(epoch.surface.points, epoch.surface.triangles)
    return lattice.volume / tissue if tissue > 0.0 else float("nan")


def _from_rest(frames: Sequence[FrameResult]) -> list[Problem]:
    found = []
    for why in dict.fromkeys(frame.solved.diagnostics.restart for frame in frames):
        if not why:
            continue
        own = [frame.constraints.time for frame in frames if frame.solved.diagnostics.restart == why]
        code = ProblemCode.FRAMES_FROM_REST
        found.append(problem(code, span_of(own), len(own), why=WHY_FROM_REST.get(why, why)))
    return found


def _dropped(known: Sequence[tuple[Epoch, LatticeCounts]], settings: SolverSettings) -> list[Problem]:
    """The epoch whose lattice leaves out most."""
    epoch, lattice = max(known, key=lambda each: each[1].dropped_voxels, default=(None, None))
    if epoch is None or lattice is None or not lattice.dropped_voxels:
        return []
    dropped = _volume(lattice.dropped_voxels, settings)
    percent = 100.0 * dropped / signed_volume(epoch.surface.points, epoch.surface.triangles)
    return [problem(ProblemCode.LATTICE_DROPPED, TISSUE, f"{dropped:.3g}", time=epoch.start_time, percent=percent)]


def _volume_off(known: Sequence[tuple[Epoch, LatticeCounts]]) -> list[Problem]:
    """The epoch whose lattice differs most."""
    off = [(abs(volume_ratio(*each) - 1.0), *each) for each in known]
    most, epoch, lattice = max(off, key=lambda each: each[0], default=(0.0, None, None))
    if epoch is None or lattice is None or not most > MOST_OFF:
        return []
    held, tissue = lattice.volume, signed_volume(epoch.surface.points, epoch.surface.triangles)
    time, percent, code = epoch.start_time, f"{100.0 * held / tissue:.1f}", ProblemCode.LATTICE_VOLUME
    return [problem(code, TISSUE, percent, time=time, lattice=held, tissue=tissue, most=MOST_OFF)]


def _neighborhood(program: Program) -> list[Problem]:
    why = ""
    if len(program.bones.points):
        why = "there are bones"
    elif program.settings.preconditioner == "chebyshev":
        why = "the preconditioner is the smoother alone"
    elif not any(np.any(epoch.surface.bed) for epoch in program.epochs) or not program.settings.bed_stiffness:
        why = "no face is on the bed"
    return [problem(ProblemCode.NEIGHBORHOOD_OFF, "", why)] if why else []


def _volume(voxels: int, settings: SolverSettings) -> float:
    """The volume of fine voxels in mm³."""
    return float(voxels * (settings.spacing / settings.fine_ratio) ** 3)
