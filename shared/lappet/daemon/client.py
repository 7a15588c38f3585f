"""The client of a daemon's session (PROTOCOL.md): epochs and frames go out, solved frames come back."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from lappet.cutting.epoch import Epoch
from lappet.daemon.connection import DaemonConnection, SolveCancelled, SolverRefused, expect
from lappet.daemon.frame_solver import Iteration, SolvedFrame
from lappet.daemon.process import DaemonDied, DaemonMissing, SolverDaemon
from lappet.daemon.wire import Message, require
from lappet.program.payloads import epoch_payload, open_payload, solve_payload
from lappet.program.program import Bones, FrameConstraints, Landmarks
from lappet.program.settings import SolverSettings

__all__ = [
    "DaemonDied",
    "DaemonMissing",
    "FrameSolution",
    "SolveCancelled",
    "SolverClient",
    "SolverRefused",
    "SolverState",
]


@dataclass(frozen=True, eq=False)
class SolverState:
    """What a later frame depends on; give it back with `SolverClient.set_state`. Opaque but for `precision`."""

    precision: str
    nodes: NDArray[Any]
    suture_gaps: NDArray[np.float64]
    suture_multipliers: NDArray[np.float64]
    grip_multipliers: NDArray[np.float64]
    activation: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class FrameSolution(SolvedFrame):
    """A frame that came back: the fields (`header`) and `arrays` of the message `frame`, also as attributes.

    points (n, 3) mm; strain, stress, tension (n,), empty where the settings leave `strain` out: largest principal
    stretch - 1, von Mises and largest principal Cauchy stress in kPa; landmarks (k, 3) mm; suture_gaps (A,) mm;
    suture_forces (A,) mN; suture_points (A, 2, 3) mm; hook_forces (H, 3) mN; hook_points (H, 3) mm.
    """

    @property
    def time(self) -> float:
        """The time code."""
        return float(self.header["time"])

    @property
    def reason(self) -> str:
        """Why it did not converge, a sentence; empty when it did."""
        return str(self.header["reason"])

    @property
    def state(self) -> SolverState:
        """What the next frame starts from."""
        return SolverState(
            str(self.header["precision"]),
            self.arrays["nodes"],
            self.arrays["state_suture_gaps"],
            self.arrays["suture_multipliers"],
            self.arrays["grip_multipliers"],
            self.arrays["activation"],
        )

    @property
    def points(self) -> NDArray[np.float32]:
        """(n, 3) surface points, mm."""
        return self.arrays["points"]

    def __getattr__(self, name: str) -> Any:
        if name not in ("header", "arrays"):
            for values in (self.header, self.arrays):
                if name in values:
                    return values[name]
        raise AttributeError(f"a solved frame has no '{name}'")


class SolverClient:
    """One session with a daemon: a context manager.

    address: that of a running daemon, whose token is `token` or the environment's LAPPET_TOKEN; without an address a
    daemon is started here and ended with the client. name: how the daemon calls this client in its log. silence:
    seconds without an answer after which the daemon counts as dead. One thread at a time may make requests; `cancel`
    may be called from any.

    Every request raises DaemonDied when the daemon is gone, SolverRefused with its sentence when it refuses, and
    WireError when it answers something else than PROTOCOL.md says.
    """

    def __init__(
        self,
        address: str | None = None,
        token: str | None = None,
        *,
        daemon: SolverDaemon | None = None,
        name: str = "lappet",
        silence: float = 20.0,
    ) -> None:
        self._connection = DaemonConnection(address, token, daemon=daemon, name=name, silence=silence)
        self._epoch: int | None = None
        self._strain = True

    def connect(self) -> Self:
        """Starts the daemon where there is none, connects and says hello."""
        self._connection.connect()
        return self

    def close(self) -> None:
        """Takes leave, and ends the daemon that was started here. May be called twice."""
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
        """Opens a session, closing the one before; returns its number. bones: what the tissue may not enter."""
        if self._connection.session is not None:
            expect(self._connection.request("close"), "accepted")
            self._connection.session = None
            self._epoch = None
        told = open_payload(settings, bones)
        opened = expect(self._connection.request("open", told.fields, told.arrays), "opened")
        self._connection.session = opened.session
        self._strain = settings.strain
        return int(opened.session or 0)

    def set_epoch(
        self,
        epoch: Epoch,
        grip: NDArray[np.int32] | None = None,
        landmarks: Landmarks | None = None,
        *,
        nodes: bool = False,
    ) -> dict[str, Any]:
        """Installs an epoch, carrying the state over by rest position; returns the counts of the message `lattice`.

        grip: (m,) index of the retractor that grips each triangle, or -1 (none is gripped when left out). nodes: the
        result also holds `nodes`, (N, 3) float64, the lattice's nodes at rest in mm, in the order of a state.
        """
        if grip is None:
            grip = np.full(len(epoch.surface.triangles), -1, np.int32)
        told = epoch_payload(epoch, grip, Landmarks() if landmarks is None else landmarks)
        fields = {**told.fields, "nodes": 1} if nodes else told.fields
        self._epoch = None
        reply = expect(self._connection.request("epoch", fields, told.arrays), "lattice")
        self._epoch = epoch.index
        return {**reply.fields, **reply.arrays}

    def set_state(self, state: SolverState) -> None:
        """Replaces the state of the epoch by that of an earlier frame: the solve then goes on bit for bit."""
        arrays: dict[str, NDArray[Any]] = {
            "nodes": np.asarray(state.nodes, np.float64 if state.precision == "double" else np.float32),
            "suture_gaps": np.asarray(state.suture_gaps, np.float64),
            "suture_multipliers": np.asarray(state.suture_multipliers, np.float64),
            "grip_multipliers": np.asarray(state.grip_multipliers, np.float64),
            "activation": np.asarray(state.activation, np.float64),
        }
        expect(self._connection.request("state", {"precision": state.precision}, arrays), "accepted")

    def solve(self, frame: FrameConstraints, on_progress: Callable[[Iteration], None] | None = None) -> FrameSolution:
        """Finds the equilibrium of a frame of the epoch that was set; unconverged frames come back too.

        on_progress is called on this thread. An exception of its own, and Ctrl-C, cancel the solve and are passed on;
        the session can go on after that. Raises SolveCancelled after `cancel`, ValueError for a frame of another epoch.
        """
        if self._epoch is not None and frame.epoch != self._epoch:
            raise ValueError(
                f"Frame {frame.time:g} belongs to epoch {frame.epoch}, the session holds {self._epoch}; call set_epoch."
            )
        told = solve_payload(frame)

        def progressed(message: Message) -> None:
            if on_progress is not None:
                fields = message.fields
                on_progress(Iteration(fields["time"], fields["newton"], fields["residual"], fields["gap"]))

        reply = expect(self._connection.request("solve", told.fields, told.arrays, progressed), "frame")
        nodes = "f8" if reply.fields.get("precision") == "double" else "f4"
        hooks, sutures = len(frame.hook_stiffness), len(frame.suture_index)
        n = len(reply.arrays.get("points", ()))
        measured = n if self._strain else 0
        require(
            reply,
            points=("f4", (n, 3)),
            strain=("f4", (measured,)),
            stress=("f4", (measured,)),
            tension=("f4", (measured,)),
            landmarks=("f8", (None, 3)),
            suture_gaps=("f8", (sutures,)),
            suture_forces=("f8", (sutures,)),
            suture_points=("f8", (sutures, 2, 3)),
            hook_forces=("f8", (hooks, 3)),
            hook_points=("f8", (hooks, 3)),
            nodes=(nodes, (None, 3)),
            state_suture_gaps=("f8", (None, 3)),
            suture_multipliers=("f8", (None, 3)),
            grip_multipliers=("f8", (None,)),
            activation=("f8", (None,)),
        )
        return FrameSolution(reply.fields, reply.arrays)

    def cancel(self) -> None:
        """Cancels the solve that runs; from any thread."""
        self._connection.cancel()

    def ping(self) -> float:
        """Seconds until the daemon answers."""
        begun = time.monotonic()
        expect(self._connection.request("ping"), "pong")
        return time.monotonic() - begun
