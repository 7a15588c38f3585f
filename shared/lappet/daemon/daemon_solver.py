"""Have the daemon solve frames: the `FrameSolver` that `lappet solve` uses."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from lappet.core.version import version
from lappet.cutting.epoch import Epoch
from lappet.daemon.client import SolverClient
from lappet.daemon.frame_solver import Connect, FrameRefusedError, Iteration
from lappet.daemon.lattice_counts import LatticeCounts
from lappet.daemon.process import daemon_identity
from lappet.daemon.running_daemon import ClientKeys, RunningDaemon
from lappet.daemon.solved_frame import SolvedFrame
from lappet.daemon.solver_state import SolverState
from lappet.daemon.wire import WireError
from lappet.program.program import Bones, FrameConstraints, Landmarks
from lappet.program.settings import SolverSettings


class DaemonSolver:
    """A session with a daemon, of its own or at an address.

    Parameters
    ----------
    settings
        How the session solves.
    bones
        What the tissue may not enter.
    address
        Address of a running daemon; None starts one.
    token
        Token of a running daemon without keys.
    keys
        The running daemon's key and the user's own, where it has keys.
    shared
        Called with the number of the session once every user may follow it; nobody else may where it is left out.
    """

    def __init__(
        self,
        settings: SolverSettings,
        bones: Bones,
        address: str | None = None,
        token: str | None = None,
        keys: ClientKeys | None = None,
        shared: Callable[[int], None] | None = None,
    ) -> None:
        self._client = SolverClient(address, token, keys=keys)
        self._client.connect()
        try:
            session = self._client.open(settings, bones)
            if shared is not None:
                self._client.share()
                shared(session)
        except BaseException:
            self._client.close()
            raise

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
            If the daemon refuses the epoch.
        """
        try:
            return self._client.set_epoch(epoch, grip, landmarks)
        except WireError as error:
            raise FrameRefusedError(error.problems) from error

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
            If the daemon refuses the epoch.
        """
        try:
            return self._client.set_epoch_with_nodes(epoch, grip, landmarks)
        except WireError as error:
            raise FrameRefusedError(error.problems) from error

    def set_state(self, state: SolverState) -> None:
        """Replace the state by that of an earlier frame of this epoch.

        Parameters
        ----------
        state
            The state.

        Raises
        ------
        FrameRefusedError
            If the daemon refuses the state.
        """
        try:
            self._client.set_state(state)
        except WireError as error:
            raise FrameRefusedError(error.problems) from error

    def solve(self, frame: FrameConstraints, progress: Callable[[Iteration], None]) -> SolvedFrame:
        """Find the equilibrium of a frame.

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
            If the daemon refuses the frame.
        """
        try:
            return self._client.solve(frame, progress)
        except WireError as error:
            raise FrameRefusedError(error.problems) from error

    def close(self) -> None:
        """End the session, and the daemon where it was started here."""
        self._client.close()


def connect_to(daemon: RunningDaemon | None, shared: Callable[[int], None] | None = None) -> Connect:
    """Make what opens sessions with a daemon.

    Parameters
    ----------
    daemon
        A running daemon; with None each session starts one for itself.
    shared
        Called with the number of each session once every user of a running daemon may follow it.

    Returns
    -------
    Connect
        The function that opens a session.
    """
    if daemon is None:
        return DaemonSolver
    return lambda settings, bones: DaemonSolver(settings, bones, daemon.address, keys=daemon.keys(), shared=shared)


def solver_identity(daemon: RunningDaemon | None, silence: float = 20.0) -> str:
    """Find what tells this solver from another in the keys of frames.

    Parameters
    ----------
    daemon
        A running daemon, which is told by the version that it greets with; None for the installed one.
    silence
        Seconds without an answer after which the daemon counts as dead.

    Returns
    -------
    str
        Version and digest of the daemon's program.

    Raises
    ------
    RefusedError
        If there is no daemon, or it refuses this client.
    """
    if daemon is None:
        return daemon_identity()

    with SolverClient(daemon.address, keys=daemon.keys(), silence=silence) as client:
        return f"{version()} {client.welcome['version']}"
