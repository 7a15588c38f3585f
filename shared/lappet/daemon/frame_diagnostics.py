"""How a frame was solved: whether it converged, and what that took."""

from __future__ import annotations

import math
from dataclasses import dataclass, field


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
        The same in the state that the frame was solved from.
    untangled
        How many of these were taken apart, before the frame was solved or where it rested; pairs at the others were
        left out.
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
    untangled: int = 0
    lowest_stiffness: float = math.nan
    saddles_left: int = 0
    peak_bytes: float = 0.0
    seconds: StageSeconds = field(default_factory=StageSeconds)
    work: PassCounts = field(default_factory=PassCounts)
