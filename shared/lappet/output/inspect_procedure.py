"""What `lappet inspect` tells about a procedure: storyboard, epochs, suture runs, scene profile, lattice counts."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from lappet.core.problem import Problem, RefusedError
from lappet.cutting.epoch import Epoch
from lappet.daemon.daemon_solver import connect_to
from lappet.daemon.frame_solver import Connect
from lappet.daemon.running_daemon import RunningDaemon
from lappet.foreign.limits import DEFAULT_LIMITS, ReadLimits
from lappet.geometry.labeled_surface import FaceOrigin
from lappet.procedure import Procedure, SutureRun
from lappet.procedure.scene_profile import measured_costs
from lappet.procedure.storyboard import inspection
from lappet.program.compile import compile_program
from lappet.program.program import Program
from lappet.program.settings import SolverSettings
from lappet.solve.suture_forces import closure_of
from lappet.suturing.stitch_places import taken_spacing
from lappet.usd.stage import read_procedure


def inspect_procedure(
    path: Path,
    *,
    spacing: float | None = None,
    lattice: bool = True,
    daemon: RunningDaemon | None = None,
    connect: Connect | None = None,
    economy: Path | None = None,
    limits: ReadLimits = DEFAULT_LIMITS,
) -> str:
    """Compose the text of `lappet inspect`.

    Parameters
    ----------
    path
        The procedure's file.
    spacing
        Lattice spacing in mm; the tissue's when None.
    lattice
        Whether to ask the daemon for the counts of every epoch's lattice; where they cannot be had a note says why.
    daemon
        A running daemon; None starts one.
    connect
        Makes the solver; the daemon when None.
    economy
        File of `lappet report economy` that costs are taken from.
    limits
        What reading the procedure may take.

    Returns
    -------
    str
        Several lines of text.

    Raises
    ------
    RefusedError
        If the procedure cannot be read or compiled, or the file of costs is no such report.
    """
    notes: list[Problem] = []
    procedure = read_procedure(path, notes, limits)
    program = compile_program(procedure, settings=SolverSettings(spacing=spacing or 0.0))
    notes += program.notes
    lines = [str(note) for note in notes]
    counts: list[str] = []
    if lattice:
        try:
            counts = _lattice_lines(program, daemon, connect)
        except (RefusedError, RuntimeError) as error:
            lines.append(f"No lattice counts: {error}")
    costs = {"error_estimate": f"every frame once more at {2.0 * program.settings.spacing:g} mm"}
    if economy is not None:
        for name, share in measured_costs(economy).items():
            costs[name] = f"{costs[name]}, {share}" if name in costs else share
    epochs = [_epoch_line(epoch, program) for epoch in program.epochs]
    return inspection(procedure, epochs, counts, lines, costs, _run_lines(procedure, program))


def _run_lines(procedure: Procedure, program: Program) -> list[str]:
    """For each suture run how many stitches it has in each layer, and how far they are apart."""
    lines = []
    for run in procedure.events:
        if isinstance(run, SutureRun):
            own = [suture.name for suture in program.stitches if suture.name.startswith(f"{run.name}/")]
            counts = Counter(closure_of(name) for name in own)
            layers = [f"{count} {name.partition('/')[2]}".strip() for name, count in counts.items()]
            taken = taken_spacing(run, program.settings.spacing)
            merged = f", merged from {run.spacing:g} mm" if taken > run.spacing else ""
            lines.append(f"{run.name}: {', '.join(layers)}; a stitch every {taken:.4g} mm{merged}")
    return lines


def _epoch_line(epoch: Epoch, program: Program) -> str:
    surface = epoch.surface
    frames = [frame.time for frame in program.frames if frame.epoch == epoch.index]
    when = f"frames {frames[0]:g} to {frames[-1]:g}" if frames else f"from {epoch.start_time:g}, no frame of its own"
    origins = {name.name.lower().replace("_", " "): int((surface.origin == name).sum()) for name in FaceOrigin}
    faces = ", ".join(f"{count} {name}" for name, count in origins.items() if count)
    gone = [f"; {each.name} takes {each.volume:.4g} mm³ from below {each.area:.4g} mm²" for each in epoch.thinned]
    return (
        f"epoch {epoch.index}: {when}; {epoch.fragments} fragment{'' if epoch.fragments == 1 else 's'}, "
        f"{len(surface.triangles)} triangles ({faces}){''.join(gone)}"
    )


def _lattice_lines(program: Program, daemon: RunningDaemon | None, connect: Connect | None) -> list[str]:
    if connect is None:
        connect = connect_to(daemon)
    solver = connect(program.settings, program.bones)
    lines = [f"spacing {program.settings.spacing:g} mm"]
    try:
        for epoch, grip, landmarks in zip(program.epochs, program.grips, program.landmarks_at, strict=True):
            counts = solver.set_epoch(epoch, grip, landmarks)
            lines.append(
                f"epoch {epoch.index}: {counts.cells} cells "
                f"({counts.grid_cells} grid, {counts.mesh_cells} mesh), "
                f"{counts.nodes} nodes, {counts.blocks} blocks, {counts.fine_voxels} fine voxels, "
                f"{counts.bytes / 2**20:.1f} MiB"
            )
    finally:
        solver.close()
    return lines
