"""Has the daemon solve frames: the `FrameSolver` that `lappet solve` uses."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from lappet.core.version import version
from lappet.cutting.epoch import Epoch
from lappet.daemon.client import SolverClient
from lappet.daemon.frame_solver import Connect, FrameRefusedError, Iteration
from lappet.daemon.process import daemon_identity
from lappet.daemon.solved_frame import LatticeCounts, SolvedFrame, SolverState
from lappet.daemon.wire import WireError
from lappet.program.program import Bones, FrameConstraints, Landmarks
from lappet.program.settings import SolverSettings


class DaemonSolver:
    """A session with a daemon, of its own or at an address. Raises as `lappet.daemon.frame_solver.FrameSolver` says."""

    def __init__(
        self, settings: SolverSettings, bones: Bones, address: str | None = None, token: str | None = None
    ) -> None:
        self._client = SolverClient(address, token)
        self._client.connect()
        try:
            self._client.open(settings, bones)
        except BaseException:
            self._client.close()
            raise

    def set_epoch(self, epoch: Epoch, grip: NDArray[np.int32], landmarks: Landmarks) -> LatticeCounts:
        """Installs an epoch, carrying the state over; returns the lattice's counts."""
        try:
            return self._client.set_epoch(epoch, grip, landmarks)
        except WireError as error:
            raise FrameRefusedError(str(error)) from error

    def set_state(self, state: SolverState) -> None:
        """Replaces the state by that of an earlier frame of this epoch."""
        try:
            self._client.set_state(state)
        except WireError as error:
            raise FrameRefusedError(str(error)) from error

    def solve(self, frame: FrameConstraints, progress: Callable[[Iteration], None]) -> SolvedFrame:
        """Finds the equilibrium of a frame."""
        try:
            return self._client.solve(frame, progress)
        except WireError as error:
            raise FrameRefusedError(str(error)) from error

    def close(self) -> None:
        """Ends the session, and the daemon where it was started here."""
        self._client.close()


def connect_to(address: str | None) -> Connect:
    """Opens sessions with the daemon at an address, or with a daemon that each session starts for itself."""
    return lambda settings, bones: DaemonSolver(settings, bones, address)


def solver_identity(address: str | None) -> str:
    """What tells this solver from another in the keys of frames: the version and the digest of the daemon's program.

    A daemon at an address is told by the version that it greets with. Raises RefusedError where there is no daemon.
    """
    if address is None:
        return daemon_identity()

    with SolverClient(address) as client:
        return f"{version()} {client.welcome['version']}"
