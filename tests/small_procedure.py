"""A small procedure: a 24 x 16 x 2 mm patch, slit, hooked, sutured; and a solver made of formulas that stands in."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.cutting.epoch import Epoch
from lappet.daemon.frame_diagnostics import Diagnostics, StageSeconds
from lappet.daemon.frame_solver import Iteration, SolverDiedError
from lappet.daemon.lattice_counts import LatticeCounts
from lappet.daemon.solved_frame import SolvedFrame
from lappet.daemon.solver_state import SolverState
from lappet.geometry.surface_check import signed_volume
from lappet.procedure import Excision, Hook, Incision, Landmark, Material, Procedure, Suture
from lappet.program.program import Bones, FrameConstraints, Landmarks
from lappet.program.settings import SolverSettings
from lappet.tissue.patch import flat_patch

TOP = 2.0
LENS = Incision("around", 3.0, ((-5.0, 0.0, TOP), (0.0, -3.0, TOP), (5.0, 0.0, TOP), (0.0, 3.0, TOP)), closed=True)
EXCISED = (LENS, Excision("lens", 3.0, ((0.0, 0.0, TOP),)))


def small_procedure(**changes: Any) -> Procedure:
    """Frames 1 to 8: whole to 2, slit at 3, hook 4 to 7, suture `stitch` from 5 over 2."""
    values: dict[str, Any] = {
        "tissue": flat_patch((24.0, 16.0, TOP), resolution=2.0, spacing=1.0),
        "materials": (Material(),),
        "events": (
            Incision("slit", 3.0, ((-6.0, 0.0, TOP), (6.0, 0.0, TOP)), kerf=0.1),
            Hook("hook", (0.0, 2.0, TOP), ((4.0, (0.0, 2.0, TOP)), (6.0, (0.0, 4.0, TOP + 2.0))), 4.0, 7.0),
            Suture("stitch", ((2.0, -1.0, TOP), (2.0, 1.0, TOP)), 5.0, 2.0),
            Landmark("mark", ((-8.0, 4.0, TOP),), "corner"),
        ),
        "start_time": 1.0,
        "end_time": 8.0,
    }
    return Procedure(**{**values, **changes})


@dataclass
class FakeSolver:
    """Answers like the daemon, without mechanics: a frame's points depend on everything that it was told before.

    log: what it was asked, as ("epoch", index), ("state", first node value) and ("solve", time). before: called with a
    frame's time before it is solved; may raise. unconverged: times of frames that do not converge.
    """

    log: list[tuple[str, float]] = field(default_factory=list)
    before: Callable[[float], None] = lambda time: None
    unconverged: frozenset[float] = frozenset()
    opened: int = 0
    closed: int = 0

    def connect(self, settings: SolverSettings, bones: Bones) -> FakeSession:
        """A new session, like `lappet.daemon.daemon_solver.connect_to` gives."""
        self.opened += 1
        return FakeSession(self, settings)

    def times(self) -> list[float]:
        """The times of the frames that were solved, in order."""
        return [value for what, value in self.log if what == "solve"]


class FakeSession:
    """A session of a `FakeSolver`. The state is one number that every frame and epoch changes."""

    def __init__(self, solver: FakeSolver, settings: SolverSettings) -> None:
        self._solver = solver
        self._settings = settings
        self._value = 0.0
        self._epoch: Epoch | None = None
        self._landmarks = Landmarks()
        self._lattice: LatticeCounts | None = None
        self._dead = False

    def set_epoch(self, epoch: Epoch, grip: NDArray[np.int32], landmarks: Landmarks) -> LatticeCounts:
        self._alive()
        self._solver.log.append(("epoch", epoch.index))
        assert len(grip) == len(epoch.surface.triangles)
        if self._epoch is not None:
            self._value += 100.0
        self._epoch, self._landmarks = epoch, landmarks
        count = 10 * (epoch.index + 1)
        volume = signed_volume(epoch.surface.points, epoch.surface.triangles)
        self._lattice = LatticeCounts(
            fine_voxels=round(volume * (self._settings.fine_ratio / self._settings.spacing) ** 3),
            cells=count,
            grid_cells=count - 1,
            mesh_cells=1,
            nodes=2 * count,
            blocks=2,
            fragments=epoch.fragments,
            fixed_nodes=0,
            dropped_voxels=0,
            volume=volume,
            bytes=1000.0,
            seconds=0.01,
        )
        return self._lattice

    def set_epoch_with_nodes(
        self, epoch: Epoch, grip: NDArray[np.int32], landmarks: Landmarks
    ) -> tuple[LatticeCounts, NDArray[np.float64]]:
        lattice = self.set_epoch(epoch, grip, landmarks)
        return lattice, np.zeros((lattice.nodes, 3))

    def set_state(self, state: SolverState) -> None:
        self._alive()
        assert state.precision == "float"
        assert state.suture_separations.shape == (self._settings.sutures, 3)
        assert state.suture_multipliers.shape == (self._settings.sutures, 3)
        self._value = float(state.nodes[0, 0])
        self._solver.log.append(("state", self._value))

    def solve(self, frame: FrameConstraints, progress: Callable[[Iteration], None]) -> SolvedFrame:
        self._alive()
        assert self._epoch is not None
        assert frame.epoch == self._epoch.index
        try:
            self._solver.before(frame.time)
        except SolverDiedError:
            self._dead = True
            raise
        self._solver.log.append(("solve", frame.time))
        progress(Iteration(frame.time, 1, 1e-4, 0.0))
        converged = frame.time not in self._solver.unconverged
        if converged:
            self._value += frame.time
        surface = self._epoch.surface
        n, hooks, placed = len(surface.points), len(frame.hook_stiffness), len(frame.suture_index)
        said = Diagnostics(
            converged=converged,
            reason="" if converged else "the line search found no decrease.",
            newton=3,
            pcg=40,
            load_steps=1,
            active_cells=8,
            residual=1e-4,
            force_scale=10.0,
            minimum_j=0.9,
            energy=1.0,
            peak_bytes=1000.0 + frame.time,
            seconds=StageSeconds(update=0.1, linear=0.2, setup=0.0, total=0.3),
        )
        gaps = np.full((self._settings.sutures, 3), np.nan)
        gaps[frame.suture_index] = frame.time
        lift = np.array([0.0, 0.0, self._value * 1e-3])
        return SolvedFrame(
            frame.time,
            (surface.points + lift).astype(np.float32),
            strain=np.full(n, 0.1, np.float32),
            stress=np.full(n, 0.2, np.float32),
            tension=np.full(n, 0.3, np.float32),
            landmark_index=self._landmarks.index,
            **self._followed(lift),
            hook_index=frame.hook_index,
            hook_points=frame.hook_anchors.copy(),
            hook_forces=np.full((hooks, 3), 2.0),
            suture_index=frame.suture_index,
            suture_points=frame.suture_anchors.copy(),
            suture_gaps=np.zeros(placed),
            suture_forces=np.full(placed, 5.0),
            suture_force_vectors=np.tile([0.0, 5.0, 0.0], (placed, 1)),
            diagnostics=said,
            lattice=self._lattice,
            state=SolverState(
                "float",
                nodes=np.full((4, 3), self._value, np.float32),
                suture_separations=gaps,
                suture_multipliers=np.zeros((self._settings.sutures, 3)),
                grip_multipliers=np.zeros(0),
                activation=np.zeros(len(self._settings.materials)),
            ),
        )

    def _followed(self, lift: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
        """Where landmarks and vessels are."""
        return {
            "landmarks": self._landmarks.points + lift,
            "vessel_points": self._landmarks.vessel_points + lift,
        }

    def close(self) -> None:
        self._solver.closed += 1

    def _alive(self) -> None:
        assert not self._dead, "a dead daemon was asked"
