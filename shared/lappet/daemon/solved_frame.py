"""A solved frame: the one shape that it has from the wire to the store, the skin cache, the report and the window."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.cutting.epoch import no_entries

SCALARS = ("strain", "stress", "tension")
HOLDERS = ("fixed", "retractor", "bed", "bone", "weak bed", "roller", "load")  # as PROTOCOL.md numbers them


@dataclass(frozen=True)
class LatticeCounts:
    """What an epoch's lattice has.

    Parameters
    ----------
    fine_voxels
        Fine voxels inside the tissue.
    cells
        Cells.
    grid_cells
        Cells of which the grid has one copy.
    mesh_cells
        Cells of which it has several, one per fragment.
    nodes
        Nodes.
    fragments
        Fragments of the tissue.
    blocks
        Blocks of cells that are computed.
    fixed_nodes
        Nodes that do not move.
    dropped_voxels
        Voxels at sharp tips that nothing holds; they are not among the fine voxels.
    volume
        Volume of the tissue in the cells in mm³.
    bytes
        Memory of the session in bytes.
    seconds
        Time that it took to build.
    """

    fine_voxels: int
    cells: int
    grid_cells: int
    mesh_cells: int
    nodes: int
    fragments: int
    blocks: int
    fixed_nodes: int
    dropped_voxels: int
    volume: float
    bytes: float
    seconds: float


@dataclass(frozen=True)
class StageSeconds:
    """Seconds of a frame by stage.

    Parameters
    ----------
    update
        State updates.
    linear
        Linear solves.
    setup
        Setting up the preconditioner.
    stability
        The search for the softest displacement.
    total
        Everything.
    """

    update: float = 0.0
    linear: float = 0.0
    setup: float = 0.0
    stability: float = 0.0
    total: float = 0.0


@dataclass(frozen=True)
class PassCounts:
    """Passes over the whole lattice and their seconds.

    Parameters
    ----------
    evaluations
        Evaluations of the energy and its gradient.
    evaluation_seconds
        Their seconds.
    linearizations
        Evaluations of the tangent.
    linearization_seconds
        Their seconds.
    products
        Products with the tangent.
    product_seconds
        Their seconds.
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

    Parameters
    ----------
    converged
        Whether it met the tolerance and the gaps asked for.
    reason
        Why it did not, a sentence; else empty.
    reason_code
        The same as a code of PROTOCOL.md, "frame"; else empty.
    newton
        Newton iterations.
    pcg
        Iterations of the linear solver.
    load_steps
        Load steps.
    active_cells
        Cells that were solved for.
    restart
        Why it was solved from rest and not from the frame before, a code of PROTOCOL.md, "frame"; else empty.
    residual
        Residual over force scale.
    force_scale
        Force scale in mN.
    displacement_to_come
        Estimate of the largest displacement in mm that a converged frame still lacks of its equilibrium.
    largest_gap
        Largest gap of sutures and grips in mm.
    minimum_j
        Least volume ratio.
    inverted_cells
        Cells that are inside out.
    energy
        Energy in mN mm.
    largest_penetration
        Largest depth of tissue in bone in mm.
    contacts
        Points of the surface that touch bone.
    self_contacts
        Pairs of the surface's parts that press on each other, with self-contact.
    piercings
        How often edges of the surface go through faces of it, with self-contact.
    piercings_before
        The same in the state that the frame was solved from; pairs at those places were left out.
    lowest_stiffness
        The share of its stiffness that compression leaves the softest displacement: 1 without compression, 0 where the
        equilibrium is neutral, negative where it is unstable; NaN where it was not looked for.
    saddles_left
        Unstable equilibria that were found on the way and left.
    peak_bytes
        Peak memory of the daemon in bytes.
    seconds
        Seconds by stage.
    work
        Passes over the lattice.
    """

    converged: bool
    reason: str = ""
    reason_code: str = ""
    newton: int = 0
    pcg: int = 0
    load_steps: int = 0
    active_cells: int = 0
    restart: str = ""
    residual: float = 0.0
    force_scale: float = 0.0
    displacement_to_come: float = 0.0
    largest_gap: float = 0.0
    minimum_j: float = 1.0
    inverted_cells: int = 0
    energy: float = 0.0
    largest_penetration: float = 0.0
    contacts: int = 0
    self_contacts: int = 0
    piercings: int = 0
    piercings_before: int = 0
    lowest_stiffness: float = math.nan
    saddles_left: int = 0
    peak_bytes: float = 0.0
    seconds: StageSeconds = field(default_factory=StageSeconds)
    work: PassCounts = field(default_factory=PassCounts)


@dataclass(frozen=True, eq=False)
class SolverState:
    """What a later frame depends on; opaque but for `precision`.

    Parameters
    ----------
    precision
        "float" or "double".
    nodes
        Positions of the lattice's nodes, shape (N, 3), float32 or float64.
    suture_separations
        Separation of each suture of the procedure when it was placed in mm, NaN before, shape (S, 3).
    suture_multipliers
        Multipliers of the sutures in mN, shape (S, 3).
    grip_multipliers
        Multipliers of the grips, shape (G,).
    activation
        Activation of each material's muscle, shape (M,).
    stability
        How stable the frame is, which a frame that repeats it repeats, shape (0,), (2,) or (5,).
    roller_multipliers
        Multipliers of the rollers, shape (K,).
    loads
        The loads of the frame: number of their faces, traction and pressure in kPa, shape (D, 5).
    motion
        How the nodes moved in the last frame that moved them in mm, shape (N, 3), float32; (0, 3) where none has, or
        where that is not known.
    bone_motion
        Motions of the bodies of bones in the frame, shape (B, 4, 4); empty where none moves.
    """

    precision: str
    nodes: NDArray[Any]
    suture_separations: NDArray[np.float64]
    suture_multipliers: NDArray[np.float64]
    grip_multipliers: NDArray[np.float64]
    activation: NDArray[np.float64]
    stability: NDArray[np.float64] = field(default_factory=lambda: no_entries((0,), np.float64))
    roller_multipliers: NDArray[np.float64] = field(default_factory=lambda: no_entries((0,), np.float64))
    loads: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 5), np.float64))
    motion: NDArray[np.float32] = field(default_factory=lambda: no_entries((0, 3), np.float32))
    bone_motion: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 4, 4), np.float64))

    @property
    def nbytes(self) -> int:
        """The bytes of its arrays."""
        return sum(getattr(self, item.name).nbytes for item in fields(self) if item.name != "precision")

    def fitted(self, sutures: int) -> SolverState:
        """Fit the state to a procedure with another number of sutures.

        Sutures are numbered in order of their start, so those that an edit added or removed after the frame are rows at
        the end that the frame had not placed yet: a gap of NaN, a multiplier of 0.

        Parameters
        ----------
        sutures
            Number of sutures in the procedure.

        Returns
        -------
        SolverState
            The state.
        """
        return replace(
            self,
            suture_separations=_resized(self.suture_separations, sutures, np.nan),
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

    Parameters
    ----------
    time
        Time code.
    points
        Surface points of the epoch in mm, shape (n, 3), float32.
    strain
        Largest principal stretch less 1, shape (n,), float32; (0,) where it is not known.
    stress
        Von Mises stress in kPa, likewise.
    tension
        Largest principal Cauchy stress in kPa, likewise.
    landmark_index
        Number of each landmark in `Program.landmarks`, shape (k,), int32.
    landmarks
        Landmarks in mm, shape (k, 3), float64.
    vessel_points
        Points of the pieces of vessels in mm, in the order of `Program.vessels_at`, shape (v, 3), float64.
    hook_index
        Number of each hook in `Program.hooks`, shape (H,), int32.
    hook_points
        Where their anchors are in mm, shape (H, 3), float64.
    hook_forces
        Forces on the tissue in mN, shape (H, 3), float64.
    suture_index
        Number of each suture in `Program.sutures`, shape (A,), int32.
    suture_points
        Where their ends are in mm, shape (A, 2, 3), float64.
    suture_gaps
        Distance from the separation asked for in mm, shape (A,), float64.
    suture_forces
        Their pull in mN, shape (A,), float64.
    suture_force_vectors
        Force on the tissue at their first ends in mN, shape (A, 3), float64; at the second ends the opposite one.
    suture_shared
        How much of what two bites of theirs that follow each other hold is the same tissue, 0 to 1, in the order of the
        sutures and of each thread, shape (A + I,), float64; (0,) where not known.
    suture_inner_bites
        Number of bites of each between its ends, shape (A,), int32; empty where none has any.
    inner_bite_points
        Where these are in mm, in the order of the sutures and of each thread, shape (I, 3), float64.
    holders
        What holds or loads the tissue: its kind, a place in `HOLDERS`, and its number among those, shape (K, 2), int32.
    reactions
        Its force on the tissue in mN, shape (K, 3), float64.
    section_forces
        Force across each section of `Program.sections` in mN, of what lies beyond it on what lies before it, shape
        (S, 3), float64.
    correction
        Displacement still to come in mm, shape (n, 3), float32; (0, 3) where it was not asked for.
    landmark_correction
        The same at the landmarks, shape (k, 3), float64.
    softest_point
        Rest point of the surface that moves most in the displacement of `Diagnostics.lowest_stiffness` in mm, shape
        (1, 3), float64; (0, 3) where nothing is compressed.
    diagnostics
        How it was solved.
    lattice
        Counts of its epoch's lattice, or None where they are not known.
    state
        What the next frame starts from, or None in what is shown.
    """

    time: float
    points: NDArray[np.float32]
    strain: NDArray[np.float32] = field(default_factory=lambda: no_entries((0,), np.float32))
    stress: NDArray[np.float32] = field(default_factory=lambda: no_entries((0,), np.float32))
    tension: NDArray[np.float32] = field(default_factory=lambda: no_entries((0,), np.float32))
    landmark_index: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))
    landmarks: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    vessel_points: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    hook_index: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))
    hook_points: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    hook_forces: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    suture_index: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))
    suture_points: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 2, 3), np.float64))
    suture_gaps: NDArray[np.float64] = field(default_factory=lambda: no_entries((0,), np.float64))
    suture_forces: NDArray[np.float64] = field(default_factory=lambda: no_entries((0,), np.float64))
    suture_force_vectors: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    suture_shared: NDArray[np.float64] = field(default_factory=lambda: no_entries((0,), np.float64))
    suture_inner_bites: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))
    inner_bite_points: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    holders: NDArray[np.int32] = field(default_factory=lambda: no_entries((0, 2), np.int32))
    reactions: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    section_forces: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    correction: NDArray[np.float32] = field(default_factory=lambda: no_entries((0, 3), np.float32))
    landmark_correction: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    softest_point: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    diagnostics: Diagnostics = Diagnostics(converged=True)
    lattice: LatticeCounts | None = None
    state: SolverState | None = None

    @property
    def converged(self) -> bool:
        """Whether the equilibrium was found to the tolerance and the gaps asked for."""
        return self.diagnostics.converged

    @property
    def reason(self) -> str:
        """Why the frame did not converge, a sentence; empty when it did."""
        return self.diagnostics.reason

    @property
    def nbytes(self) -> int:
        """The bytes of its arrays, without those of the state."""
        return sum(array.nbytes for array in self.arrays().values())

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Collect its arrays, without those of the state.

        Returns
        -------
        dict[str, NDArray[Any]]
            The arrays by name.
        """
        values = {item.name: getattr(self, item.name) for item in fields(self)}
        return {name: value for name, value in values.items() if isinstance(value, np.ndarray)}

    def shown(self) -> SolvedFrame:
        """Make the view of it for display: without state and corrections, whose memory it does not hold either.

        Returns
        -------
        SolvedFrame
            The view.
        """
        copies: dict[str, Any] = {name: array.copy() for name, array in self.arrays().items()}
        copies.update(correction=no_entries((0, 3), np.float32), landmark_correction=no_entries((0, 3), np.float64))
        return replace(self, **copies, state=None)

    def without_hook(self, number: int) -> SolvedFrame:
        """Leave out a hook, as a program without it numbers the others.

        Parameters
        ----------
        number
            Its number in `Program.hooks`.

        Returns
        -------
        SolvedFrame
            The rest.
        """
        kept = self.hook_index != number
        index = self.hook_index[kept]
        points, forces = self.hook_points[kept], self.hook_forces[kept]
        return replace(self, hook_index=index - (index > number), hook_points=points, hook_forces=forces)

    def without_scalars(self) -> SolvedFrame:
        """Leave out strain, stress and tension.

        Returns
        -------
        SolvedFrame
            The rest.
        """
        empty = no_entries((0,), np.float32)
        return replace(self, strain=empty, stress=empty, tension=empty)

    def scalar(self, name: str) -> NDArray[np.float32] | None:
        """Take a quantity at the points.

        Parameters
        ----------
        name
            One of `SCALARS`.

        Returns
        -------
        NDArray[np.float32] | None
            The values, shape (n,), or None where they are not known.
        """
        values: NDArray[np.float32] = getattr(self, name)
        return values if len(values) == len(self.points) else None
