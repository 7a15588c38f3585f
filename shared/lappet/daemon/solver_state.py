"""What a later frame starts from: the solver's state, from the wire to the store."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.cutting.epoch import no_entries


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
