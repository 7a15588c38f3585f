"""A solved frame: the one shape that it has from the wire to the store, the skin cache, the report and the window."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.cutting.epoch import no_entries
from lappet.daemon.frame_diagnostics import Diagnostics
from lappet.daemon.lattice_counts import LatticeCounts
from lappet.daemon.solver_state import SolverState

SCALARS = ("strain", "stress", "tension")
HOLDERS = ("fixed", "retractor", "bed", "bone", "weak bed", "roller", "load")  # as PROTOCOL.md numbers them


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
    diagnostics: Diagnostics = field(default_factory=lambda: Diagnostics(converged=True))
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
