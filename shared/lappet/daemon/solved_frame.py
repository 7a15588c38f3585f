"""A solved frame: the one shape that it has from the wire to the store, the skin cache, the report and the window."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.cutting.epoch import no_entries

SCALARS = ("strain", "stress", "tension")


@dataclass(frozen=True)
class LatticeCounts:
    """What an epoch's lattice has. bytes: that the session holds. seconds: that it took to build."""

    fine_voxels: int
    cells: int
    grid_cells: int
    mesh_cells: int
    nodes: int
    fragments: int
    blocks: int
    fixed_nodes: int
    bytes: float
    seconds: float


@dataclass(frozen=True)
class StageSeconds:
    """Seconds of a frame: state updates, linear solves, the preconditioner's setup, everything."""

    update: float = 0.0
    linear: float = 0.0
    setup: float = 0.0
    total: float = 0.0


@dataclass(frozen=True)
class PassCounts:
    """Passes over the whole lattice, and the seconds of each kind: of the energy and its gradient, of the tangent
    there, of products with it.
    """

    evaluations: int = 0
    evaluation_seconds: float = 0.0
    linearizations: int = 0
    linearization_seconds: float = 0.0
    products: int = 0
    product_seconds: float = 0.0


@dataclass(frozen=True)
class Diagnostics:
    """How a frame was solved.

    converged: to the tolerance and the gaps asked for; reason: why not, a sentence, or "". newton, pcg: iterations.
    active_cells: that were solved for. residual: over `force_scale`, mN. largest_gap: of sutures and grips, mm.
    minimum_j: least volume ratio. energy: mN mm. largest_penetration: of tissue into bone, mm. contacts: points that
    touch bone. peak_bytes: of the daemon.
    """

    converged: bool
    reason: str = ""
    newton: int = 0
    pcg: int = 0
    load_steps: int = 0
    active_cells: int = 0
    residual: float = 0.0
    force_scale: float = 0.0
    largest_gap: float = 0.0
    minimum_j: float = 1.0
    inverted_cells: int = 0
    energy: float = 0.0
    largest_penetration: float = 0.0
    contacts: int = 0
    peak_bytes: float = 0.0
    seconds: StageSeconds = field(default_factory=StageSeconds)
    work: PassCounts = field(default_factory=PassCounts)


@dataclass(frozen=True, eq=False)
class SolverState:
    """What a later frame depends on; opaque but for `precision`, "float" or "double".

    nodes: (N, 3) float32 or float64. suture_gaps: (S, 3) mm, the separation of each suture of the procedure when it was
    placed, NaN before. suture_multipliers: (S, 3) mN. grip_multipliers: (G,). activation: (M,) of each material.
    """

    precision: str
    nodes: NDArray[Any]
    suture_gaps: NDArray[np.float64]
    suture_multipliers: NDArray[np.float64]
    grip_multipliers: NDArray[np.float64]
    activation: NDArray[np.float64]

    @property
    def nbytes(self) -> int:
        """The bytes of its arrays."""
        arrays = (self.nodes, self.suture_gaps, self.suture_multipliers, self.grip_multipliers, self.activation)
        return sum(array.nbytes for array in arrays)

    def fitted(self, sutures: int) -> SolverState:
        """Return the state for a procedure with so many sutures.

        Sutures are numbered in order of their start, so those that an edit added or removed after the frame are rows at
        the end that the frame had not placed yet: a gap of NaN, a multiplier of 0.
        """
        return replace(
            self,
            suture_gaps=_resized(self.suture_gaps, sutures, np.nan),
            suture_multipliers=_resized(self.suture_multipliers, sutures, 0.0),
        )


def _resized(rows: NDArray[np.float64], count: int, fill: float) -> NDArray[np.float64]:
    fitted = np.full((count, 3), fill)
    kept = min(count, len(rows))
    fitted[:kept] = rows[:kept]
    return fitted


@dataclass(frozen=True, eq=False)
class SolvedFrame:
    """A frame as it was solved, or as far as it is known where it comes from a skin cache.

    time: time code. points: (n, 3) float32, mm, the epoch's surface. strain, stress, tension: (n,) float32, largest
    principal stretch less 1, von Mises and largest principal Cauchy stress in kPa; (0,) where they are not known.

    landmark_index: (k,) into `Program.landmarks`; landmarks: (k, 3) mm. hook_index: (H,) into `Program.hooks`;
    hook_points: (H, 3) mm, where the anchors are; hook_forces: (H, 3) mN on the tissue. suture_index: (A,) into
    `Program.sutures`; suture_points: (A, 2, 3) mm; suture_gaps: (A,) mm, from the separation asked for; suture_forces:
    (A,) mN. All float64, the indices int32.

    correction: (n, 3) float32 and landmark_correction: (k, 3) float64, mm, the Newton step left over; (0, 3) where it
    was not asked for.

    diagnostics: how it was solved. lattice: of its epoch, None where it is not known. state: what the next frame starts
    from, None in what is shown.
    """

    time: float
    points: NDArray[np.float32]
    strain: NDArray[np.float32] = field(default_factory=lambda: no_entries((0,), np.float32))
    stress: NDArray[np.float32] = field(default_factory=lambda: no_entries((0,), np.float32))
    tension: NDArray[np.float32] = field(default_factory=lambda: no_entries((0,), np.float32))
    landmark_index: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))
    landmarks: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    hook_index: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))
    hook_points: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    hook_forces: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    suture_index: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))
    suture_points: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 2, 3), np.float64))
    suture_gaps: NDArray[np.float64] = field(default_factory=lambda: no_entries((0,), np.float64))
    suture_forces: NDArray[np.float64] = field(default_factory=lambda: no_entries((0,), np.float64))
    correction: NDArray[np.float32] = field(default_factory=lambda: no_entries((0, 3), np.float32))
    landmark_correction: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    diagnostics: Diagnostics = Diagnostics(converged=True)
    lattice: LatticeCounts | None = None
    state: SolverState | None = None

    @property
    def converged(self) -> bool:
        """Whether the equilibrium was found to the tolerance and the gaps asked for."""
        return self.diagnostics.converged

    @property
    def reason(self) -> str:
        """Why it did not converge, a sentence; empty when it did."""
        return self.diagnostics.reason

    @property
    def nbytes(self) -> int:
        """The bytes of its arrays, without those of the state."""
        return sum(array.nbytes for array in self.arrays().values())

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return its arrays by name, without those of the state."""
        values = {item.name: getattr(self, item.name) for item in fields(self)}
        return {name: value for name, value in values.items() if isinstance(value, np.ndarray)}

    def shown(self) -> SolvedFrame:
        """Return the view of it for display: without the state, whose memory it does not hold either."""
        copies: dict[str, Any] = {name: array.copy() for name, array in self.arrays().items()}
        return replace(self, **copies, state=None)

    def without_scalars(self) -> SolvedFrame:
        """Return it without strain, stress and tension."""
        empty = no_entries((0,), np.float32)
        return replace(self, strain=empty, stress=empty, tension=empty)

    def scalar(self, name: str) -> NDArray[np.float32] | None:
        """Return a quantity of `SCALARS` at the points, (n,), or None where it is not known."""
        values: NDArray[np.float32] = getattr(self, name)
        return values if len(values) == len(self.points) else None
