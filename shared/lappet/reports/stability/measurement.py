"""The stability matrix: each case is solved by a daemon of its own and held against the outcome that physics asks for.

A converged frame is not believed: its arrays must be finite, its residual and gap within their tolerances also when the
double precision kernels evaluate them at the state that came back, and the case may check the shape itself.
"""

from __future__ import annotations

import contextlib
import math
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Problem, RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.daemon.client import SolverClient
from lappet.daemon.frame_solver import Iteration, SolverDiedError
from lappet.daemon.lattice_counts import LatticeCounts
from lappet.daemon.process import SolverDaemon
from lappet.daemon.solved_frame import SolvedFrame
from lappet.daemon.solver_state import SolverState
from lappet.daemon.wire import WireError
from lappet.program.program import Program
from lappet.reports.stability.case import Case, Demand, Row, Scene, Solved, Start
from lappet.solve.sensitive import UNSTABLE, is_sensitive
from lappet.solve.solve_frames import not_converged

# A float state lies within its tolerance as float sees it; in double precision it may be this much worse.
VERIFIED = 1.5
DEEPEST = 0.1  # spacings that tissue may lie in bone
# A daemon that has not answered this many budgets, and some seconds, after it was asked hangs: it is ended.
PATIENCE, GRACE = 1.5, 10.0


def run_cases(cases: Iterable[Case], say: Callable[[str], None] = lambda _: None) -> Iterator[Row]:
    """Run cases one after the other.

    Parameters
    ----------
    cases
        The cases.
    say
        Is told of every case.

    Yields
    ------
    Row
        What became of each.
    """
    for case in cases:
        row = run_case(case)
        say(f"{'ok ' if row.ok else 'NOT'} {row.case}: {row.outcome} in {row.seconds:.1f} s. {row.reason}".rstrip())
        yield row


def run_case(case: Case) -> Row:
    """Run a case; nothing is raised but what ends the program.

    Parameters
    ----------
    case
        The case.

    Returns
    -------
    Row
        What became of it.
    """
    begun = time.perf_counter()
    row = Row(
        case.name, case.group, case.expected, "converges", "", None, None, None, None, 0, 0, 0.0, case.budget, False
    )
    watchdog = _Watchdog(PATIENCE * case.budget + GRACE)
    try:
        made = case.scene()
        scene = made if isinstance(made, Scene) else Scene(made)
        with SolverDaemon() as daemon, watchdog.over(daemon), SolverClient(daemon=daemon) as client:
            row = _solve(client, scene, case, row)
    except SolverDiedError as error:
        row = replace(row, outcome="hangs" if watchdog.bit else "crashes", reason=str(error))
    except RefusedError as error:
        row = replace(row, outcome="refuses", reason=str(error), code=error.problems[0].code)
    except WireError as error:
        row = replace(row, outcome="wrong", reason=f"The daemon's answer is no answer: {error}")
    except Exception as error:
        row = replace(row, outcome="crashes", reason=f"{type(error).__name__}: {error}".splitlines()[0])
    seconds = time.perf_counter() - begun
    right = row.code is case.demands if row.outcome == "refuses" else row.outcome == case.demands
    if right and seconds > case.budget:
        row = replace(row, reason=f"{row.reason} It took {seconds:.0f} s, more than its budget.".strip())
    return replace(row, seconds=seconds, ok=right and seconds <= case.budget)


def _solve(client: SolverClient, scene: Scene, case: Case, row: Row) -> Row:
    settings = replace(scene.program.settings, time_budget=case.budget)
    program = replace(scene.program, settings=settings)
    twin = None
    other = scene.twin or (program if scene.start is not None else None)
    if other is not None:
        before, reason, _ = _frames(client, other, None)
        if reason:
            said = f"What it is compared with is refused already: {reason}"
            return replace(row, outcome="refuses", reason=said, code=reason.code)
        twin = before[-1]
    frames, reason, cells = _frames(client, program, scene.start)
    finite = [frame for frame in frames if frame.converged]
    row = replace(
        row,
        frames=len(finite),
        cells=cells,
        residual=max((frame.diagnostics.residual for frame in finite), default=None),
        gap_mm=max((frame.diagnostics.largest_gap for frame in finite), default=None),
        lowest_stiffness=finite[-1].diagnostics.lowest_stiffness if finite else None,
    )
    wrong = next(filter(None, (_disproved(frame, program) for frame in frames)), "")
    if not wrong and finite and not case.slow and _begins_as_it_ended(program):
        residual, gap = _again(client, program, finite[-1])
        row = replace(row, verified_residual=residual)
        if residual is not None and not residual <= VERIFIED * settings.tolerance:
            wrong = f"In double precision its relative residual is {residual:.2e}."
        elif gap is not None and not gap <= VERIFIED * settings.gap_tolerance * settings.spacing:
            wrong = f"In double precision its gap is {gap:.3g} mm."
    if not wrong and reason is None and scene.check is not None:
        wrong = scene.check(Solved(program, tuple(frames), twin))
    if wrong:
        return replace(row, outcome="wrong", reason=wrong)
    if reason is not None:
        return replace(row, outcome="refuses", reason=str(reason), code=reason.code)
    return replace(row, outcome=_demand_met(case.demands, scene, frames))


def _demand_met(demands: Demand | ProblemCode, scene: Scene, frames: list[SolvedFrame]) -> Demand:
    """What became of frames that converged: what is demanded of them if they meet it, else that they converge."""
    met = {
        Demand.BUCKLES: scene.check is not None,  # it has passed, and looks at the shape
        Demand.IS_SENSITIVE: is_sensitive(frames[-1]),
    }
    return demands if isinstance(demands, Demand) and met.get(demands, False) else Demand.CONVERGES


def _frames(
    client: SolverClient, program: Program, start: Start | None
) -> tuple[list[SolvedFrame], Problem | None, int]:
    """The frames up to the first one that fails (included), why it failed, and the most cells of an epoch."""
    client.open(program.settings, program.bones)
    frames: list[SolvedFrame] = []
    at, cells = None, 0
    for frame in program.frames:
        if frame.epoch != at:
            lattice, nodes = _set_epoch(client, program, frame.epoch)
            cells, at = max(cells, lattice.cells), frame.epoch
            if start is not None and not frames:
                client.set_state(_state(program, start(nodes) - nodes))
        frames.append(client.solve(frame))
        if not frames[-1].converged:
            return frames, not_converged(frames[-1]), cells
    return frames, None, cells


def _set_epoch(client: SolverClient, program: Program, index: int) -> tuple[LatticeCounts, NDArray[np.float64]]:
    at = next(i for i, epoch in enumerate(program.epochs) if epoch.index == index)
    return client.set_epoch_with_nodes(program.epochs[at], program.grips[at], program.landmarks_at[at])


def _state(program: Program, displacements: NDArray[np.float64]) -> SolverState:
    """A state with these displacements (N, 3) in which nothing has acted yet."""
    settings = program.settings
    return SolverState(
        settings.precision,
        displacements,
        np.full((settings.sutures, 3), np.nan),
        np.zeros((settings.sutures, 3)),
        np.zeros(0),
        np.zeros(len(settings.materials)),
    )


def _disproved(frame: SolvedFrame, program: Program) -> str:
    """What a frame's own numbers say against it, a sentence; empty if nothing."""
    assert frame.state is not None
    state = frame.state
    held = {
        **frame.arrays(),
        "nodes": state.nodes,
        "suture_multipliers": state.suture_multipliers,
        "grip_multipliers": state.grip_multipliers,
        "stability": state.stability,
    }
    for name, array in held.items():
        if array.dtype.kind == "f" and not np.isfinite(array).all():
            return f"Frame {frame.time:g} holds numbers in '{name}' that are not finite."
    if not frame.converged:
        return ""
    settings = program.settings
    residual, gap = frame.diagnostics.residual, frame.diagnostics.largest_gap
    if not residual <= settings.tolerance:
        return f"Frame {frame.time:g} is called converged at a relative residual of {residual:.2e}."
    if not gap <= settings.gap_tolerance * settings.spacing:
        return f"Frame {frame.time:g} is called converged with a gap of {gap:.3g} mm."
    deep = frame.diagnostics.largest_penetration
    if not deep <= DEEPEST * settings.spacing:
        return f"Frame {frame.time:g} is called converged with tissue {deep:.3g} mm deep in bone."
    if frame.diagnostics.lowest_stiffness < UNSTABLE:
        return f"Frame {frame.time:g} is unstable: its stiffness is {frame.diagnostics.lowest_stiffness:.2g}."
    if not math.isfinite(frame.diagnostics.energy):
        return f"Frame {frame.time:g} is called converged and its energy is not finite."
    return ""


def _begins_as_it_ended(program: Program) -> bool:
    """Whether a state holds all that a frame ended with: the multipliers of bones and of stiff hooks are not kept."""
    settings = program.settings
    stiff = 1000.0 * max(material.youngs_modulus for material in settings.materials) * settings.spacing
    hooked = max((float(frame.hook_stiffness.max(initial=0.0)) for frame in program.frames), default=0.0)
    return hooked <= stiff and not len(program.bones.triangles)


class _SeenError(Exception):
    """The first iteration has been told."""


def _again(client: SolverClient, program: Program, frame: SolvedFrame) -> tuple[float | None, float | None]:
    """The relative residual and the gap (mm) of a converged frame in double precision; None where nothing is said."""
    client.open(replace(program.settings, precision="double"), program.bones)
    constraints = next(each for each in program.frames if each.time == frame.time)
    _set_epoch(client, program, constraints.epoch)
    assert frame.state is not None
    nodes, no_motion = np.asarray(frame.state.nodes, np.float64), np.zeros((0, 3), np.float32)
    client.set_state(replace(frame.state, precision="double", nodes=nodes, motion=no_motion))
    told: list[Iteration] = []

    def first(iteration: Iteration) -> None:
        told.append(iteration)
        raise _SeenError

    with contextlib.suppress(_SeenError, RefusedError):
        client.solve(constraints, first)
    return (told[0].residual, told[0].gap) if told and told[0].newton == 0 else (None, None)


class _Watchdog:
    """End a daemon that does not answer in time. bit: it has."""

    def __init__(self, seconds: float) -> None:
        self.bit = False
        self._seconds = seconds

    @contextlib.contextmanager
    def over(self, daemon: SolverDaemon) -> Iterator[None]:
        """Watch over a daemon that runs."""

        def bite() -> None:
            self.bit = True
            daemon.stop(patience=0.5)

        timer = threading.Timer(self._seconds, bite)
        timer.start()
        try:
            yield
        finally:
            timer.cancel()
