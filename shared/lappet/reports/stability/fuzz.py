"""Fuzz of whole procedures: those of `random_procedures` go through the solve as a user's would.

The property: `solve_procedure` ends within a budget in frames that are finite and within their tolerances, or in a
sentence, and the daemon lives on. Needs hypothesis (the extra `test`).
"""

from __future__ import annotations

import multiprocessing
import tempfile
import time
from collections import Counter, deque
from collections.abc import Callable
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from lappet.bench.circumstances import cores
from lappet.core.problem import Problem, RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.daemon.daemon_solver import DaemonSolver
from lappet.daemon.frame_solver import FrameSolver
from lappet.daemon.process import SolverDaemon, find_daemon
from lappet.output.solve_to_cache import SolveResult, solve_procedure
from lappet.procedure import Procedure
from lappet.program.program import Bones
from lappet.program.settings import SolverSettings
from lappet.reports.stability.random_procedures import procedures, told
from lappet.solve.store import FrameStore

FRAME_BUDGET = 20.0  # s that the daemon may take for a frame
BUDGET = 120.0  # s for a procedure
THREADS = 2  # of a daemon, whatever the machine has: the bits of a result depend on them
# One daemon serves all procedures and hears nothing while one is made and cut, which on a busy machine may take longer
# than it waits by itself.
PATIENT = ("--silence", "86400")


FAULTS = frozenset(
    {
        ProblemCode.INTERNAL,
        ProblemCode.WIRE_MALFORMED,
        ProblemCode.SOLVER_MALFORMED,
        ProblemCode.SOLVER_OUT_OF_ORDER,
        ProblemCode.SOLVER_INTERNAL,
        ProblemCode.SOLVER_TIME_BUDGET,
        ProblemCode.FRAME_NOT_FINITE,
        ProblemCode.DAEMON_DIED,
        ProblemCode.DAEMON_DIED_AGAIN,
        ProblemCode.DAEMON_SILENT,
    }
)
"""Refusals that are none: the program is at fault, or the time ran out."""


@dataclass(frozen=True)
class Verdict:
    """What became of a procedure.

    Parameters
    ----------
    wrong
        What breaks the property, a sentence; empty if nothing does.
    reason
        Why it was refused, else empty.
    late
        Whether what is wrong is the time it took.
    """

    wrong: str = ""
    reason: Problem | None = None
    late: bool = False


def judge(procedure: Procedure, daemon: SolverDaemon, folder: Path) -> Verdict:
    """Solve a procedure and judge what became of it.

    Parameters
    ----------
    procedure
        The procedure.
    daemon
        A daemon that runs, and must go on running.
    folder
        Folder for the skin cache.

    Returns
    -------
    Verdict
        The verdict.
    """

    def connect(settings: SolverSettings, bones: Bones) -> FrameSolver:
        return DaemonSolver(
            replace(settings, time_budget=FRAME_BUDGET, threads=THREADS), bones, daemon.address, daemon.token
        )

    begun = time.monotonic()
    cache = folder / "cache.usdc"
    try:
        with tempfile.TemporaryDirectory() as store:
            result = solve_procedure(
                procedure, cache, connect=connect, solver="fuzz", store=FrameStore(Path(store)), error_estimate=False
            )
    except RefusedError as error:
        if daemon.alive():
            return _refused(error.problems[0])
        return Verdict(f"The daemon died: {daemon.death()}")
    except Exception as error:
        return Verdict(f"{type(error).__name__}: {error}")
    if not daemon.alive():
        return Verdict(f"The daemon died: {daemon.death()}")
    if time.monotonic() - begun > BUDGET:
        return Verdict(f"It took {time.monotonic() - begun:.0f} s.", late=True)
    claims = _claims(result)
    if result.reason is not None and not claims:
        return _refused(result.reason)
    return Verdict(claims, result.reason)


def _refused(reason: Problem) -> Verdict:
    return Verdict(_unfit(reason), reason, late=reason.code is ProblemCode.SOLVER_TIME_BUDGET)


def _unfit(reason: Problem) -> str:
    """Why a reason is none: it tells of a fault or of time that ran out, or says nothing."""
    if reason.code in FAULTS:
        return f"It is refused with: {reason}"
    return "" if reason.message.strip() else "It is refused without a word."


def _claims(result: SolveResult) -> str:
    settings = result.program.settings
    for frame in result.frames:
        at, said = f"Frame {frame.constraints.time:g}", frame.solved.diagnostics
        for name, array in frame.solved.arrays().items():
            if array.dtype.kind == "f" and not np.isfinite(array).all():
                return f"{at} holds numbers in '{name}' that are not finite."
        if not said.residual <= settings.tolerance:
            return f"{at} is called converged at a relative residual of {said.residual:.2e}."
        if not said.largest_gap <= settings.gap_tolerance * settings.spacing:
            return f"{at} is called converged with a gap of {said.largest_gap:.3g} mm."
    return ""


def fuzz(count: int, say: Callable[[str], None] = lambda _: None, jobs: int | None = None) -> dict[str, Any]:
    """Solve procedures made at random, the same ones every time.

    Parameters
    ----------
    count
        Number of procedures.
    say
        Is told how it goes.
    jobs
        How many at once, each in a process and with a daemon of its own; one per core when None.

    Returns
    -------
    dict[str, Any]
        Their number `procedures`, how many were `solved` to the end, why others were `refused` (the sentences without
        their numbers, counted), and the `failures`, each with its `wrong` and its `procedure` (`told`).

    Raises
    ------
    RefusedError
        If hypothesis is missing.
    DaemonMissing
        If there is no daemon.
    """
    from hypothesis import HealthCheck, Phase, given, settings

    jobs = jobs or cores()
    strategy = procedures()
    find_daemon()  # raises here rather than in every process
    failures: list[dict[str, str]] = []
    reasons: Counter[str] = Counter()
    done = solved = 0
    waiting: deque[tuple[Procedure, Future[Verdict]]] = deque()

    def take() -> None:
        nonlocal done, solved
        procedure, future = waiting.popleft()
        verdict = future.result()
        done += 1
        if verdict.reason:
            reasons[verdict.reason.code] += 1
        solved += not verdict.reason and not verdict.wrong
        if verdict.wrong:
            failures.append({"wrong": verdict.wrong, "procedure": told(procedure)})
            say(f"{done}: {verdict.wrong}")
        elif done % 100 == 0:
            say(f"{done} procedures, {len(failures)} failures")

    # spawned: a fork would copy the locks of whatever threads the caller has
    with ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn")) as pool:

        @settings(
            max_examples=count,
            derandomize=True,
            deadline=None,
            database=None,
            phases=(Phase.generate,),
            suppress_health_check=list(HealthCheck),
        )
        @given(strategy)
        def run(procedure: Procedure) -> None:
            waiting.append((procedure, pool.submit(_judge_here, procedure)))
            if len(waiting) > 4 * jobs:
                take()

        run()
        while waiting:
            take()
    return {
        "procedures": done,
        "solved": solved,
        "refused": dict(reasons.most_common()),
        "failures": failures,
    }


_daemons: list[SolverDaemon] = []  # of this process: the one that runs


def _judge_here(procedure: Procedure) -> Verdict:
    if _daemons and not _daemons[-1].alive():
        _daemons.pop().stop()
    if not _daemons:
        _daemons.append(SolverDaemon(arguments=PATIENT).start())  # ends with this process
    with tempfile.TemporaryDirectory() as folder:
        verdict = judge(procedure, _daemons[-1], Path(folder))
        # A busy machine may hold up anything once.
        return judge(procedure, _daemons[-1], Path(folder)) if verdict.late else verdict
