"""`lappet report error-time`: the displacement error over the seconds that it takes, setting by setting.

Every scene is solved over its spacings with all combinations of quadrature, tolerance, precision and preconditioner
(procedures: each setting varied alone), and held against the extrapolation of its finest solves. Seconds are the
daemon's, lattice included, on however many threads it is given.
"""

from __future__ import annotations

import itertools
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Problem, RefusedError
from lappet.daemon.frame_solver import Connect
from lappet.geometry.labeled_surface import FaceOrigin
from lappet.program.program import Program
from lappet.reports.error_time.reference import Reference, fitted_order, greatest, observed_orders, richardson, rms
from lappet.solve.coarse_program import coarse_program, expected_order
from lappet.solve.error_estimate import RestSkin, frame_error
from lappet.solve.solve_frames import FrameResult, SolveObserver, solve_program
from lappet.solve.store import FrameStore

DEFAULT: dict[str, Any] = {"quadrature": 1, "tolerance": 1e-3, "precision": "float", "preconditioner": "twoLevel"}
CHOICES: dict[str, tuple[Any, ...]] = {
    "quadrature": (1, 4, 8),
    "tolerance": (1e-2, 1e-3, 1e-4),
    "precision": ("float", "double"),
    "preconditioner": ("twoLevel", "chebyshev"),
}
EXACT: dict[str, Any] = {**DEFAULT, "tolerance": 1e-6, "precision": "double"}
FACTOR = 3.0  # that estimates must be within
LEAST_ORDER = 1.8  # that displacements must converge with where nothing lowers it


class Scene(Protocol):
    """What is solved."""

    @property
    def name(self) -> str:
        """Name of the scene."""

    @property
    def what(self) -> str:
        """What the scene is, for people."""

    @property
    def spacings(self) -> tuple[float, ...]:
        """Lattice spacings of the report in mm."""

    @property
    def reference(self) -> tuple[float, float, float]:
        """Three spacings in mm, each half of the one before, finer than those of the report."""

    @property
    def is_box(self) -> bool:
        """Whether the tissue is a box."""

    @property
    def smooth(self) -> bool:
        """Whether nothing lowers the scene's order."""

    @property
    def every_combination(self) -> bool:
        """Whether settings are not only varied alone."""

    @property
    def edge_exponent(self) -> float | None:
        """Exponent of the displacement at the held edges, or None."""

    def away(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Find places that are well away from what is held.

        Parameters
        ----------
        points
            Points in mm, shape (n, 3).

        Returns
        -------
        NDArray[np.bool_]
            Which are, shape (n,).
        """

    def program(self, spacing: float, **settings: Any) -> Program:
        """Make the scene at a spacing.

        Parameters
        ----------
        spacing
            Lattice spacing in mm.
        **settings
            Other fields of `SolverSettings`.

        Returns
        -------
        Program
            The program.
        """


@dataclass(frozen=True)
class Measure:
    """The last frame's error against the reference and its estimate, over the skin's vertices.

    `within_3` and `max_within_3` are None where there is no telling: nothing converged, or the error is below the
    uncertainty of the reference.

    Parameters
    ----------
    scene
        Name of the scene.
    spacing_mm
        Lattice spacing.
    quadrature
        Quadrature points of a cell.
    tolerance
        Relative residual.
    precision
        Precision of the arithmetic.
    preconditioner
        The preconditioner.
    default
        Whether these are the default settings.
    cells
        Number of cells.
    frames
        Number of frames.
    seconds
        Time of all frames.
    estimate_seconds
        Time that the estimate takes besides.
    newton_iterations
        Newton iterations.
    pcg_iterations
        Iterations of conjugate gradients.
    error_mm
        Root mean square error; None where the scene did not converge.
    error_max_mm
        Greatest error.
    estimate_mm
        Root mean square estimate.
    estimate_max_mm
        Greatest estimate.
    within_3
        Whether the root mean square estimate is within a factor 3 of the error.
    max_within_3
        Whether the greatest estimate is.
    reason
        Why the scene did not converge, or None.
    """

    scene: str
    spacing_mm: float
    quadrature: int
    tolerance: float
    precision: str
    preconditioner: str
    default: bool
    cells: int
    frames: int
    seconds: float
    estimate_seconds: float | None
    newton_iterations: int
    pcg_iterations: int
    error_mm: float | None
    error_max_mm: float | None
    estimate_mm: float | None
    estimate_max_mm: float | None
    within_3: bool | None = None
    max_within_3: bool | None = None
    reason: str | None = None


@dataclass(frozen=True)
class Convergence:
    """How a scene converges at one quadrature with the tolerance out of the way.

    Parameters
    ----------
    scene
        Name of the scene.
    quadrature
        Quadrature points of a cell.
    spacings
        Lattice spacings in mm.
    errors_mm
        Errors over the whole skin.
    orders
        Orders from spacing to spacing.
    fitted
        Order over all spacings.
    away_errors_mm
        Errors well away from what is held; None where nothing is.
    away_fitted
        Order over all spacings there, or None.
    """

    scene: str
    quadrature: int
    spacings: tuple[float, ...]
    errors_mm: tuple[float, ...]
    orders: tuple[float, ...]
    fitted: float
    away_errors_mm: tuple[float, ...] | None
    away_fitted: float | None


@dataclass(frozen=True, eq=False)
class SceneReport:
    """A scene's rows, its convergence and its reference.

    Parameters
    ----------
    scene
        The scene.
    reference
        What is taken for the truth.
    rows
        The rows.
    convergence
        How it converges, by quadrature.
    """

    scene: Scene
    reference: Reference
    rows: tuple[Measure, ...]
    convergence: tuple[Convergence, ...]


def combinations(product: bool) -> Iterator[dict[str, Any]]:
    """List the settings to run, the default first.

    Parameters
    ----------
    product
        Whether to run all combinations, or each setting varied alone.

    Yields
    ------
    dict[str, Any]
        Settings by name.
    """
    yield dict(DEFAULT)
    if product:
        for values in itertools.product(*CHOICES.values()):
            chosen = dict(zip(CHOICES, values, strict=True))
            if chosen != DEFAULT:
                yield chosen
    else:
        for name, values in CHOICES.items():
            yield from ({**DEFAULT, name: value} for value in values if value != DEFAULT[name])


def error_time(
    scene: Scene,
    connect: Connect,
    *,
    product: bool,
    say: Callable[[str], None] = lambda _: None,
) -> SceneReport:
    """Measure a scene.

    Parameters
    ----------
    scene
        The scene.
    connect
        Makes the solver.
    product
        Whether to run all combinations, or each setting varied alone.
    say
        Is told of every solve.

    Returns
    -------
    SceneReport
        The scene's report.
    """
    say(f"{scene.name}: reference at {', '.join(f'{h:.3g}' for h in scene.reference)} mm")
    reference = _reference(scene, connect)
    rows = []
    for spacing in scene.spacings:
        for chosen in combinations(product):
            row = _measure(scene, spacing, chosen, reference, connect)
            rows.append(row)
            error = "failed" if row.error_mm is None else f"{row.error_mm:.2g} mm"
            with_what = " ".join(str(value) for value in chosen.values())
            say(f"{scene.name} {spacing:.3g} mm {with_what}: {error}, {row.seconds:.2f} s")
    convergence = [
        found
        for quadrature in (CHOICES["quadrature"] if scene.is_box else (1,))
        if (found := _convergence(scene, quadrature, reference, connect)) is not None
    ]
    return SceneReport(scene, reference, tuple(rows), tuple(convergence))


def skin_of(program: Program) -> NDArray[np.integer]:
    """Find the vertices of the last epoch's skin.

    Parameters
    ----------
    program
        The program.

    Returns
    -------
    NDArray[np.integer]
        Vertex indices, shape (s,).
    """
    surface = program.epochs[-1].surface
    return np.unique(surface.triangles[surface.origin == FaceOrigin.SKIN])


def _solve(program: Program, connect: Connect) -> tuple[tuple[FrameResult, ...], Problem | None]:
    with tempfile.TemporaryDirectory() as folder:  # nothing is looked up
        found = solve_program(program, FrameStore(Path(folder)), connect, "report", SolveObserver())
    return found.frames, found.reason


def _seconds(frames: Sequence[FrameResult]) -> float:
    lattices = {frame.constraints.epoch: frame.solved.lattice for frame in frames}
    built = sum(counts.seconds for counts in lattices.values() if counts is not None)
    return built + sum(float(frame.solved.diagnostics.seconds.total) for frame in frames)


def _reference(scene: Scene, connect: Connect) -> Reference:
    """Of a box: the middle between the limits of one point and of eight, whose errors have nothing in common."""
    if not scene.is_box:
        return _limit(scene, {**DEFAULT, "tolerance": 1e-4}, connect)
    one = _limit(scene, EXACT, connect)
    eight = _limit(scene, {**EXACT, "quadrature": 8}, connect)
    apart = rms(one.points - eight.points)
    far_apart = greatest(one.points - eight.points)
    return Reference(
        (one.points + eight.points) / 2.0,
        one.order,
        max(apart / 2.0, one.uncertainty / 2.0),
        max(far_apart / 2.0, one.uncertainty_max / 2.0),
    )


def _limit(scene: Scene, settings: dict[str, Any], connect: Connect) -> Reference:
    positions = []
    for spacing in scene.reference:
        program = scene.program(spacing, **settings)
        frames, reason = _solve(program, connect)
        if reason is not None:
            raise RefusedError([replace(reason, prim=f"{scene.name} at {spacing:.3g} mm")])
        positions.append(frames[-1].solved.points[skin_of(program)].astype(float))
    return richardson(*positions)


def _measure(scene: Scene, spacing: float, chosen: dict[str, Any], reference: Reference, connect: Connect) -> Measure:
    program = scene.program(spacing, correction=True, **chosen)
    frames, reason = _solve(program, connect)
    row = Measure(
        scene=scene.name,
        spacing_mm=spacing,
        **chosen,
        default=chosen == DEFAULT,
        cells=max((each.solved.lattice.cells for each in frames if each.solved.lattice is not None), default=0),
        frames=len(frames),
        seconds=_seconds(frames),
        estimate_seconds=None,
        newton_iterations=sum(int(frame.solved.diagnostics.newton) for frame in frames),
        pcg_iterations=sum(int(frame.solved.diagnostics.pcg) for frame in frames),
        error_mm=None,
        error_max_mm=None,
        estimate_mm=None,
        estimate_max_mm=None,
        reason=None if reason is None else str(reason),
    )
    if reason is not None:
        return row
    skin = skin_of(program)
    off = frames[-1].solved.points[skin] - reference.points
    order = expected_order(program, frames[0].solved.lattice)
    partners, failure = _solve(coarse_program(program, order), connect)
    partner = partners[-1].solved if failure is None else None
    estimate = frame_error(frames[-1].solved, partner, RestSkin.of(program.epochs[-1]), order, spacing)
    row = replace(
        row,
        error_mm=rms(off),
        error_max_mm=greatest(off),
        estimate_seconds=_seconds(partners),
    )
    if estimate is None or partner is None:
        return row
    return replace(
        row,
        estimate_mm=estimate.rms,
        estimate_max_mm=estimate.greatest,
        within_3=_within(estimate.rms, rms(off), reference.uncertainty),
        max_within_3=_within(estimate.greatest, greatest(off), reference.uncertainty_max),
    )


def _within(estimate: float, error: float, uncertainty: float) -> bool | None:
    return error / FACTOR <= estimate <= FACTOR * error if error > uncertainty else None


def _convergence(scene: Scene, quadrature: int, reference: Reference, connect: Connect) -> Convergence | None:
    settings = {**(EXACT if scene.is_box else {**DEFAULT, "tolerance": 1e-4}), "quadrature": quadrature}
    errors: list[float] = []
    away_errors: list[float] = []
    for spacing in scene.spacings:
        program = scene.program(spacing, **settings)
        skin = skin_of(program)
        frames, reason = _solve(program, connect)
        if reason is not None:
            return None
        off = frames[-1].solved.points[skin] - reference.points
        errors.append(rms(off))
        away = scene.away(program.epochs[-1].surface.points[skin])
        away_errors.append(rms(off[away]))
    return Convergence(
        scene.name,
        quadrature,
        scene.spacings,
        tuple(errors),
        tuple(observed_orders(scene.spacings, errors)),
        fitted_order(scene.spacings, errors),
        tuple(away_errors) if scene.is_box else None,
        fitted_order(scene.spacings, away_errors) if scene.is_box else None,
    )
