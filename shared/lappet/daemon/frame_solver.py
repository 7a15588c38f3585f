"""What the solve asks of whoever finds the equilibrium of a frame; `lappet.daemon.daemon_solver` asks the daemon."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import RefusedError
from lappet.cutting.epoch import Epoch
from lappet.program.program import Bones, FrameConstraints, Landmarks
from lappet.program.settings import SolverSettings

STATE_ARRAYS = ("nodes", "state_suture_gaps", "suture_multipliers", "grip_multipliers", "activation")


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


@dataclass(frozen=True, eq=False)
class SolvedFrame:
    """What came back for a frame: the fields and the arrays of the message `frame` (PROTOCOL.md)."""

    header: dict[str, Any]
    arrays: dict[str, NDArray[Any]]

    @property
    def converged(self) -> bool:
        """Whether the equilibrium was found to the tolerance and the gaps asked for."""
        return bool(self.header["converged"])


class FrameSolver(Protocol):
    """A session that is told epochs and frames in order. Every method may raise `SolverDiedError`."""

    def set_epoch(self, epoch: Epoch, grip: NDArray[np.int32], landmarks: Landmarks) -> Mapping[str, Any]:
        """Installs an epoch, carrying the state over; returns the lattice's counts. Raises FrameRefusedError."""

    def set_state(self, precision: str, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Replaces the state by that of an earlier frame of this epoch (`STATE_ARRAYS`)."""

    def solve(self, frame: FrameConstraints, progress: Callable[[Iteration], None]) -> SolvedFrame:
        """Finds the equilibrium; KeyboardInterrupt cancels it. Raises FrameRefusedError."""

    def close(self) -> None:
        """Ends the session and what was started for it."""


Connect = Callable[[SolverSettings, Bones], FrameSolver]
