"""What the solve asks of whoever finds the equilibrium of a frame; `lappet.daemon.daemon_solver` asks the daemon."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import ProblemsError, RefusedError
from lappet.cutting.epoch import Epoch
from lappet.daemon.lattice_counts import LatticeCounts
from lappet.daemon.solved_frame import SolvedFrame
from lappet.daemon.solver_state import SolverState
from lappet.program.program import Bones, FrameConstraints, Landmarks
from lappet.program.settings import SolverSettings


class SolverDiedError(ProblemsError, RuntimeError):
    """The daemon ended or fell silent in the middle of its work; the work may be tried again with a new one."""


class FrameRefusedError(RefusedError):
    """The daemon refused an epoch or a frame (a budget, a value); asking again would not help."""


@dataclass(frozen=True)
class Iteration:
    """Where the solve of a frame stands.

    Parameters
    ----------
    time
        Time code.
    newton
        Number of the Newton iteration.
    residual
        Residual over force scale.
    gap
        Largest gap in mm.
    """

    time: float
    newton: int
    residual: float
    gap: float


class FrameSolver(Protocol):
    """A session that is told epochs and frames in order; every method may raise `SolverDiedError`."""

    def set_epoch(self, epoch: Epoch, grip: NDArray[np.int32], landmarks: Landmarks) -> LatticeCounts:
        """Install an epoch, carrying the state over.

        Parameters
        ----------
        epoch
            The epoch.
        grip
            Retractor that grips each triangle, or -1, shape (m,).
        landmarks
            The landmarks that the epoch's tissue holds.

        Returns
        -------
        Mapping[str, Any]
            Counts of the lattice.

        Raises
        ------
        FrameRefusedError
            If the solver refuses the epoch.
        """

    def set_epoch_with_nodes(
        self, epoch: Epoch, grip: NDArray[np.int32], landmarks: Landmarks
    ) -> tuple[LatticeCounts, NDArray[np.float64]]:
        """Install an epoch like `set_epoch`, and tell where its lattice's nodes are.

        Parameters
        ----------
        epoch
            The epoch.
        grip
            Retractor that grips each triangle, or -1, shape (m,).
        landmarks
            The landmarks that the epoch's tissue holds.

        Returns
        -------
        tuple[LatticeCounts, NDArray[np.float64]]
            Counts of the lattice, and its nodes at rest in mm, shape (N, 3), in the order of a state.

        Raises
        ------
        FrameRefusedError
            If the solver refuses the epoch.
        """

    def set_state(self, state: SolverState) -> None:
        """Replace the state by that of an earlier frame of this epoch.

        Parameters
        ----------
        state
            The state.
        """

    def solve(self, frame: FrameConstraints, progress: Callable[[Iteration], None]) -> SolvedFrame:
        """Find the equilibrium of a frame; KeyboardInterrupt cancels it.

        Parameters
        ----------
        frame
            The frame's constraints.
        progress
            Called at every Newton iteration.

        Returns
        -------
        SolvedFrame
            The frame.

        Raises
        ------
        FrameRefusedError
            If the solver refuses the frame.
        """

    def close(self) -> None:
        """End the session and what was started for it."""


Connect = Callable[[SolverSettings, Bones], FrameSolver]
