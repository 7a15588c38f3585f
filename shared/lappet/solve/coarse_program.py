"""The coarse program of the error estimate, and how fast the displacements of a program converge.

How well tissue happens to fill the cells of a lattice decides about as much of its error as its spacing does. A coarse
lattice whose cells end where those of the fine one do shares that luck, and the two agree on what is wrong. So the
coarse lattice is shifted by half of its own cell; a flat sheet only along itself, since it would else need another
layer of cells, for up to twice the time. Two cases are nested, since their errors are in the proportion that
Richardson's extrapolation takes them to be in: where all of the fine cells are whole and nothing lowers the order; and
with several points per cell, which make every lattice too stiff, the coarser the more.

The order p of the displacements is known in limits only; what is reckoned with between them is *fitted* on
`lappet.reports.error_estimate.fitting_scenes`, for shifted lattices (and, in brackets, for nested ones of several
points per cell, from before):

- 2 where nothing lowers it: that of trilinear cells.
- Where a held side meets a free one, displacements vary as r^a with the distance r (`lappet.reports.clamped_edge`): 2a,
  1.24 at a Poisson's ratio of 0.45, in the limit, and up to 2 before. Fitted: 1.35 (1.5), in cells that the tissue does
  not fill too.
- At the end of a cut a is 1/2 (Williams 1957, J Appl Mech 24:109), which leaves 1 in the limit. Fitted: 1.22 (1.4).
- Between layers, and where it touches bone, the lattice knows a surface to the volumes in a cell only: 1 in the limit.
  Fitted: 1.2 (1).
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lappet.daemon.lattice_counts import LatticeCounts
from lappet.geometry.labeled_surface import FaceOrigin
from lappet.program.program import Program

RATIO = 2.0  # of the spacings
FULL_ORDER = 2.0


class Orders(NamedTuple):
    """Orders of convergence where something lowers them."""

    held: float
    wounded: float
    layered: float


SHIFTED, NESTED = Orders(1.35, 1.22, 1.2), Orders(1.5, 1.4, 1.0)
SHEET = 1.0 / 6.0  # chosen: tissue is a sheet along an axis in which it is thinner than this share of its extent
# The coarse program only has to be better than its own discretization. Sutures that are nearer to each other than its
# cells contradict each other a little there: they get more room, and one point per cell, which bends where more would
# lock.
COARSE_TOLERANCE, COARSE_GAP = 3e-3, 1e-2
SUTURED_TOLERANCE, SUTURED_GAP = 1e-2, 1e-1


def expected_order(program: Program, lattice: LatticeCounts | None = None) -> float:
    """Choose the order of convergence to reckon with.

    Parameters
    ----------
    program
        The program.
    lattice
        Counts of the message `lattice` where they are known.

    Returns
    -------
    float
        The order.
    """
    wounded = (
        len(program.epochs) > 1
        or any(np.any(epoch.surface.origin == FaceOrigin.WOUND_WALL) for epoch in program.epochs)
        or bool(program.hooks)
        or bool(program.sutures)
    )
    orders = NESTED if program.settings.quadrature > 1 else SHIFTED
    if wounded:
        return orders.wounded
    if len(program.bones.points) or any(len(epoch.regions) or len(epoch.strands) for epoch in program.epochs):
        return orders.layered
    settings = program.settings
    cut = lattice is not None and lattice.fine_voxels != lattice.cells * settings.fine_ratio**3
    surfaces = [epoch.surface for epoch in program.epochs]
    held = any(np.any(each.fixed) or np.any(each.resting) for each in surfaces) or bool(program.retractors)
    # What does not draw in when it is pulled does so at no held edge.
    draws_in = any(each.poissons_ratio > 0.0 or each.fiber_k1 > 0.0 for each in settings.materials)
    return orders.held if lattice is None or cut or (held and draws_in) else FULL_ORDER


def coarse_program(program: Program, order: float | None = None) -> Program:
    """Make the program on a lattice of `RATIO` times the spacing, with the same surfaces and constraints.

    Parameters
    ----------
    program
        The program.
    order
        Order of convergence to reckon with; `expected_order` of the program alone where it is None.

    Returns
    -------
    Program
        The coarse program.
    """
    settings = program.settings
    sutured = bool(program.sutures)
    nested = settings.quadrature > 1 or (expected_order(program) if order is None else order) >= FULL_ORDER
    origin = np.array(settings.origin)
    if not nested:
        origin += np.where(_is_wide(program), 0.5 * RATIO * settings.spacing, 0.0)
    x, y, z = (float(each) for each in origin)
    return replace(
        program,
        settings=replace(
            settings,
            spacing=RATIO * settings.spacing,
            origin=(x, y, z),
            quadrature=1 if sutured else settings.quadrature,
            precision="float",
            tolerance=max(settings.tolerance, SUTURED_TOLERANCE if sutured else COARSE_TOLERANCE),
            gap_tolerance=max(settings.gap_tolerance, SUTURED_GAP if sutured else COARSE_GAP),
        ),
    )


def _is_wide(program: Program) -> NDArray[np.bool_]:
    """Along which axes tissue is no sheet, shape (3,)."""
    points = np.concatenate([np.asarray(epoch.surface.points, float) for epoch in program.epochs])
    extent = np.ptp(points, axis=0)
    wide: NDArray[np.bool_] = extent >= SHEET * extent.max()
    return wide
