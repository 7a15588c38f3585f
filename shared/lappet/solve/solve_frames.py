"""Solve a program: look up the frames that are known and have the solver find the rest."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

from lappet.core.digest import digest
from lappet.core.problem import Problem, ProblemsError, RefusedError, problem
from lappet.core.problem_code import ProblemCode
from lappet.daemon.frame_solver import Connect, FrameSolver, Iteration, SolverDiedError
from lappet.daemon.solved_frame import SolvedFrame
from lappet.program.keys import frame_keys
from lappet.program.program import FrameConstraints, Program
from lappet.solve.store import FrameStore

TRIES = 3

FAILURE_CODES = {
    "stopped": ProblemCode.FRAME_STOPPED,
    "not_finite": ProblemCode.FRAME_NOT_FINITE,
    "iterations": ProblemCode.FRAME_ITERATIONS,
    "no_descent": ProblemCode.FRAME_NO_DESCENT,
    "too_stiff": ProblemCode.FRAME_TOO_STIFF,
    "inverted": ProblemCode.FRAME_INVERTED,
    "in_bone": ProblemCode.FRAME_IN_BONE,
    "gap": ProblemCode.FRAME_GAP,
    "unreachable": ProblemCode.FRAME_UNREACHABLE,
    "blocked": ProblemCode.FRAME_BLOCKED,
}
"""What a `reason_code` of PROTOCOL.md is as a problem."""


class SolveObserver:
    """An observer of a solve; this one keeps silent."""

    def begin(self, frames: int) -> None:
        """Hear how many frames are to be had.

        Parameters
        ----------
        frames
            Number of frames.
        """

    def shared(self, session: int) -> None:
        """Hear that every user of the daemon may follow the session from now on.

        Parameters
        ----------
        session
            Number of the session.
        """

    def iteration(self, iteration: Iteration) -> None:
        """Hear of a Newton iteration.

        Parameters
        ----------
        iteration
            Where the solve stands.
        """

    def frame(self, frame: FrameResult) -> None:
        """Hear of a frame that is done.

        Parameters
        ----------
        frame
            The frame.
        """

    def note(self, note: Problem) -> None:
        """Hear something that the user should know.

        Parameters
        ----------
        note
            A warning or a note.
        """


@dataclass(frozen=True, eq=False)
class FrameResult:
    """A frame and how it was had.

    Parameters
    ----------
    constraints
        What acted on the tissue.
    key
        Content key of the frame.
    solved
        The frame, without the state.
    looked_up
        Whether it came from the store.
    wall_seconds
        Time that it took here in seconds.
    """

    constraints: FrameConstraints
    key: str
    solved: SolvedFrame
    looked_up: bool
    wall_seconds: float


@dataclass(frozen=True, eq=False)
class Frames:
    """The frames that `solve_program` got.

    Parameters
    ----------
    frames
        Frames that are done, the first ones in order.
    reason
        Why it ended before the last frame, a sentence, or None.
    interrupted
        Whether the user stopped it.
    failed
        The unconverged frame that stopped it, or None.
    """

    frames: tuple[FrameResult, ...]
    reason: Problem | None = None
    interrupted: bool = False
    failed: FrameResult | None = None


def solve_program(program: Program, store: FrameStore, connect: Connect, solver: str, watch: SolveObserver) -> Frames:
    """Get every frame of a program: from the store where it is there, else from a solver that is started when needed.

    A solver that dies is started again, at most three times for one frame, from the last frame's state.

    Parameters
    ----------
    program
        The program.
    store
        Where frames are kept.
    connect
        Makes the solver.
    solver
        What identifies it.
    watch
        Is told how the solve goes.

    Returns
    -------
    Frames
        The frames, and why there are no more.
    """
    keys = frame_keys(program, solver)
    watch.begin(len(keys))
    done: list[FrameResult] = []
    with _Session(program, connect) as session:
        for index, constraints in enumerate(program.frames):
            try:
                result = _frame(session, index, keys[index], store, watch)
                if not result.solved.converged:
                    return Frames(tuple(done), not_converged(result.solved), failed=result)
                done.append(result)
                watch.frame(result)
            except KeyboardInterrupt:
                stopped = problem(ProblemCode.SOLVE_STOPPED, "", len(done), frames=len(keys))
                return Frames(tuple(done), stopped, interrupted=True)
            except (RefusedError, SolverDiedError) as error:
                return Frames(tuple(done), at_frame(constraints.time, error))
    return Frames(tuple(done))


def not_converged(frame: SolvedFrame) -> Problem:
    """Return the problem of a frame that did not converge.

    Parameters
    ----------
    frame
        The frame.

    Returns
    -------
    Problem
        The problem.
    """
    return problem(failure_code(frame), f"Frame {frame.time:g}", frame.reason or "the solver gives no reason.")


def failure_code(frame: SolvedFrame) -> ProblemCode:
    """Return which kind of problem kept a frame from converging.

    Parameters
    ----------
    frame
        The frame.

    Returns
    -------
    ProblemCode
        The code; the general one where the solver names none that is known here.
    """
    return FAILURE_CODES.get(frame.diagnostics.reason_code, ProblemCode.FRAME_NOT_CONVERGED)


def at_frame(time: float, error: ProblemsError) -> Problem:
    """Take the first problem of what refused or ended the solve of a frame.

    Parameters
    ----------
    time
        Time code of the frame, which is the problem's prim if it has none.
    error
        What refused or ended the solve.

    Returns
    -------
    Problem
        The problem.
    """
    first = error.problems[0]
    return replace(first, prim=first.prim or f"Frame {time:g}")


def solver_restarted(time: float, error: SolverDiedError) -> Problem:
    """Return the note that the solver died while it was solving a frame, and is started again.

    Parameters
    ----------
    time
        Time code of the frame.
    error
        How it died.

    Returns
    -------
    Problem
        The note.
    """
    return problem(ProblemCode.DAEMON_RESTARTED, f"Frame {time:g}", f"{time:g}", said=error.problems[0].message)


def _frame(session: _Session, index: int, key: str, store: FrameStore, watch: SolveObserver) -> FrameResult:
    """A frame from the store or the solver; what is newly solved is kept."""
    begun = time.perf_counter()
    solved = store.get(key, SolvedFrame)
    looked_up = solved is not None
    if solved is None:
        solved = session.solve(index, watch)
    if solved.converged:
        session.remember(index, solved)
        well = store.trouble is None
        if not looked_up and not store.put(key, solved) and well and store.trouble is not None:
            watch.note(store.trouble)
    return FrameResult(
        session.program.frames[index],
        key,
        replace(solved, state=None),
        looked_up,
        time.perf_counter() - begun,
    )


class _Session:
    """A solver that is started when first needed and brought to the frame before the one that is wanted."""

    def __init__(self, program: Program, connect: Connect) -> None:
        self.program = program
        self._connect = connect
        self._solver: FrameSolver | None = None
        self._at: int | None = None  # the frame whose state the solver holds
        self._epoch: int | None = None  # the epoch that the solver holds
        self._last: tuple[int, SolvedFrame] | None = None
        self._before_hold: tuple[int, SolvedFrame] | None = None  # what came before the frames that ask for the same

    def __enter__(self) -> _Session:
        return self

    def __exit__(self, *_: object) -> None:
        self._close()

    def remember(self, index: int, frame: SolvedFrame) -> None:
        """Keep the last frame: the state to go on from."""
        if not self._holds(index):
            self._before_hold = self._last
        self._last = (index, frame)

    def _holds(self, index: int) -> bool:
        """Whether a frame asks for the same as the one before: the solver then gives it that one's numbers."""
        frames = self.program.frames
        return index > 0 and digest(replace(frames[index], time=0.0)) == digest(replace(frames[index - 1], time=0.0))

    def solve(self, index: int, watch: SolveObserver) -> SolvedFrame:
        """Solve a frame whose predecessor has been remembered."""
        frame = self.program.frames[index]
        for attempt in range(1, TRIES + 1):
            try:
                solver = self._prepare(index)
                solved = solver.solve(frame, watch.iteration)
            except SolverDiedError as error:
                self._abandon()
                if attempt == TRIES:
                    raise SolverDiedError.of(ProblemCode.DAEMON_DIED_AGAIN, "", TRIES, said=error) from error
                watch.note(solver_restarted(frame.time, error))
            except BaseException:
                self._abandon()
                raise
            else:
                if solved.converged:
                    self._at = index
                return solved
        raise AssertionError("unreachable")

    def _prepare(self, index: int) -> FrameSolver:
        """A solver that holds the state of the frame before `index` in the epoch of `index`."""
        previous = index - 1 if index > 0 else None
        if previous is not None and self._at != previous:
            if self._last is None or self._last[0] != previous:
                raise AssertionError(f"frame {index} is wanted before frame {previous}")
            if self._holds(index):
                self._solve_hold_until(index)
            else:
                self._go_back(self._connected(), self._last)
        solver = self._connected()
        self._set_epoch(solver, self.program.frames[index].epoch)
        return solver

    def _connected(self) -> FrameSolver:
        if self._solver is None:
            self._solver = self._connect(self.program.settings, self.program.bones)
        return self._solver

    def _solve_hold_until(self, index: int) -> None:
        """Solve again, from what came before, the frames that ask for the same as this one.

        A state does not hold the numbers that the solver gives to the next frame that asks for the same.
        """
        if self._before_hold is None:
            self._abandon()  # what came before is a new session
        else:
            self._go_back(self._connected(), self._before_hold)
        for held in self.program.frames[0 if self._before_hold is None else self._before_hold[0] + 1 : index]:
            self._set_epoch(self._connected(), held.epoch)
            self._connected().solve(held, lambda iteration: None)

    def _go_back(self, solver: FrameSolver, to: tuple[int, SolvedFrame]) -> None:
        """Give the solver the state after a frame."""
        self._set_epoch(solver, self.program.frames[to[0]].epoch)
        state = to[1].state
        assert state is not None
        solver.set_state(state.fitted(self.program.settings.sutures))

    def _set_epoch(self, solver: FrameSolver, epoch: int) -> None:
        if self._epoch == epoch:
            return
        position = next(i for i, each in enumerate(self.program.epochs) if each.index == epoch)
        program = self.program
        solver.set_epoch(program.epochs[position], program.grips[position], program.landmarks_at[position])
        self._epoch = epoch

    def _abandon(self) -> None:
        self._close()
        self._at = self._epoch = None

    def _close(self) -> None:
        solver, self._solver = self._solver, None
        if solver is not None:
            solver.close()
