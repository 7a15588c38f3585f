"""What the solve asks of whoever finds the equilibrium of a frame; `lappet.daemon.daemon_solver` asks the daemon."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import RefusedError
from lappet.cutting.epoch import Epoch
from lappet.daemon.solved_frame import LatticeCounts, SolvedFrame, SolverState
from lappet.program.program import Bones, FrameConstraints, Landmarks
from lappet.program.settings import SolverSettings


class SolverDiedError(RuntimeError):
    """The daemon ended or fell silent in the middle of its work; the work may be tried again with a new one."""


class FrameRefusedError(RefusedError):
    """The daemon refused an epoch or a frame (a budget, a value); asking again would not help."""


@dataclass(frozen=True)
class Iteration:
    """Where the solve of a frame stands: time code, Newton iteration, residual over force scale, largest gap in mm."""

    time: float
    newton: int
    residual: float
    gap: float


class FrameSolver(Protocol):
    """A session that is told epochs and frames in order. Every method may raise `SolverDiedError`."""

    def set_epoch(self, epoch: Epoch, grip: NDArray[np.int32], landmarks: Landmarks) -> LatticeCounts:
        """Installs an epoch, carrying the state over; returns the lattice's counts. Raises FrameRefusedError."""

    def set_state(self, state: SolverState) -> None:
        """Replaces the state by that of an earlier frame of this epoch."""

    def solve(self, frame: FrameConstraints, progress: Callable[[Iteration], None]) -> SolvedFrame:
        """Finds the equilibrium; KeyboardInterrupt cancels it. Raises FrameRefusedError."""

    def close(self) -> None:
        """Ends the session and what was started for it."""


Connect = Callable[[SolverSettings, Bones], FrameSolver]
