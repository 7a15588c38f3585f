"""The client of a daemon's session (PROTOCOL.md): epochs and frames go out, solved frames come back."""

from __future__ import annotations

import time
from collections.abc import Callable
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from lappet.cutting.epoch import Epoch
from lappet.daemon.connection import DaemonConnection, SolveCancelled, SolverRefused, expect
from lappet.daemon.frame_message import read_frame
from lappet.daemon.frame_solver import Iteration
from lappet.daemon.handshake import DaemonRefuses
from lappet.daemon.lattice_counts import LatticeCounts
from lappet.daemon.process import DaemonDied, DaemonMissing, SolverDaemon
from lappet.daemon.running_daemon import ClientKeys
from lappet.daemon.solved_frame import SolvedFrame
from lappet.daemon.solver_state import SolverState
from lappet.daemon.wire import Message, read_array, read_fields
from lappet.program.payloads import epoch_payload, open_payload, solve_payload
from lappet.program.program import Bones, FrameConstraints, Landmarks
from lappet.program.settings import SolverSettings

__all__ = [
    "DaemonDied",
    "DaemonMissing",
    "DaemonRefuses",
    "SolveCancelled",
    "SolverClient",
    "SolverRefused",
]


class SolverClient:
    """One session with a daemon: a context manager.

    One thread at a time may make requests; `cancel` may be called from any. Every request raises DaemonDied when the
    daemon is gone, DaemonRefuses when it lets the user in no longer, SolverRefused with its sentence when it refuses,
    and WireError when it answers something else than PROTOCOL.md says.

    Parameters
    ----------
    address
        Address of a running daemon; without one a daemon is started here and ended with the client.
    token
        Token of a running daemon without keys; None for the environment's `LAPPET_TOKEN`.
    keys
        The running daemon's key and the user's own, where it has keys; then no token is sent.
    daemon
        A daemon of the caller's; it is started where it does not run, and not ended here.
    name
        What the daemon calls this client in its log.
    silence
        Seconds without an answer after which the daemon counts as dead.
    """

    def __init__(
        self,
        address: str | None = None,
        token: str | None = None,
        *,
        keys: ClientKeys | None = None,
        daemon: SolverDaemon | None = None,
        name: str = "lappet",
        silence: float = 20.0,
    ) -> None:
        self._connection = DaemonConnection(address, token, keys=keys, daemon=daemon, name=name, silence=silence)
        self._settings = SolverSettings()
        self._epoch: int | None = None
        self._lattice: LatticeCounts | None = None
        self._landmarks = Landmarks()

    def connect(self) -> Self:
        """Start the daemon where there is none, connect and say hello.

        Returns
        -------
        Self
            This client.
        """
        self._connection.connect()
        return self

    def close(self) -> None:
        """Take leave, and end the daemon that was started here; may be called twice."""
        self._connection.close()

    def __enter__(self) -> Self:
        return self.connect()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @property
    def welcome(self) -> dict[str, Any]:
        """The daemon's greeting: `version`, `threads`, `isa`, `compiler`, `max_message_bytes`."""
        return self._connection.welcome

    def open(self, settings: SolverSettings, bones: Bones | None = None) -> int:
        """Open a session, closing the one before.

        Parameters
        ----------
        settings
            How the session solves.
        bones
            What the tissue may not enter.

        Returns
        -------
        int
            Number of the session.
        """
        if self._connection.session is not None:
            expect(self._connection.request("close"), "accepted")
            self._connection.session = None
            self._epoch = None
        told = open_payload(settings, bones)
        opened = expect(self._connection.request("open", told.fields, told.arrays), "opened")
        self._connection.session = opened.session
        self._settings = settings
        return int(opened.session or 0)

    def set_epoch(
        self, epoch: Epoch, grip: NDArray[np.int32] | None = None, landmarks: Landmarks | None = None
    ) -> LatticeCounts:
        """Install an epoch, carrying the state over by rest position.

        Parameters
        ----------
        epoch
            The epoch.
        grip
            Index of the retractor that grips each triangle, or -1, shape (m,); none is gripped when left out.
        landmarks
            The landmarks that the epoch's tissue holds.

        Returns
        -------
        LatticeCounts
            Counts of the message `lattice`.
        """
        self._set_epoch(epoch, grip, landmarks)
        assert self._lattice is not None
        return self._lattice

    def set_epoch_with_nodes(
        self, epoch: Epoch, grip: NDArray[np.int32] | None = None, landmarks: Landmarks | None = None
    ) -> tuple[LatticeCounts, NDArray[np.float64]]:
        """Install an epoch like `set_epoch`, and tell where its lattice's nodes are.

        Parameters
        ----------
        epoch
            The epoch.
        grip
            Index of the retractor that grips each triangle, or -1, shape (m,); none is gripped when left out.
        landmarks
            The landmarks that the epoch's tissue holds.

        Returns
        -------
        tuple[LatticeCounts, NDArray[np.float64]]
            Counts of the message `lattice`, and the nodes at rest in mm, shape (N, 3), in the order of a state.
        """
        reply = self._set_epoch(epoch, grip, landmarks, rest_nodes=1)
        assert self._lattice is not None
        return self._lattice, read_array(reply, "rest_nodes", "f8", (None, 3))

    def _set_epoch(
        self, epoch: Epoch, grip: NDArray[np.int32] | None, landmarks: Landmarks | None, **fields: int
    ) -> Message:
        marks = Landmarks() if landmarks is None else landmarks
        if grip is None:
            grip = np.full(len(epoch.surface.triangles), -1, np.int32)
        told = epoch_payload(epoch, grip, marks)
        reply = expect(self._connection.request("epoch", {**told.fields, **fields}, told.arrays), "lattice")
        self._epoch, self._landmarks, self._sections = epoch.index, marks, len(epoch.boundary.section_points)
        self._lattice = read_fields(LatticeCounts, reply.fields, "lattice")
        return reply

    def set_state(self, state: SolverState) -> None:
        """Replace the state of the epoch by that of an earlier frame: the solve then goes on bit for bit.

        Parameters
        ----------
        state
            The state.
        """
        arrays: dict[str, NDArray[Any]] = {
            "nodes": np.asarray(state.nodes, np.float64 if state.precision == "double" else np.float32),
            "suture_separations": np.asarray(state.suture_separations, np.float64),
            "suture_multipliers": np.asarray(state.suture_multipliers, np.float64),
            "grip_multipliers": np.asarray(state.grip_multipliers, np.float64),
            "stability": np.asarray(state.stability, np.float64),
            "activation": np.asarray(state.activation, np.float64),
        }
        for name in ("roller_multipliers", "loads", "bone_motion"):
            if len(getattr(state, name)):
                arrays[name] = np.asarray(getattr(state, name), np.float64)
        if len(state.motion):
            arrays["motion"] = np.asarray(state.motion, np.float32)
        expect(self._connection.request("state", {"precision": state.precision}, arrays), "accepted")

    def solve(self, frame: FrameConstraints, on_progress: Callable[[Iteration], None] | None = None) -> SolvedFrame:
        """Find the equilibrium of a frame of the epoch that was set; unconverged frames come back too.

        An exception of `on_progress`, and Ctrl-C, cancel the solve and are passed on; the session can go on after that.

        Parameters
        ----------
        frame
            The frame's constraints.
        on_progress
            Called on this thread with where the solve stands.

        Returns
        -------
        SolvedFrame
            The frame.

        Raises
        ------
        SolveCancelled
            If `cancel` was called.
        ValueError
            If the frame belongs to another epoch.
        """
        if self._epoch is not None and frame.epoch != self._epoch:
            raise ValueError(
                f"Frame {frame.time:g} belongs to epoch {frame.epoch}, the session holds {self._epoch}; call set_epoch."
            )
        told = solve_payload(frame)

        def progressed(message: Message) -> None:
            if on_progress is not None:
                on_progress(read_fields(Iteration, message.fields, "progress"))

        reply = expect(self._connection.request("solve", told.fields, told.arrays, progressed), "frame")
        return read_frame(reply, frame, self._settings, self._landmarks, self._lattice, self._sections)

    def share(self) -> None:
        """Let every user of the daemon follow the session (`lappet.daemon.follower`); the daemon must have keys."""
        expect(self._connection.request("share"), "accepted")

    def cancel(self) -> None:
        """Cancel the solve that runs; from any thread."""
        self._connection.cancel()

    def ping(self) -> float:
        """Measure how long the daemon takes to answer.

        Returns
        -------
        float
            Seconds.
        """
        begun = time.monotonic()
        expect(self._connection.request("ping"), "pong")
        return time.monotonic() - begun
