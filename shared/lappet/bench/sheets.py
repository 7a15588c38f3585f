"""Plain sheets that other programs publish figures for, solved by a daemon from rest in one step.

- The twisted sheet: 100 x 60 x 4 mm, neo-Hookean, E = 50 kPa, one end fixed, the other pulled 30 mm and turned 30°
  about the sheet's long axis.
- The hooked sheet: the uncut patch of the Z-plasty example, 100 x 80 x 4 mm, its rim fixed and its underside free,
  drawn by one hook in the middle.

The residual is the daemon's own, recomputed in double at the end: the force on free nodes over the elastic forces in
the cells. Seconds are the daemon's, without building the lattice. `threads` is what the session asked for: libraries
that have threads of their own (CHOLMOD: OpenMP) follow the environment, which the results record.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.bench.circumstances import cores
from lappet.bench.scenes import pass_times, state_hash
from lappet.cutting.epoch import Epoch
from lappet.daemon.client import SolverClient
from lappet.geometry.labeled_surface import Surface
from lappet.program.program import FrameConstraints
from lappet.program.settings import MaterialParameters, SolverSettings

SHEET = (100.0, 60.0, 4.0)  # mm
PATCH = (100.0, 80.0, 4.0)
PULL, TURN = 30.0, 30.0  # mm, degrees
HOOK, HOOK_STIFFNESS = (5.0, 0.0, 10.0), 300.0  # mm, mN/mm
SKIN = MaterialParameters(model="neoHookean", youngs_modulus=50.0, poissons_ratio=0.45)


@dataclass(frozen=True)
class SheetMeasure:
    """What a plain sheet cost.

    Parameters
    ----------
    benchmark
        Name of the sheet.
    spacing_mm
        Lattice spacing.
    poissons_ratio
        Poisson's ratio.
    precision
        Precision of the arithmetic.
    tolerance
        Relative residual that is asked for.
    threads
        Number of threads.
    isa
        Instruction set.
    converged
        Whether it converged.
    reason
        Why not, or None.
    cells
        Number of cells.
    seconds
        The daemon's time, from rest.
    lattice_seconds
        Time to make the lattice.
    newton_iterations
        Newton iterations.
    pcg_iterations
        Iterations of conjugate gradients.
    load_steps
        Load steps.
    residual
        Relative and true residual.
    newton_iteration_s
        Seconds per Newton iteration.
    update_state_ms
        Milliseconds of one evaluation and one linearization.
    product_ms
        Milliseconds of one product.
    bytes_per_cell
        Peak memory of the daemon over cells.
    session_bytes_per_cell
        Memory that it holds between frames over cells.
    state
        `state_hash` of the result.
    """

    benchmark: str
    spacing_mm: float
    poissons_ratio: float
    precision: str
    tolerance: float
    threads: int
    isa: str
    converged: bool
    reason: str | None
    cells: int
    seconds: float
    lattice_seconds: float
    newton_iterations: int
    pcg_iterations: int
    load_steps: int
    residual: float
    newton_iteration_s: float
    update_state_ms: float
    product_ms: float
    bytes_per_cell: float
    session_bytes_per_cell: float
    state: str


def box(size: Sequence[float]) -> tuple[Surface, NDArray[np.int64]]:
    """Make a closed box with a corner at the origin.

    Parameters
    ----------
    size
        Extent in mm.

    Returns
    -------
    tuple[Surface, NDArray[np.int64]]
        The surface, and the side of each triangle: 2 axis + (0 low, 1 high).
    """
    points = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float) * size
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))], np.int32)
    m = len(triangles)
    plain = Surface(
        points,
        triangles,
        np.zeros((m, 3, 2), np.float32),
        np.zeros(m, np.uint8),
        np.zeros(m, np.bool_),
        np.zeros(m, np.bool_),
    )
    return plain, np.repeat(np.arange(6), 2)


def twisted(spacing: float, tolerance: float, **settings: Any) -> SheetMeasure:
    """Solve the twisted sheet.

    Parameters
    ----------
    spacing
        Lattice spacing in mm.
    tolerance
        Relative residual.
    **settings
        Fields of `SolverSettings`, `materials` among them.

    Returns
    -------
    SheetMeasure
        The row.
    """
    surface, side = box(SHEET)
    epoch = Epoch(0, 1.0, replace(surface, fixed=side == 0), 1)
    turn = math.radians(TURN)
    motion = np.eye(4)
    motion[1:3, 1:3] = [[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]]
    center = np.array(SHEET) / 2.0
    motion[:3, 3] = center - motion[:3, :3] @ center + (PULL, 0.0, 0.0)
    frame = FrameConstraints(
        1.0, 0, retractor_index=np.zeros(1, np.int32), retractor_motion=motion[None].astype(np.float64)
    )
    chosen = SolverSettings(**{"materials": (SKIN,), **settings, "spacing": spacing, "tolerance": tolerance})
    return solve("twisted sheet", replace(chosen, retractors=1), epoch, np.where(side == 1, 0, -1), frame)


def hooked(spacing: float, tolerance: float, **settings: Any) -> SheetMeasure:
    """Solve the hooked sheet.

    Parameters
    ----------
    spacing
        Lattice spacing in mm.
    tolerance
        Relative residual.
    **settings
        Fields of `SolverSettings`.

    Returns
    -------
    SheetMeasure
        The row.
    """
    surface, side = box(PATCH)
    epoch = Epoch(0, 1.0, replace(surface, fixed=side < 4), 1)
    top = int(np.flatnonzero(side == 5)[0])
    anchor = np.array([[PATCH[0] / 2, PATCH[1] / 2, PATCH[2]]])
    frame = FrameConstraints(
        1.0,
        0,
        hook_index=np.zeros(1, np.int32),
        hook_anchors=anchor,
        hook_triangles=np.array([top], np.int32),
        hook_targets=anchor + HOOK,
        hook_stiffness=np.array([HOOK_STIFFNESS]),
    )
    chosen = SolverSettings(**{"materials": (SKIN,), **settings, "spacing": spacing, "tolerance": tolerance})
    return solve("hooked sheet", chosen, epoch, np.full(len(side), -1), frame)


def solve(
    name: str, settings: SolverSettings, epoch: Epoch, grip: NDArray[np.integer], frame: FrameConstraints
) -> SheetMeasure:
    """Solve one frame from rest with a daemon of its own.

    Parameters
    ----------
    name
        Name of the sheet.
    settings
        How to solve.
    epoch
        The sheet.
    grip
        Retractor that grips each triangle, or -1, shape (m,).
    frame
        The constraints.

    Returns
    -------
    SheetMeasure
        The row.
    """
    with SolverClient() as client:
        isa = str(client.welcome["isa"])
        client.open(settings)
        lattice = client.set_epoch(epoch, grip.astype(np.int32))
        solved = client.solve(frame)
    said = solved.diagnostics
    assert solved.state is not None
    cells = max(lattice.cells, 1)
    newton, seconds = said.newton, said.seconds.total
    update, product = pass_times([said])
    return SheetMeasure(
        benchmark=name,
        spacing_mm=settings.spacing,
        poissons_ratio=settings.materials[0].poissons_ratio,
        precision=settings.precision,
        tolerance=settings.tolerance,
        threads=settings.threads or cores(),
        isa=isa,
        converged=solved.converged,
        reason=said.reason or None,
        cells=cells,
        seconds=seconds,
        lattice_seconds=lattice.seconds,
        newton_iterations=newton,
        pcg_iterations=said.pcg,
        load_steps=said.load_steps,
        residual=said.residual,
        newton_iteration_s=seconds / max(newton, 1),
        update_state_ms=update,
        product_ms=product,
        bytes_per_cell=said.peak_bytes / cells,
        session_bytes_per_cell=lattice.bytes / cells,
        state=state_hash(solved.state.nodes),
    )


# The exact spacings of a sheet 4 mm thick with 5 to 14 cells through it: 46 875 to 1 029 000 cells.
SCALING = tuple(4.0 / layers for layers in (5, 6, 8, 10, 12, 14))
PUBLIC = (2.0, 1.0, 0.5)
STIFF = 0.499  # Poisson's ratio


def public(spacings: Sequence[float]) -> list[SheetMeasure]:
    """Solve the twisted sheet to 10⁻⁶ on one thread, which takes double; at 2 mm with a Poisson's ratio of 0.499 too.

    Parameters
    ----------
    spacings
        Lattice spacings in mm.

    Returns
    -------
    list[SheetMeasure]
        The rows.
    """
    rows = [twisted(h, 1e-6, precision="double", threads=1) for h in spacings]
    stiff = replace(SKIN, poissons_ratio=STIFF)
    return [*rows, twisted(2.0, 1e-6, precision="double", threads=1, materials=(stiff,))]


def fitted_exponent(cells: Sequence[float], cost: Sequence[float]) -> float:
    """Fit p of cost = c cells^p by least squares of the logarithms.

    Parameters
    ----------
    cells
        Numbers of cells.
    cost
        What each costs.

    Returns
    -------
    float
        The exponent p.
    """
    return float(np.polyfit(np.log(cells), np.log(cost), 1)[0])


def summary(rows: Sequence[SheetMeasure]) -> dict[str, float]:
    """Sum up the rows of `scaling` and `threads`.

    Parameters
    ----------
    rows
        The rows.

    Returns
    -------
    dict[str, float]
        `time_exponent`, `newton_iteration_exponent`, `bytes_exponent` (totals over cells), `most_bytes_per_cell` and
        `speedup_on_2_threads`, each where there are rows for it.
    """
    values: dict[str, float] = {}
    scaling = [row for row in rows if row.benchmark == "scaling" and row.converged]
    if len(scaling) > 1:
        cells = [row.cells for row in scaling]
        values["time_exponent"] = fitted_exponent(cells, [row.seconds for row in scaling])
        values["newton_iteration_exponent"] = fitted_exponent(cells, [row.newton_iteration_s for row in scaling])
        values["bytes_exponent"] = fitted_exponent(cells, [row.bytes_per_cell * row.cells for row in scaling])
        values["most_bytes_per_cell"] = max(row.bytes_per_cell for row in scaling)
    seconds = {row.threads: row.seconds for row in rows if row.benchmark == "threads" and row.converged}
    if {1, 2} <= set(seconds):
        values["speedup_on_2_threads"] = seconds[1] / seconds[2]
    return values


def sheets(fine: bool) -> list[SheetMeasure]:
    """Solve all sheets.

    Parameters
    ----------
    fine
        Whether to solve the public one at 0.5 mm too, and scaling beyond 400 000 cells.

    Returns
    -------
    list[SheetMeasure]
        The rows.
    """
    rows = public(PUBLIC if fine else PUBLIC[:2])
    rows.append(hooked(1.25, 1e-3, threads=1))
    rows += [replace(twisted(SCALING[0], 1e-3, threads=n), benchmark="threads") for n in (1, 2) if n <= cores()]
    rows += [replace(twisted(h, 1e-3), benchmark="scaling") for h in (SCALING if fine else SCALING[:4])]
    return rows
