"""Follow a session that somebody else solves, and write the skin cache of the frames that were seen."""

from __future__ import annotations

import time
from pathlib import Path

from lappet.core.problem import RefusedError
from lappet.daemon.running_daemon import RunningDaemon
from lappet.foreign.limits import DEFAULT_LIMITS, ReadLimits
from lappet.output.skin_cache import write_skin_cache
from lappet.output.solve_to_cache import SolveResult, check_source, read_source
from lappet.procedure import Procedure
from lappet.program.compile import DEFAULT, compile_program
from lappet.program.settings import SolverSettings
from lappet.solve.follow_frames import follow_program
from lappet.solve.measures import Gauges
from lappet.solve.result_notes import result_notes
from lappet.solve.solve_frames import SolveObserver
from lappet.solve.suture_forces import suture_warnings
from lappet.usd.procedure_file import ProcedureFile


def follow_procedure(
    source: Path | str | Procedure | ProcedureFile,
    output: Path | str,
    daemon: RunningDaemon,
    session: int,
    settings: SolverSettings = DEFAULT,
    *,
    observer: SolveObserver | None = None,
    limits: ReadLimits = DEFAULT_LIMITS,
) -> SolveResult:
    """Follow a session until it is over, and write the skin cache of its frames.

    The daemon tells what is found, not what is asked: procedure and settings are those that the author solves with. The
    frames are the author's bit for bit; without their error estimate, so is the cache.

    Parameters
    ----------
    source
        A USD file, or one that is being read, or a procedure, which is then written beside the cache as `<its
        stem>.procedure.usda`.
    output
        The skin cache (.usdc, .usda or .usd).
    daemon
        The daemon, which must have keys.
    session
        Number of the session, which its author was told (`lappet solve --share`).
    settings
        How the author solves.
    observer
        Is told how the solve goes.
    limits
        What reading the file may take.

    Returns
    -------
    SolveResult
        What was seen, and why no more; there is no error estimate.

    Raises
    ------
    RefusedError
        If the procedure cannot be solved, the output cannot be written, the daemon refuses, the session solves another
        procedure, or nothing was seen.
    DaemonDied
        If the daemon is gone before anything was seen.
    """
    started = time.perf_counter()
    watch, output = observer or SolveObserver(), Path(output)
    procedure, path, notes = read_source(source, output, limits)
    notes += check_source(procedure, settings)
    program = compile_program(procedure, settings=settings)
    for note in (*notes, *program.notes):
        watch.note(note)
    result = follow_program(program, daemon, session, watch)
    if not result.frames and result.reason is not None and result.failed is None:
        raise RefusedError([result.reason])
    gauges = Gauges(program)
    measures = [gauges.measure(each.solved, tension=each is result.frames[-1]) for each in result.frames]
    found = result_notes(program, result.frames)
    found += suture_warnings(program, [row for each in measures for row in each.sutures])
    written = None
    if result.frames:
        solved = [each.solved for each in result.frames]
        write_skin_cache(output, path, procedure, program, solved, result.frames[-1].key, measures)
        written = output
    return SolveResult(
        procedure,
        program,
        result.frames,
        result.reason,
        result.interrupted,
        result.failed,
        written,
        time.perf_counter() - started,
        (*notes, *program.notes, *found),
        None,
        tuple(measures),
    )
