"""Fuzz of whole procedures: small valid ones, made at random, go through the solve as a user's would.

The property: `solve_procedure` ends within a budget in frames that are finite and within their tolerances, or in a
sentence, and the daemon lives on. Needs hypothesis (the extra `test`).
"""

from __future__ import annotations

import math
import multiprocessing
import tempfile
import time
from collections import Counter, deque
from collections.abc import Callable
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lappet.bench.circumstances import cores
from lappet.core.problem import Problem, RefusedError, refused
from lappet.core.problem_code import ProblemCode
from lappet.daemon.daemon_solver import DaemonSolver
from lappet.daemon.frame_solver import FrameSolver
from lappet.daemon.process import SolverDaemon, find_daemon
from lappet.output.solve_to_cache import SolveResult, solve_procedure
from lappet.procedure import (
    MODELS,
    Event,
    Excision,
    Hook,
    Incision,
    Landmark,
    Material,
    Point,
    Procedure,
    Retractor,
    Suture,
    Tissue,
    Undermine,
)
from lappet.program.program import Bones
from lappet.program.settings import SolverSettings
from lappet.solve.store import FrameStore
from lappet.tissue.patch import flat_patch

if TYPE_CHECKING:
    from hypothesis.strategies import DrawFn, SearchStrategy

SIZE = (16.0, 12.0, 2.0)
TOP = SIZE[2]
FRAME_BUDGET = 20.0  # s that the daemon may take for a frame
BUDGET = 120.0  # s for a procedure
THREADS = 2  # of a daemon, whatever the machine has: the bits of a result depend on them
# One daemon serves all procedures and hears nothing while one is made and cut, which on a busy machine may take longer
# than it waits by itself.
PATIENT = ("--silence", "86400")


def procedures() -> SearchStrategy[Procedure]:
    """Make the strategy for procedures of 2 to 4 frames on a patch of 16 x 12 x 2 mm.

    Returns
    -------
    SearchStrategy[Procedure]
        The strategy.

    Raises
    ------
    RefusedError
        If hypothesis is missing.
    """
    try:
        from hypothesis import strategies as st
    except ImportError as error:
        raise refused(
            ProblemCode.REPORT_NEEDS, "", error, what="The fuzz", package="hypothesis", extra="test"
        ) from error

    def number(low: float, high: float) -> SearchStrategy[float]:
        # to a thousandth: simple numbers collide, which is what tissue does not like
        return st.integers(round(1000 * low), round(1000 * high)).map(lambda n: n / 1000)

    def place(draw: DrawFn, beyond: float = 0.0) -> Point:
        x, y = (draw(number(-side / 2 - beyond, side / 2 + beyond)) for side in SIZE[:2])
        return (x, y, TOP)

    def ring(draw: DrawFn) -> tuple[Point, ...]:
        """Around a middle, of any radius in every direction."""
        x, y = (draw(number(-0.4 * side, 0.4 * side)) for side in SIZE[:2])
        count, turn = draw(st.integers(3, 7)), draw(number(0.0, math.tau))
        arms = [(turn + math.tau * k / count, draw(number(0.3, 5.0))) for k in range(count)]
        return tuple((x + r * math.cos(a), y + r * math.sin(a), TOP) for a, r in arms)

    def incision(draw: DrawFn, name: str, at: float) -> Event:
        depth = draw(st.none() | number(0.1, 3.0))
        kerf = draw(st.sampled_from([0.05, 0.001, 0.2, 1.0]))
        closed = draw(st.booleans())
        if closed and draw(st.booleans()):
            points = ring(draw)
        else:  # through itself as it comes
            points = tuple(place(draw, beyond=1.0) for _ in range(draw(st.integers(3 if closed else 2, 5))))
        return Incision(name, at, points, depth, kerf, closed=closed)

    def undermine(draw: DrawFn, name: str, at: float) -> Event:
        return Undermine(name, at, ring(draw))

    def hook(draw: DrawFn, name: str, at: float) -> Event:
        anchor = place(draw)
        shift = tuple(draw(number(-6.0, 6.0)) for _ in range(3))
        target: Point = (anchor[0] + shift[0], anchor[1] + shift[1], anchor[2] + shift[2])
        stiffness = 10.0 ** draw(st.integers(-2, 8))
        samples = ((at, anchor), (at + draw(st.integers(1, 2)), target)) if draw(st.booleans()) else ((at, target),)
        return Hook(name, anchor, samples, at, at + draw(st.integers(1, 4)), stiffness)

    def suture(draw: DrawFn, name: str, at: float) -> Event:
        ends = (place(draw), place(draw))
        return Suture(name, ends, at, float(draw(st.integers(0, 2))), 10.0 ** draw(st.integers(-2, 8)))

    def retractor(draw: DrawFn, name: str, at: float) -> Event:
        angle, axis = math.radians(draw(number(-180.0, 180.0))), draw(st.integers(0, 2))
        matrix = np.eye(4)
        a, b = (axis + 1) % 3, (axis + 2) % 3
        matrix[[a, a, b, b], [a, b, a, b]] = math.cos(angle), math.sin(angle), -math.sin(angle), math.cos(angle)
        matrix[3, :3] = [draw(number(-5.0, 5.0)) for _ in range(3)]
        still = tuple(np.eye(4).reshape(-1))
        motion = ((at, still), (at + draw(st.integers(1, 3)), tuple(matrix.reshape(-1))))
        return Retractor(name, "jaw", motion, at, at + draw(st.integers(1, 4)))

    def landmark(draw: DrawFn, name: str, at: float) -> Event:
        return Landmark(name, (place(draw),), name)

    makers = (incision, incision, incision, undermine, hook, hook, suture, suture, retractor, landmark)

    def material(draw: DrawFn) -> Material:
        fiberd = draw(st.booleans())
        return Material(
            model=draw(st.sampled_from(MODELS)),
            youngs_modulus=10.0 ** draw(st.integers(-1, 4)),
            poissons_ratio=draw(st.sampled_from([0.45, 0.0, 0.3, 0.49, 0.499, 0.4999])),
            mooney_ratio=draw(st.sampled_from([0.0, 0.3, 2.0])),
            fiber_k1=10.0 if fiberd else 0.0,
            fiber_k2=draw(st.sampled_from([0.0, 1.0, 10.0, 50.0])) if fiberd else 0.0,
            fiber_dispersion=draw(st.sampled_from([0.0, 0.2, 1.0 / 3.0])) if fiberd else 0.0,
            prestretch=draw(st.sampled_from([(1.0, 1.0), (1.0, 1.0), (1.2, 1.1), (0.9, 1.0)])),
        )

    @st.composite
    def made(draw: DrawFn) -> Procedure:
        end = float(draw(st.integers(2, 4)))
        count = draw(st.integers(1, 7))
        events = [
            draw(st.sampled_from(makers))(draw, f"event_{k}", float(draw(st.integers(1, int(end)))))
            for k in range(count)
        ]
        rings = [event for event in events if isinstance(event, Incision) and event.closed and event.depth is None]
        taken: bool = draw(st.booleans())  # what was cut out is taken out
        if rings and taken:
            cut = draw(st.sampled_from(rings))
            seed = np.mean(cut.points, axis=0)
            events.append(Excision("out", min(cut.time + draw(st.integers(0, 1)), end), (tuple(seed),)))
        if sum(isinstance(event, Retractor) for event in events) > 1:  # there is one jaw
            first = next(event for event in events if isinstance(event, Retractor))
            events = [event for event in events if event is first or not isinstance(event, Retractor)]
        return Procedure(
            tissue=_tissue(
                draw(st.sampled_from([2.0, 1.0, 1.5])),
                rim=draw(st.sampled_from([True, True, False])),
                bed=draw(st.sampled_from([True, True, False])),
                gravity=draw(st.sampled_from([None, None, 9.81])),
            ),
            materials=(material(draw),),
            events=tuple(events),
            start_time=1.0,
            end_time=end,
        )

    return made()


def _tissue(spacing: float, *, rim: bool, bed: bool, gravity: float | None) -> Tissue:
    patch = flat_patch(SIZE, resolution=2.0, spacing=spacing, gravity=gravity)
    middles = patch.points[patch.face_vertex_indices.reshape(-1, 4)].mean(axis=1)
    jaw = np.flatnonzero(middles[:, 0] > SIZE[0] / 2 - 1e-6)
    fixed = np.setdiff1d(patch.subsets["fixed"], jaw)
    subsets = {"jaw": jaw, **({"fixed": fixed} if rim else {}), **({"bed": patch.subsets["bed"]} if bed else {})}
    return replace(patch, subsets={name: faces.astype(np.int32) for name, faces in subsets.items()})


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


def told(procedure: Procedure) -> str:
    """Describe all that a procedure of `procedures` is made of, to make it again.

    Parameters
    ----------
    procedure
        The procedure.

    Returns
    -------
    str
        The text.
    """
    tissue = procedure.tissue
    lines = [
        f"spacing {tissue.spacing}, gravity {tissue.gravity}, subsets {sorted(tissue.subsets)}, "
        f"end {procedure.end_time}",
        str(asdict(procedure.materials[0])),
        *(f"{event.kind} {asdict(event)}" for event in procedure.events),
    ]
    return "\n".join(lines)
