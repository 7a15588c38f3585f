"""Solves a procedure and writes its skin cache: known frames are looked up, the daemon solves the rest."""

from __future__ import annotations

import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path

from lappet.checks.validation import check
from lappet.core.problem import RefusedError
from lappet.daemon.daemon_solver import connect_to, solver_identity
from lappet.daemon.frame_solver import Connect, Iteration
from lappet.output.skin_cache import write_skin_cache
from lappet.procedure import Procedure
from lappet.program.compile import DEFAULT, compile_program, frame_times
from lappet.program.program import Program
from lappet.program.settings import SolverSettings
from lappet.solve.error_estimate import ErrorEstimate, estimate_errors
from lappet.solve.solve_program import FrameResult, SolveObserver, solve_program
from lappet.solve.store import FrameStore
from lappet.usd.stage import SUFFIXES, read_procedure, write_procedure


@dataclass(frozen=True, eq=False)
class SolveResult:
    """What a solve gave. frames: those done, from the first one of the procedure on. reason: why it ended before its
    last frame, a sentence, or None. interrupted: the user stopped it. output: the skin cache, or None where no frame of
    the wanted range is done. failed: the unconverged frame that stopped it. notes: what the user was told meanwhile.
    errors: of `frames`, None where no estimate was wanted.
    """

    procedure: Procedure
    program: Program
    frames: tuple[FrameResult, ...]
    reason: str | None = None
    interrupted: bool = False
    failed: FrameResult | None = None
    output: Path | None = None
    wall_seconds: float = 0.0
    notes: tuple[str, ...] = ()
    errors: ErrorEstimate | None = None

    @property
    def complete(self) -> bool:
        """Whether every frame asked for is there."""
        return self.reason is None and not self.interrupted

    @property
    def looked_up(self) -> int:
        """How many frames came from the store."""
        return sum(frame.looked_up for frame in self.frames)

    @property
    def solved(self) -> int:
        """How many frames the daemon solved."""
        return len(self.frames) - self.looked_up


def solve_procedure(
    source: Path | str | Procedure,
    output: Path | str,
    settings: SolverSettings = DEFAULT,
    *,
    frames: tuple[int | None, int | None] = (None, None),
    daemon: str | None = None,
    store: FrameStore | None = None,
    observer: SolveObserver | None = None,
    connect: Connect | None = None,
    solver: str | None = None,
    error_estimate: bool = True,
) -> SolveResult:
    """Solves a procedure and writes its skin cache to `output` (.usdc, .usda or .usd).

    source: a USD file, or a Procedure, which is then written beside the cache as `<output>.procedure.usda`. settings:
    how to solve. frames: first and last time code to write; everything up to the last one is solved.
    daemon: the address of a running daemon. store: where frames are kept. connect, solver: who solves, and what
    identifies it (the daemon that is installed when None). error_estimate: also solve on a coarser lattice, to say how
    large the error is (`lappet.solve.error_estimate`).

    A frame that does not converge, a daemon that cannot be kept alive and Ctrl-C end the solve early and keep what is
    done: see `SolveResult.reason`. Raises RefusedError or RefusedError with a sentence for what cannot be solved at
    all.
    """
    started = time.perf_counter()
    watch = _Noting(observer or SolveObserver())
    output = Path(output)
    _refuse_output(output)
    procedure, path = _read(source, output)
    _check(procedure, settings)
    first, last = _range(procedure, frames)
    program = compile_program(procedure, settings=replace(settings, correction=error_estimate), until=last)
    for sentence in program.notes:
        watch.note(sentence)
    if connect is None or solver is None:
        connect = connect or connect_to(daemon)
        solver = solver or solver_identity(daemon)
    store = store or FrameStore()
    result = solve_program(program, store, connect, solver, watch)
    wanted = [frame for frame in result.frames if frame.constraints.time >= first]
    written = None
    if wanted:
        write_skin_cache(output, path, procedure, program, [frame.solved for frame in wanted], wanted[-1].key)
        written = output
    elif result.reason is not None and result.failed is None:
        raise RefusedError(result.reason)
    errors = None
    if error_estimate and result.frames and not result.interrupted:
        errors = estimate_errors(program, result.frames, store, connect, solver)
    return SolveResult(
        procedure,
        program,
        result.frames,
        result.reason,
        result.interrupted,
        result.failed,
        written,
        time.perf_counter() - started,
        tuple(watch.sentences),
        errors,
    )


def _refuse_output(output: Path) -> None:
    """Refuses, before anything is solved, a file that the skin cache could not be written to."""
    if output.suffix not in SUFFIXES:
        raise RefusedError(f"{output} does not end in a USD suffix; name the skin cache .usdc, .usda or .usd.")
    if output.is_dir():
        raise RefusedError(f"{output} is a folder; name a file for the skin cache.")
    try:
        output.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=output.parent):
            pass
    except OSError as error:
        why = error.strerror or str(error)
        raise RefusedError(
            f"The skin cache {output} cannot be written ({why}); name a file in a folder that you may write to."
        ) from error


def _read(source: Path | str | Procedure, output: Path) -> tuple[Procedure, Path]:
    """The procedure and the file that the skin cache goes over."""
    if isinstance(source, Procedure):
        path = output.with_suffix(".procedure.usda")
        write_procedure(source, path)
        return source, path
    path = Path(source)
    if path.resolve() == output.resolve():
        raise RefusedError(f"{output} is the procedure itself; name another file for the skin cache.")
    return read_procedure(path), path


def _check(procedure: Procedure, settings: SolverSettings) -> None:
    errors = [problem for problem in check(procedure, spacing=settings.spacing or None) if problem.severity == "error"]
    if errors:
        raise RefusedError(errors)


def _range(procedure: Procedure, frames: tuple[int | None, int | None]) -> tuple[int, int]:
    times = frame_times(procedure)
    first = times[0] if frames[0] is None else frames[0]
    last = times[-1] if frames[1] is None else frames[1]
    if not times[0] <= first <= last <= times[-1]:
        raise RefusedError(
            f"The frames {first}:{last} are not in the timeline, which runs from {times[0]} to {times[-1]}; "
            "give a first and a last frame inside it."
        )
    return first, last


class _Noting(SolveObserver):
    """Passes everything on and keeps the notes."""

    def __init__(self, observer: SolveObserver) -> None:
        self._watcher = observer
        self.sentences: list[str] = []

    def begin(self, frames: int) -> None:
        self._watcher.begin(frames)

    def iteration(self, iteration: Iteration) -> None:
        self._watcher.iteration(iteration)

    def frame(self, frame: FrameResult) -> None:
        self._watcher.frame(frame)

    def note(self, sentence: str) -> None:
        self.sentences.append(sentence)
        self._watcher.note(sentence)
