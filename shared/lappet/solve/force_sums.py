"""The forces of a frame's sutures summed up: in all, at most, closure by closure, and the share of the donor site."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from lappet.solve.seam_measures import SeamState
from lappet.solve.suture_forces import SutureForce, closing_tension


@dataclass(frozen=True)
class ClosureForces:
    """The forces of a closure, without those of sutures that the lattice does not resolve.

    Parameters
    ----------
    closure
        Its name.
    total_mn
        Their sum in mN.
    greatest_mn
        The greatest of them in mN.
    share
        Share of the forces of the frame.
    tension_n_per_mm
        Closing tension in N/mm, over the scar of its seam; None for a closure that belongs to no seam.
    along_mm
        Where each suture is along the closure at rest in mm.
    force_mn
        Their forces in mN.
    total_error_mn, greatest_error_mn, tension_error_n_per_mm, force_error_mn
        Estimated errors of these; None without an estimate.
    """

    closure: str
    total_mn: float
    greatest_mn: float
    share: float
    tension_n_per_mm: float | None
    along_mm: tuple[float, ...]
    force_mn: tuple[float, ...]
    total_error_mn: float | None = None
    greatest_error_mn: float | None = None
    tension_error_n_per_mm: float | None = None
    force_error_mn: tuple[float | None, ...] = ()


@dataclass(frozen=True)
class ForceSums:
    """The forces of a frame's sutures, without those that the lattice does not resolve.

    Parameters
    ----------
    total_mn
        Their sum in mN.
    greatest_mn
        The greatest of them in mN.
    greatest_suture
        Its suture; None where no suture is placed and resolved.
    donor_share
        Share of the closures with "donor" in their names; None where none has.
    unresolved
        The sutures that are left out.
    closures
        Closure by closure.
    total_error_mn, greatest_error_mn
        Estimated errors in mN; None without an estimate.
    coarse_share
        Sum on the coarse lattice over that here, of the sutures that both resolve; None without an estimate.
    """

    total_mn: float
    greatest_mn: float
    greatest_suture: str | None
    donor_share: float | None
    unresolved: tuple[str, ...]
    closures: tuple[ClosureForces, ...]
    total_error_mn: float | None = None
    greatest_error_mn: float | None = None
    coarse_share: float | None = None


def force_sums(rows: Sequence[SutureForce], seams: Sequence[SeamState] = ()) -> ForceSums:
    """Sum up the forces of a frame.

    Parameters
    ----------
    rows
        Its rows.
    seams
        Its seams.

    Returns
    -------
    ForceSums
        The sums; the error of what is greatest is that of its row.
    """
    kept = [row for row in rows if row.resolved]
    total = sum(row.force_mn for row in kept)
    lengths = {closure: state.measure.scar_length_mm for state in seams for closure in state.closures}
    closures = []
    for name in dict.fromkeys(row.closure for row in kept):
        own = [row for row in kept if row.closure == name]
        force = sum(row.force_mn for row in own)
        most = max(own, key=lambda row: row.force_mn)
        every = [row for row in rows if row.closure == name]
        closures.append(
            ClosureForces(
                name,
                force,
                most.force_mn,
                force / total if total > 0.0 else 0.0,
                closing_tension(every, lengths[name]) if name in lengths else None,
                tuple(row.along_mm for row in own),
                tuple(row.force_mn for row in own),
                greatest_error_mn=most.force_error_mn,
                force_error_mn=tuple(row.force_error_mn for row in own),
            )
        )
    donors = [each.share for each in closures if "donor" in each.closure.lower()]
    greatest = max(kept, key=lambda row: row.force_mn, default=None)
    return ForceSums(
        total,
        greatest.force_mn if greatest else 0.0,
        greatest.suture if greatest else None,
        sum(donors) if donors else None,
        tuple(row.suture for row in rows if not row.resolved),
        tuple(closures),
        greatest_error_mn=greatest.force_error_mn if greatest else None,
    )
