"""The stages of `lappet solve`, each timed: what Python does before and after the solver must stay small beside it."""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lappet.bench.circumstances import cores
from lappet.bench.scenes import daemon_isa
from lappet.checks import check
from lappet.core.problem import RefusedError
from lappet.cutting.epoch import Epoch
from lappet.cutting.epochs import build_epochs
from lappet.daemon.daemon_solver import connect_to, solver_identity
from lappet.daemon.frame_solver import Connect, FrameSolver
from lappet.daemon.lattice_counts import LatticeCounts
from lappet.output.skin_cache import write_skin_cache
from lappet.program.compile import compile_program
from lappet.program.program import Bones, Landmarks
from lappet.program.settings import SolverSettings
from lappet.solve.error_estimate import estimate_errors
from lappet.solve.solve_frames import SolveObserver, solve_program
from lappet.solve.store import FrameStore
from lappet.usd import read_procedure

STAGES = ("read", "check", "cut", "compile", "lattice", "solve", "estimate", "cache")
# One procedure at three sizes: about 10 000, 100 000 and 400 000 cells.
EXAMPLE, SPACINGS = "rhomboid", (1.7, 0.8, 0.5)


@dataclass(frozen=True)
class StageMeasure:
    """What one stage of a solve cost.

    Parameters
    ----------
    scene
        Name of the scene.
    spacing_mm
        Lattice spacing.
    cells
        Cells of the largest lattice.
    frames
        Number of frames that were solved.
    threads
        Number of threads of the daemon.
    isa
        Instruction set.
    stage
        One of `STAGES`. "lattice" is what the daemon does when it is told an epoch, "solve" the rest of solving the
        frames, "estimate" the coarse solves of the error estimate.
    seconds
        Wall time, summed over the scene.
    own_seconds
        Processor time of this process, without the daemon's: what other work on the machine changes least.
    share
        Of all stages of the scene.
    """

    scene: str
    spacing_mm: float
    cells: int
    frames: int
    threads: int
    isa: str
    stage: str
    seconds: float
    own_seconds: float
    share: float


class _Stopwatch:
    """The seconds that were spent in each stage."""

    def __init__(self) -> None:
        self.seconds, self.own_seconds = dict.fromkeys(STAGES, 0.0), dict.fromkeys(STAGES, 0.0)

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        begun, own = time.perf_counter(), time.process_time()
        try:
            yield
        finally:
            self.seconds[name] += time.perf_counter() - begun
            self.own_seconds[name] += time.process_time() - own


def pipeline(examples: Path, folder: Path, until: float | None = None) -> list[StageMeasure]:
    """Measure `EXAMPLE` at each of `SPACINGS`.

    Parameters
    ----------
    examples
        Folder of the examples.
    folder
        Folder of the caches.
    until
        Leave out frames after this time code.

    Returns
    -------
    list[StageMeasure]
        The rows, those of a scene together.
    """
    rows: list[StageMeasure] = []
    for spacing in SPACINGS:
        print(f"{EXAMPLE} at {spacing:g} mm, stage by stage …", file=sys.stderr)
        rows += measure_pipeline(examples / EXAMPLE / f"{EXAMPLE}.usda", spacing, folder, until=until)
    return rows


def measure_pipeline(
    procedure: Path, spacing: float, folder: Path, connect: Connect | None = None, until: float | None = None
) -> list[StageMeasure]:
    """Solve every frame of a procedure's file as `lappet solve` does, and time the stages.

    Parameters
    ----------
    procedure
        The file.
    spacing
        Lattice spacing in mm.
    folder
        Folder of the cache.
    connect
        Makes the solver; the installed daemon when None.
    until
        Leave out frames after this time code.

    Returns
    -------
    list[StageMeasure]
        A row for each of `STAGES`.

    Raises
    ------
    RefusedError
        If the procedure cannot be solved, or a frame does not converge.
    """
    watch = _Stopwatch()
    with watch.stage("read"):
        read = read_procedure(procedure)
    with watch.stage("check"):
        errors = [each for each in check(read, spacing=spacing) if each.severity == "error"]
    if errors:
        raise RefusedError(errors)
    with watch.stage("cut"):
        epochs = build_epochs(replace(read, tissue=replace(read.tissue, spacing=spacing)))
    with watch.stage("compile"):
        program = compile_program(read, epochs, SolverSettings(spacing=spacing, correction=True), until=until)
    solver = connect or connect_to(None)
    identity = solver_identity(None) if connect is None else "measured"
    with tempfile.TemporaryDirectory(prefix="lappet-bench-") as kept:
        store = FrameStore(Path(kept))
        with watch.stage("solve"):
            solved = solve_program(program, store, _timed(solver, watch), identity, SolveObserver())
        if solved.reason is not None:
            raise RefusedError([replace(solved.reason, prim=procedure.stem)])
        for spent in (watch.seconds, watch.own_seconds):
            spent["solve"] -= spent["lattice"]
        frames = [frame.solved for frame in solved.frames]
        with watch.stage("cache"):
            cache = folder / f"{procedure.stem}.usdc"
            write_skin_cache(cache, procedure, read, program, frames, solved.frames[-1].key)
        with watch.stage("estimate"):
            estimate_errors(program, solved.frames, store, solver, identity)
    total = sum(watch.seconds.values())
    cells = max(frame.lattice.cells for frame in frames if frame.lattice is not None)
    threads, isa = program.settings.threads or cores(), daemon_isa() if connect is None else ""
    scene = (procedure.stem, spacing, cells, len(frames), threads, isa)
    return [
        StageMeasure(*scene, stage, seconds, watch.own_seconds[stage], seconds / total)
        for stage, seconds in watch.seconds.items()
    ]


class _TimedSolver:
    """A session whose epochs count as the stage "lattice"."""

    def __init__(self, session: FrameSolver, watch: _Stopwatch) -> None:
        self._session, self._watch = session, watch
        self.set_state, self.solve, self.close = session.set_state, session.solve, session.close

    def set_epoch(self, epoch: Epoch, grip: NDArray[np.int32], landmarks: Landmarks) -> LatticeCounts:
        with self._watch.stage("lattice"):
            return self._session.set_epoch(epoch, grip, landmarks)

    def set_epoch_with_nodes(
        self, epoch: Epoch, grip: NDArray[np.int32], landmarks: Landmarks
    ) -> tuple[LatticeCounts, NDArray[np.float64]]:
        with self._watch.stage("lattice"):
            return self._session.set_epoch_with_nodes(epoch, grip, landmarks)


def _timed(connect: Connect, watch: _Stopwatch) -> Connect:
    def connected(settings: SolverSettings, bones: Bones) -> FrameSolver:
        return _TimedSolver(connect(settings, bones), watch)

    return connected
