"""The client of a daemon's session (PROTOCOL.md): epochs and frames go out, solved frames come back."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from lappet.cutting.epoch import Epoch, Regions
from lappet.daemon.connection import DaemonConnection, SolveCancelled, SolverRefused, expect
from lappet.daemon.frame_solver import Iteration, SolvedFrame
from lappet.daemon.process import DaemonDied, DaemonMissing, SolverDaemon
from lappet.daemon.wire import Message, require
from lappet.program.program import Bones, FrameConstraints, Landmarks, MaterialParameters, SolverSettings

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
    """What a later frame depends on; give it back with `SolverClient.set_state`.

    Opaque but for `precision`; PROTOCOL.md describes the arrays.

    Parameters
    ----------
    precision
        "float" or "double".
    nodes
        Positions of the lattice's nodes, shape (N, 3).
    suture_gaps
        Separation of each suture when it was placed in mm, NaN before, shape (S, 3).
    suture_multipliers
        Multipliers of the sutures, shape (S, 3).
    grip_multipliers
        Multipliers of the grips, shape (G,).
    activation
        Activation of each material's muscle, shape (M,).
    """

    precision: str
    nodes: NDArray[Any]
    suture_gaps: NDArray[np.float64]
    suture_multipliers: NDArray[np.float64]
    grip_multipliers: NDArray[np.float64]
    activation: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class FrameSolution(SolvedFrame):
    """A frame that came back: the fields (`header`) and `arrays` of the message `frame`, also as attributes.

    `points` (n, 3) mm; `strain`, `stress`, `tension` (n,), empty where the settings leave `strain` out: largest
    principal stretch - 1, von Mises and largest principal Cauchy stress in kPa; `landmarks` (k, 3) mm; `suture_gaps`
    (A,) mm; `suture_forces` (A,) mN; `suture_points` (A, 2, 3) mm; `hook_forces` (H, 3) mN; `hook_points` (H, 3) mm.

    Parameters
    ----------
    header
        Fields of the message.
    arrays
        Arrays of the message by name.
    """

    @property
    def time(self) -> float:
        """The time code."""
        return float(self.header["time"])

    @property
    def reason(self) -> str:
        """Why the frame did not converge, a sentence; empty when it did."""
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
        """Surface points in mm, shape (n, 3)."""
        return self.arrays["points"]

    def __getattr__(self, name: str) -> Any:
        if name not in ("header", "arrays"):
            for values in (self.header, self.arrays):
                if name in values:
                    return values[name]
        raise AttributeError(f"a solved frame has no '{name}'")


class SolverClient:
    """One session with a daemon: a context manager.

    One thread at a time may make requests; `cancel` may be called from any. Every request raises DaemonDied when the
    daemon is gone, SolverRefused with its sentence when it refuses, and WireError when it answers something else than
    PROTOCOL.md says.

    Parameters
    ----------
    address
        Address of a running daemon; without one a daemon is started here and ended with the client.
    token
        Token of the running daemon; None for the environment's `LAPPET_TOKEN`.
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
        daemon: SolverDaemon | None = None,
        name: str = "lappet",
        silence: float = 20.0,
    ) -> None:
        self._connection = DaemonConnection(address, token, daemon=daemon, name=name, silence=silence)
        self._epoch: int | None = None
        self._strain = True

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
        fields = {
            "settings": {
                "spacing": float(settings.spacing),
                "fine_ratio": int(settings.fine_ratio),
                "origin": [float(x) for x in settings.origin],
                "quadrature": int(settings.quadrature),
                "precision": settings.precision,
                "tolerance": float(settings.tolerance),
                "gap_tolerance": float(settings.gap_tolerance),
                "max_newton": int(settings.max_newton),
                "bed_stiffness": float(settings.bed_stiffness),
                "gravity": [float(x) for x in settings.gravity],
                "time_budget": float(settings.time_budget),
                "memory_budget": int(settings.memory_budget),
                "threads": int(settings.threads),
                "sutures": int(settings.sutures),
                "retractors": int(settings.retractors),
                "preconditioner": settings.preconditioner,
                "correction": int(settings.correction),
                "strain": int(settings.strain),
                "region": settings.region,
            },
            "materials": [_material(material) for material in settings.materials],
        }
        arrays: dict[str, NDArray[Any]] = {}
        if bones is not None and len(bones.triangles):
            arrays["bone_points"] = np.asarray(bones.points, np.float64)
            arrays["bone_triangles"] = np.asarray(bones.triangles, np.int32)
        opened = expect(self._connection.request("open", fields, arrays), "opened")
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
        """Install an epoch, carrying the state over by rest position.

        Parameters
        ----------
        epoch
            The epoch.
        grip
            Index of the retractor that grips each triangle, or -1, shape (m,); none is gripped when left out.
        landmarks
            The landmarks that the epoch's tissue holds.
        nodes
            Whether the result also holds `nodes`, the lattice's nodes at rest in mm, shape (N, 3), float64, in the
            order of a state.

        Returns
        -------
        dict[str, Any]
            Counts of the message `lattice`.
        """
        surface = epoch.surface
        marks = landmarks if landmarks is not None else Landmarks()
        if grip is None:
            grip = np.full(len(surface.triangles), -1, np.int32)
        arrays: dict[str, NDArray[Any]] = {
            "points": np.asarray(surface.points, np.float64),
            "triangles": np.asarray(surface.triangles, np.int32),
            "fixed": np.asarray(surface.fixed, np.uint8),
            "bed": epoch.support,
            "grip": np.asarray(grip, np.int32),
            "landmarks": np.asarray(marks.points, np.float64).reshape(-1, 3),
            "landmark_triangles": np.asarray(marks.triangles, np.int32),
        }
        fields: dict[str, Any] = {"index": int(epoch.index), **({"nodes": 1} if nodes else {})}
        if len(epoch.regions.skin_triangles):
            arrays["skin_points"] = np.asarray(epoch.regions.skin_points, np.float64)
            arrays["skin_triangles"] = np.asarray(epoch.regions.skin_triangles, np.int32)
        if len(epoch.regions):
            fields["regions"] = _regions(epoch.regions)
            arrays["region_faces"] = np.asarray(epoch.regions.faces, np.uint8)
        self._epoch = None
        reply = expect(self._connection.request("epoch", fields, arrays), "lattice")
        self._epoch = epoch.index
        return {**reply.fields, **reply.arrays}

    def set_state(self, state: SolverState) -> None:
        """Replace the state of the epoch by that of an earlier frame: the solve then goes on bit for bit.

        Parameters
        ----------
        state
            The state.
        """
        arrays: dict[str, NDArray[Any]] = {
            "nodes": np.asarray(state.nodes, np.float64 if state.precision == "double" else np.float32),
            "suture_gaps": np.asarray(state.suture_gaps, np.float64),
            "suture_multipliers": np.asarray(state.suture_multipliers, np.float64),
            "grip_multipliers": np.asarray(state.grip_multipliers, np.float64),
            "activation": np.asarray(state.activation, np.float64),
        }
        expect(self._connection.request("state", {"precision": state.precision}, arrays), "accepted")

    def solve(self, frame: FrameConstraints, on_progress: Callable[[Iteration], None] | None = None) -> FrameSolution:
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
        FrameSolution
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
        arrays: dict[str, NDArray[Any]] = {
            name: np.asarray(getattr(frame, name), dtype) for name, dtype in _SOLVE_ARRAYS.items()
        }
        if len(frame.activation):
            arrays["activation"] = np.asarray(frame.activation, np.float64)

        def progressed(message: Message) -> None:
            if on_progress is not None:
                fields = message.fields
                on_progress(Iteration(fields["time"], fields["newton"], fields["residual"], fields["gap"]))

        reply = expect(self._connection.request("solve", {"time": float(frame.time)}, arrays, progressed), "frame")
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


def _material(material: MaterialParameters) -> dict[str, Any]:
    """A material as a map; what it does without is left out."""
    fields: dict[str, Any] = {
        "model": material.model,
        "youngs_modulus": float(material.youngs_modulus),
        "poissons_ratio": float(material.poissons_ratio),
        "density": float(material.density),
    }
    if material.model == "mooneyRivlin":
        fields["mooney_ratio"] = float(material.mooney_ratio)
    if material.fibre_k1 > 0.0:
        for name in ("fibre_k1", "fibre_k2", "fibre_dispersion"):
            fields[name] = float(getattr(material, name))
    if material.muscle_stress > 0.0:
        fields["muscle_stress"] = float(material.muscle_stress)
    if material.prestretch != (1.0, 1.0):
        fields["prestretch"] = [float(x) for x in material.prestretch]
    if len(fields) > 4:
        fields["fibre_direction"] = [float(x) for x in material.fibre_direction]
    return fields


def _regions(regions: Regions) -> list[dict[str, Any]]:
    maps: list[dict[str, Any]] = []
    for material, top, bottom in zip(regions.material, regions.depth_from, regions.depth_to, strict=True):
        maps.append({"material": int(material), "from_depth": float(top)})
        if np.isfinite(bottom):
            maps[-1]["to_depth"] = float(bottom)
    return maps


_SOLVE_ARRAYS: dict[str, type[np.generic]] = {
    "hook_anchors": np.float64,
    "hook_triangles": np.int32,
    "hook_targets": np.float64,
    "hook_stiffness": np.float64,
    "suture_index": np.int32,
    "suture_anchors": np.float64,
    "suture_triangles": np.int32,
    "suture_closure": np.float64,
    "suture_stiffness": np.float64,
    "retractor_index": np.int32,
    "retractor_motion": np.float64,
}
