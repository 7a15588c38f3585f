"""Solves a procedure: looks up the frames that are known, has the daemon solve the rest, and writes the skin cache."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

from lappet.core.problem import RefusedError
from lappet.daemon.frame_solver import (
    Connect,
    FrameSolver,
    Iteration,
    SolverDiedError,
)
from lappet.daemon.solved_frame import SolvedFrame
from lappet.program.keys import frame_keys
from lappet.program.program import FrameConstraints, Program
from lappet.solve.store import FrameStore

TRIES = 3


class SolveObserver:
    """Is told how a solve goes; this one keeps silent."""

    def begin(self, frames: int) -> None:
        """So many frames are to be had."""

    def iteration(self, iteration: Iteration) -> None:
        """A Newton iteration is done."""

    def frame(self, frame: FrameResult) -> None:
        """A frame is there."""

    def note(self, sentence: str) -> None:
        """Something that the user should know."""


@dataclass(frozen=True, eq=False)
class FrameResult:
    """A frame and how it was had. solved: without the state. looked_up: it came from the store. wall_seconds: the time
    it took here.
    """

    constraints: FrameConstraints
    key: str
    solved: SolvedFrame
    looked_up: bool
    wall_seconds: float


@dataclass(frozen=True, eq=False)
class Frames:
    """The frames that `solve_program` got, and why it ended where it did not get all of them."""

    frames: tuple[FrameResult, ...]
    reason: str | None = None
    interrupted: bool = False
    failed: FrameResult | None = None


def solve_program(program: Program, store: FrameStore, connect: Connect, solver: str, watch: SolveObserver) -> Frames:
    """Gets every frame of a program, from the store where it is there, else from a solver that is started when needed.

    A solver that dies is started again, at most three times for one frame, from the last frame's state.
    """
    keys = frame_keys(program, solver)
    watch.begin(len(keys))
    done: list[FrameResult] = []
    with _Session(program, connect) as session:
        for index, constraints in enumerate(program.frames):
            try:
                result = _frame(session, index, keys[index], store, watch)
                if not result.solved.converged:
                    why = result.solved.diagnostics.reason or "the solver gave no reason."
                    return Frames(tuple(done), f"Frame {constraints.time:g} did not converge: {why}", failed=result)
                done.append(result)
                watch.frame(result)
            except KeyboardInterrupt:
                return Frames(tuple(done), f"Stopped: {len(done)} of {len(keys)} frames are done.", interrupted=True)
            except (RefusedError, SolverDiedError) as error:
                return Frames(tuple(done), f"Frame {constraints.time:g} was not solved: {error}")
    return Frames(tuple(done))


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
        if not looked_up and not store.put(key, solved) and well:
            watch.note(str(store.trouble))
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

    def __enter__(self) -> _Session:
        return self

    def __exit__(self, *_: object) -> None:
        self._close()

    def remember(self, index: int, frame: SolvedFrame) -> None:
        """Keeps the last frame: the state to go on from."""
        self._last = (index, frame)

    def solve(self, index: int, watch: SolveObserver) -> SolvedFrame:
        """Solves a frame whose predecessor has been remembered."""
        frame = self.program.frames[index]
        for attempt in range(1, TRIES + 1):
            try:
                solver = self._prepare(index)
                solved = solver.solve(frame, watch.iteration)
            except SolverDiedError as error:
                self._abandon()
                if attempt == TRIES:
                    raise SolverDiedError(f"{error} That was try {TRIES} of {TRIES}.") from error
                watch.note(f"{error} It was solving frame {frame.time:g} and is started again.")
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
        if self._solver is None:
            self._solver = self._connect(self.program.settings, self.program.bones)
        previous = index - 1 if index > 0 else None
        if previous is not None and self._at != previous:
            if self._last is None or self._last[0] != previous:
                raise AssertionError(f"frame {index} is wanted before frame {previous}")
            self._set_epoch(self._solver, self.program.frames[previous].epoch)
            state = self._last[1].state
            assert state is not None
            self._solver.set_state(state.fitted(self.program.settings.sutures))
        self._set_epoch(self._solver, self.program.frames[index].epoch)
        return self._solver

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
