"""Live mode's session: one frame with something dragged, solved again and again from where the tissue is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from lappet.background.held import Held
from lappet.core.problem import Problem
from lappet.daemon.frame_solver import Connect, FrameSolver, Iteration, SolverDiedError
from lappet.daemon.solved_frame import SolvedFrame
from lappet.daemon.solver_state import SolverState
from lappet.procedure import Pose
from lappet.program.program import Program
from lappet.solve.solve_frames import TRIES, solver_restarted

TOLERANCE = 1e-2  # residual over force scale: what is shown while the mouse moves needs no more
TIME_BUDGET = 2.0  # seconds for a target


class LiveSession:
    """A session that holds one frame of a program; what it finds is never stored: it depends on the way there.

    Parameters
    ----------
    program
        The program.
    index
        Index of the frame.
    held
        What is dragged.
    start
        Epoch and frame of the state to begin with, that of the frame itself or of the one before; None: at rest.
    connect
        Makes the solver.
    note
        Takes a note when the solver had to be started again.
    """

    def __init__(
        self,
        program: Program,
        index: int,
        held: Held,
        start: tuple[int, SolvedFrame] | None,
        connect: Connect,
        note: Callable[[Problem], None],
    ) -> None:
        settings = program.settings
        # Where the tissue follows a drag, the next update shows soon enough that it rests nowhere else.
        self._settings = replace(
            settings,
            tolerance=max(settings.tolerance, TOLERANCE),
            time_budget=TIME_BUDGET,
            correction=False,
            strain=False,
            live=True,
            stability=False,
        )
        self._program = program
        self._frame = program.frames[index]
        self._held = held
        self._connect = connect
        self._note = note
        self._solver: FrameSolver | None = None
        self._state: tuple[int, SolverState] | None = None  # with the epoch that it belongs to
        if start is not None:
            self._keep(start[0], start[1])

    @property
    def own_target(self) -> Pose:
        """Where the program has what is dragged."""
        return self._held.own_target(self._frame)

    def pull(self, target: Pose, progress: Callable[[Iteration], None]) -> SolvedFrame:
        """Find the equilibrium with it at a target; where there is none the tissue stays where it was.

        Parameters
        ----------
        target
            The target.
        progress
            Called at every Newton iteration; what it raises ends the solve.

        Returns
        -------
        SolvedFrame
            The frame.

        Raises
        ------
        FrameRefusedError
            If the solver refuses the frame.
        SolverDiedError
            If the solver died three times in a row.
        """
        frame = self._held.moved(self._frame, target)
        for attempt in range(1, TRIES + 1):
            try:
                solved = self._open().solve(frame, progress)
            except SolverDiedError as error:
                self.close()
                if attempt == TRIES:
                    raise
                self._note(solver_restarted(self._frame.time, error))
            else:
                if solved.converged:
                    self._keep(frame.epoch, solved)
                return solved
        raise AssertionError("unreachable")

    def close(self) -> None:
        """End the session."""
        solver, self._solver = self._solver, None
        if solver is not None:
            solver.close()

    def _open(self) -> FrameSolver:
        if self._solver is None:
            solver = self._solver = self._connect(self._settings, self._program.bones)
            epoch = None
            if self._state is not None:
                epoch, state = self._state
                self._set_epoch(solver, epoch)
                solver.set_state(state)
            if epoch != self._frame.epoch:
                self._set_epoch(solver, self._frame.epoch)
        return self._solver

    def _set_epoch(self, solver: FrameSolver, epoch: int) -> None:
        program = self._program
        at = next(i for i, each in enumerate(program.epochs) if each.index == epoch)
        solver.set_epoch(program.epochs[at], program.grips[at], program.landmarks_at[at])

    def _keep(self, epoch: int, solved: SolvedFrame) -> None:
        assert solved.state is not None
        self._state = epoch, solved.state.fitted(self._program.settings.sutures)
