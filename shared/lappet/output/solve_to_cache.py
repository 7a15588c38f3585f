"""Solve a procedure and write its skin cache: known frames are looked up, the daemon solves the rest."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from lappet.checks.validation import check
from lappet.core.problem import Problem, RefusedError, problem, refused
from lappet.core.problem_code import ProblemCode
from lappet.daemon.daemon_solver import connect_to, solver_identity
from lappet.daemon.frame_solver import Connect, Iteration
from lappet.daemon.running_daemon import RunningDaemon
from lappet.foreign.limits import DEFAULT_LIMITS, ReadLimits
from lappet.output.skin_cache import write_skin_cache
from lappet.procedure import Procedure
from lappet.procedure.prim_paths import ROOT
from lappet.program.compile import DEFAULT, compile_program, frame_times
from lappet.program.program import Program
from lappet.program.settings import SolverSettings
from lappet.solve.hook_forces import HookForce
from lappet.solve.measures import FrameMeasures, Gauges
from lappet.solve.reactions import Reaction, reactions
from lappet.solve.result_notes import result_notes
from lappet.solve.seam_measures import SeamMeasure
from lappet.solve.section_tension import SectionTension, section_tensions
from lappet.solve.sensitive import several_notes
from lappet.solve.solve_frames import FrameResult, Frames, SolveObserver, solve_program
from lappet.solve.store import FrameStore
from lappet.solve.suture_forces import SutureForce, suture_warnings
from lappet.usd.procedure_file import ProcedureFile
from lappet.usd.stage import SUFFIXES, pxr, write_procedure

if TYPE_CHECKING:
    from lappet.solve.error_estimate import ErrorEstimate


@dataclass(frozen=True, eq=False)
class SolveResult:
    """What a solve gave.

    Parameters
    ----------
    procedure
        The procedure that was solved.
    program
        What the solver was told.
    frames
        Frames that are done, from the first one of the procedure on.
    reason
        Why the solve ended before its last frame, a sentence, or None.
    interrupted
        Whether the user stopped it.
    failed
        The unconverged frame that stopped it, or None.
    output
        The skin cache, or None where no frame of the wanted range is done.
    wall_seconds
        Run time in seconds.
    notes
        Warnings and notes: what is suspicious in the procedure, and what was done otherwise than it was told.
    errors
        Estimate of the errors of `frames`, or None where none was wanted.
    measures
        What is measured at each of `frames`, with its estimated errors where these are wanted.
    """

    procedure: Procedure
    program: Program
    frames: tuple[FrameResult, ...]
    reason: Problem | None = None
    interrupted: bool = False
    failed: FrameResult | None = None
    output: Path | None = None
    wall_seconds: float = 0.0
    notes: tuple[Problem, ...] = ()
    errors: ErrorEstimate | None = None
    measures: tuple[FrameMeasures, ...] = ()

    @property
    def suture_forces(self) -> tuple[SutureForce, ...]:
        """The force on each suture in each frame."""
        return tuple(row for each in self.measures for row in each.sutures)

    @property
    def hook_forces(self) -> tuple[HookForce, ...]:
        """The force of each hook in each frame."""
        return tuple(row for each in self.measures for row in each.hooks)

    @property
    def seams(self) -> tuple[SeamMeasure, ...]:
        """What is measured at each seam in each frame."""
        return tuple(state.measure for each in self.measures for state in each.seams)

    @property
    def reactions(self) -> tuple[Reaction, ...]:
        """The force of whatever holds or loads the tissue in each frame."""
        return tuple(row for frame in self.frames for row in reactions(self.program, frame.solved))

    @property
    def sections(self) -> tuple[SectionTension, ...]:
        """The force across each section in each frame."""
        frames = [(frame.constraints.epoch, frame.solved) for frame in self.frames]
        return tuple(section_tensions(self.program, frames))

    @property
    def complete(self) -> bool:
        """Whether every frame asked for is there."""
        return self.reason is None and not self.interrupted

    @property
    def looked_up(self) -> int:
        """Number of frames that came from the store."""
        return sum(frame.looked_up for frame in self.frames)

    @property
    def solved(self) -> int:
        """Number of frames that the daemon solved."""
        return len(self.frames) - self.looked_up


def solve_procedure(
    source: Path | str | Procedure | ProcedureFile,
    output: Path | str,
    settings: SolverSettings = DEFAULT,
    *,
    frames: tuple[int | None, int | None] = (None, None),
    daemon: RunningDaemon | None = None,
    share: float | None = None,
    store: FrameStore | None = None,
    observer: SolveObserver | None = None,
    connect: Connect | None = None,
    solver: str | None = None,
    error_estimate: bool = True,
    limits: ReadLimits = DEFAULT_LIMITS,
) -> SolveResult:
    """Solve a procedure and write its skin cache.

    A frame that does not converge, a daemon that cannot be kept alive and Ctrl-C end the solve early and keep what is
    done: see `SolveResult.reason`.

    Parameters
    ----------
    source
        A USD file, or one that is being read, or a procedure, which is then written beside the cache as `<its
        stem>.procedure.usda`.
    output
        The skin cache (.usdc, .usda or .usd).
    settings
        How to solve.
    frames
        First and last time code to write, None for the procedure's; everything up to the last one is solved.
    daemon
        A running daemon; None starts one.
    share
        Seconds to wait for whoever wants to follow the session before its first frame; None lets nobody follow.
    store
        Where frames are kept; the user's store when None.
    observer
        Is told how the solve goes.
    connect
        Makes the solver; the installed daemon when None.
    solver
        What identifies the solver in the frames' keys; that of the installed daemon when None.
    error_estimate
        Whether to solve on a coarser lattice too, to estimate the error (`lappet.solve.error_estimate`).
    limits
        What reading the file may take.

    Returns
    -------
    SolveResult
        What is done, and why no more.

    Raises
    ------
    RefusedError
        If the procedure has errors, cannot be solved at all, or the output cannot be written.
    """
    started = time.perf_counter()
    watch, output = _Noting(observer or SolveObserver()), Path(output)
    procedure, path, notes = read_source(source, output, limits)
    notes += check_source(procedure, settings)
    first, last = _range(procedure, frames)
    program = compile_program(procedure, settings=replace(settings, correction=error_estimate), until=last)
    for note in (*notes, *program.notes):
        watch.note(note)
    if connect is None or solver is None:
        connect = connect or connect_to(daemon)
        solver = solver or solver_identity(daemon)
    store = store or FrameStore()
    sharing = connect if share is None else connect_to(daemon, _shared(watch, share))
    result = solve_program(program, store, sharing, solver, watch)
    wanted = [frame for frame in result.frames if frame.constraints.time >= first]
    if not wanted and result.reason is not None and result.failed is None:
        raise RefusedError([result.reason])
    gauges = Gauges(program)
    measures = [gauges.measure(each.solved, tension=each is result.frames[-1]) for each in result.frames]
    found = result_notes(program, result.frames)
    found += suture_warnings(program, [row for each in measures for row in each.sutures])
    errors = None
    if error_estimate and result.frames:
        errors = _estimate(program, result, store, connect, solver, found)
        measures, errors = _with_errors(program, gauges, result.frames, measures, errors)
        _keep_assessment(store, procedure, result, found, errors, measures)
    if wanted:
        kept = slice(len(result.frames) - len(wanted), None)
        write_skin_cache(
            output, path, procedure, program, [each.solved for each in wanted], wanted[-1].key, measures[kept]
        )
    return SolveResult(
        procedure,
        program,
        result.frames,
        result.reason,
        result.interrupted,
        result.failed,
        output if wanted else None,
        time.perf_counter() - started,
        (*watch.notes, *found),
        errors,
        tuple(measures),
    )


def _with_errors(
    program: Program,
    gauges: Gauges,
    frames: Sequence[FrameResult],
    measures: list[FrameMeasures],
    errors: ErrorEstimate | None,
) -> tuple[list[FrameMeasures], ErrorEstimate | None]:
    """What is measured at each frame with its estimated errors; the estimate without what only these need."""
    if errors is None:
        return measures, None
    from lappet.solve.measure_errors import errors_of_measures  # as the estimate

    found = errors_of_measures(program, gauges, [frame.solved for frame in frames], measures, errors)
    return found, replace(errors, coarse=())


def _keep_assessment(
    store: FrameStore,
    procedure: Procedure,
    result: Frames,
    notes: Sequence[Problem],
    errors: ErrorEstimate | None,
    measures: Sequence[FrameMeasures],
) -> None:
    """Keep what is to be known of the frames beside them: who finds these in the store, as Blender does, finds it."""
    if errors is None or result.interrupted:
        return
    from lappet.background.assessment import Assessment, assessment_key, pulls_of  # as the estimate

    key = assessment_key([frame.key for frame in result.frames], True, procedure)
    store.put(key, Assessment(tuple(notes), errors.frames, tuple(pulls_of(each) for each in measures)))


def _shared(watch: SolveObserver, seconds: float) -> Callable[[int], None]:
    """Say which session is shared, and wait for those who follow."""

    def wait(session: int) -> None:
        watch.shared(session)
        time.sleep(seconds)

    return wait


def read_source(
    source: Path | str | Procedure | ProcedureFile, output: Path, limits: ReadLimits
) -> tuple[Procedure, Path, list[Problem]]:
    """Read a procedure; one that is no file is written beside the cache.

    Parameters
    ----------
    source
        A USD file, or one that is being read, or a procedure.
    output
        The skin cache.
    limits
        What reading the file may take.

    Returns
    -------
    tuple[Procedure, Path, list[Problem]]
        The procedure, the file that the skin cache goes over, and notes of what was converted while reading.

    Raises
    ------
    RefusedError
        If it is no procedure, or the cache would take its place or cannot be written.
    """
    if isinstance(source, Procedure):
        _refuse_output(output)
        path = output.with_suffix(".procedure.usda")
        write_procedure(source, path)
        return source, path, []
    path = source.path if isinstance(source, ProcedureFile) else Path(source)
    if path.resolve() == output.resolve():
        raise refused(ProblemCode.CACHE_IS_PROCEDURE, output)
    notes: list[Problem] = []
    with source if isinstance(source, ProcedureFile) else ProcedureFile(path, limits) as file:
        pxr()  # loaded while the child reads; the skin cache needs it
        procedure = file.procedure(notes)  # of a file that is not there nobody wants to hear about its cache
    _refuse_output(output)
    return procedure, path, notes


def _refuse_output(output: Path) -> None:
    """Refuse, before anything is solved, a file that the skin cache could not be written to."""
    if output.suffix not in SUFFIXES:
        raise refused(ProblemCode.CACHE_SUFFIX, output, output.suffix)
    if output.is_dir():
        raise refused(ProblemCode.CACHE_IS_FOLDER, output)
    folder = output.absolute().parent
    if not folder.is_dir():  # of a mistyped path nobody would find the cache
        raise refused(ProblemCode.FILE_NO_FOLDER, output, folder)
    try:
        with tempfile.TemporaryFile(dir=output.parent):
            pass
    except OSError as error:
        raise refused(ProblemCode.CACHE_NOT_WRITABLE, output, error.strerror or error) from error


def check_source(procedure: Procedure, settings: SolverSettings) -> list[Problem]:
    """Check a procedure before it is solved.

    Parameters
    ----------
    procedure
        The procedure.
    settings
        How it is solved.

    Returns
    -------
    list[Problem]
        The warnings and notes.

    Raises
    ------
    RefusedError
        If it has errors.
    """
    problems = check(procedure, spacing=settings.spacing or None)
    errors = [each for each in problems if each.severity == "error"]
    if errors:
        raise RefusedError(errors)
    return problems


def _estimate(
    program: Program, result: Frames, store: FrameStore, connect: Connect, solver: str, notes: list[Problem]
) -> ErrorEstimate | None:
    """The errors of the frames, None where the solve was stopped; what is to be known of them is added to the notes."""
    if result.interrupted:
        notes.append(problem(ProblemCode.ESTIMATE_SKIPPED, "", "the solve was stopped"))
        return None
    from lappet.solve.error_estimate import estimate_errors  # a solve without an estimate does not load it
    from lappet.solve.untrusted import untrusted

    errors = estimate_errors(program, result.frames, store, connect, solver)
    notes += untrusted(program, result.frames, errors)
    notes += several_notes(result.frames, errors.frames)
    return errors


def _range(procedure: Procedure, frames: tuple[int | None, int | None]) -> tuple[int, int]:
    times = frame_times(procedure)
    first = times[0] if frames[0] is None else frames[0]
    last = times[-1] if frames[1] is None else frames[1]
    if not times[0] <= first <= last <= times[-1]:
        raise refused(ProblemCode.FRAMES_OUTSIDE, ROOT, f"{first}:{last}", start=times[0], end=times[-1])
    return first, last


class _Noting(SolveObserver):
    """Pass everything on and keep the notes."""

    def __init__(self, observer: SolveObserver) -> None:
        self._watcher = observer
        self.notes: list[Problem] = []

    def begin(self, frames: int) -> None:
        self._watcher.begin(frames)

    def shared(self, session: int) -> None:
        self._watcher.shared(session)

    def iteration(self, iteration: Iteration) -> None:
        self._watcher.iteration(iteration)

    def frame(self, frame: FrameResult) -> None:
        self._watcher.frame(frame)

    def note(self, note: Problem) -> None:
        self.notes.append(note)
        self._watcher.note(note)
