"""The printed error of a scene's last frame against its true one, at the default settings and several spacings."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from lappet.core.problem import Problem, RefusedError
from lappet.daemon.frame_solver import Connect
from lappet.program.program import Program
from lappet.reports.error_estimate.measured_values import FACTOR, ValueRow, value_rows
from lappet.reports.error_estimate.scene import EstimateScene
from lappet.reports.error_time.reference import Reference, greatest, richardson, rms
from lappet.solve.error_estimate import ErrorEstimate, RestSkin, estimate_errors
from lappet.solve.measure_errors import errors_of_measures
from lappet.solve.measures import FrameMeasures, Gauges
from lappet.solve.solve_frames import FrameResult, SolveObserver, solve_program
from lappet.solve.store import FrameStore

SHARE = 0.95  # of the estimates
EXACT: dict[str, Any] = {"tolerance": 1e-5, "precision": "double", "strain": False}


@dataclass(frozen=True)
class EstimateRow:
    """The last frame's estimate against its error, over the skin's vertices.

    A ratio is None where there is no telling: nothing converged, or the error is below the uncertainty of the
    reference.

    Parameters
    ----------
    scene
        Name of the scene.
    spacing_mm
        Lattice spacing.
    cells
        Number of cells.
    frames
        Number of frames.
    error_mm
        Root mean square error.
    error_max_mm
        Greatest error.
    estimate_mm
        Root mean square estimate.
    estimate_max_mm
        Greatest estimate.
    ratio
        Root mean square estimate over error.
    max_ratio
        Greatest estimate over greatest error.
    order
        Order of convergence that the estimate reckoned with.
    largest_displacement_mm
        Largest displacement of the skin.
    is_trusted
        Whether the estimate says that the frame is to be trusted.
    uncertainty_mm
        Root mean square uncertainty of the reference.
    uncertainty_max_mm
        Greatest uncertainty of the reference.
    reference_order
        Order observed between the spacings of the reference.
    reason
        Why there is no error or no estimate, or None.
    """

    scene: str
    spacing_mm: float
    cells: int
    frames: int
    error_mm: float | None
    error_max_mm: float | None
    estimate_mm: float | None
    estimate_max_mm: float | None
    ratio: float | None
    max_ratio: float | None
    order: float | None
    largest_displacement_mm: float | None
    is_trusted: bool | None
    uncertainty_mm: float
    uncertainty_max_mm: float
    reference_order: float
    reason: str | None = None

    @property
    def ratios(self) -> tuple[float, ...]:
        """The ratios that there are."""
        return tuple(each for each in (self.ratio, self.max_ratio) if each is not None)

    @property
    def is_within(self) -> bool:
        """Whether there is an estimate and both ratios are within a factor 3, or there is no telling."""
        return self.reason is None and all(1.0 / FACTOR <= each <= FACTOR for each in self.ratios)

    @property
    def is_too_small(self) -> bool:
        """Whether an estimate is below a third of the error."""
        return any(each < 1.0 / FACTOR for each in self.ratios)


class SceneRows(NamedTuple):
    """What is measured of a scene: the displacements' errors, and those of forces, tensions and seams."""

    rows: list[EstimateRow]
    values: list[ValueRow]


class _Truth(NamedTuple):
    """What a scene is held against: displacements, and what is measured on the finest lattice and the one before."""

    displacements: Reference
    measures: tuple[FrameMeasures, FrameMeasures] | None


def measure_scene(
    scene: EstimateScene, store: FrameStore, connect: Connect, say: Callable[[str], None] = lambda _: None
) -> SceneRows:
    """Measure a scene at all its spacings.

    Parameters
    ----------
    scene
        The scene.
    store
        Where frames are kept.
    connect
        Makes the solver.
    say
        Is told of every spacing.

    Returns
    -------
    SceneRows
        The rows; without a reference, those that say why there is none.
    """
    skin = RestSkin.of(scene.program(scene.spacings[0]).epochs[-1])
    try:
        truth = _truth(scene, skin, store, connect)
    except RefusedError as error:
        say(str(error))
        return SceneRows([_without_reference(scene, spacing, error.problems[0]) for spacing in scene.spacings], [])
    rows, values = [], []
    for spacing in scene.spacings:
        row, own = _row(scene, spacing, skin, truth, store, connect)
        rows.append(row)
        values += own
        said = row.reason or f"estimated {row.estimate_mm:.2g} mm, true {row.error_mm:.2g} mm"
        say(f"{scene.name} {spacing:.3g} mm: {said}")
    return SceneRows(rows, values)


def _without_reference(scene: EstimateScene, spacing: float, why: Problem) -> EstimateRow:
    nothing = (None,) * 9
    return EstimateRow(scene.name, spacing, 0, 0, *nothing, math.nan, math.nan, math.nan, reason=str(why))


def _truth(scene: EstimateScene, skin: RestSkin, store: FrameStore, connect: Connect) -> _Truth:
    positions, measured = [], []
    for spacing in scene.reference:
        program = scene.program(spacing, **{**EXACT, "strain": scene.procedure is not None})
        frames, reason = _solve(program, store, connect)
        if reason is not None:
            raise RefusedError([replace(reason, prim=f"{scene.name} at {spacing:.3g} mm")])
        positions.append(frames[-1].solved.points[skin.vertices].astype(float))
        if scene.procedure is not None:
            measured.append(Gauges(program).measure(frames[-1].solved, tension=True))
    return _Truth(richardson(*positions), (measured[-1], measured[-2]) if measured else None)


def _row(
    scene: EstimateScene, spacing: float, skin: RestSkin, truth: _Truth, store: FrameStore, connect: Connect
) -> tuple[EstimateRow, list[ValueRow]]:
    program = scene.program(spacing, correction=True)
    frames, reason = _solve(program, store, connect)
    reference = truth.displacements
    row = EstimateRow(
        scene=scene.name,
        spacing_mm=spacing,
        cells=max((each.solved.lattice.cells for each in frames if each.solved.lattice is not None), default=0),
        frames=len(frames),
        error_mm=None,
        error_max_mm=None,
        estimate_mm=None,
        estimate_max_mm=None,
        ratio=None,
        max_ratio=None,
        order=None,
        largest_displacement_mm=None,
        is_trusted=None,
        uncertainty_mm=reference.uncertainty,
        uncertainty_max_mm=reference.uncertainty_max,
        reference_order=reference.order,
        reason=None if reason is None else str(reason),
    )
    if reason is not None:
        return row, []
    off = frames[-1].solved.points[skin.vertices] - reference.points
    row = replace(row, error_mm=rms(off), error_max_mm=greatest(off))
    errors = estimate_errors(program, frames, store, connect, "report")
    return _judged(row, errors), _values(scene, program, frames[-1], errors, truth)


def _values(
    scene: EstimateScene, program: Program, frame: FrameResult, errors: ErrorEstimate, truth: _Truth
) -> list[ValueRow]:
    """What is measured at the last frame, with estimated and true errors; of a box nothing."""
    if scene.procedure is None or truth.measures is None:
        return []
    gauges = Gauges(program)
    own = gauges.measure(frame.solved, tension=True)
    last = replace(errors, frames=errors.frames[-1:], coarse=errors.coarse[-1:])
    (found,) = errors_of_measures(program, gauges, [frame.solved], [own], last)
    return value_rows(scene.name, program.settings.spacing, found, truth.measures)


def _judged(row: EstimateRow, errors: ErrorEstimate) -> EstimateRow:
    """The row with its estimate."""
    estimate = errors.frames[-1]
    if estimate is None or errors.reason is not None:
        return replace(row, reason=str(errors.reason))
    assert row.error_mm is not None
    assert row.error_max_mm is not None
    return replace(
        row,
        estimate_mm=estimate.rms,
        estimate_max_mm=estimate.greatest,
        ratio=_ratio(estimate.rms, row.error_mm, row.uncertainty_mm),
        max_ratio=_ratio(estimate.greatest, row.error_max_mm, row.uncertainty_max_mm),
        order=errors.order,
        largest_displacement_mm=estimate.largest_displacement,
        is_trusted=estimate.is_trusted,
    )


def _ratio(estimate: float, error: float, uncertainty: float) -> float | None:
    return estimate / error if error > uncertainty else None


def _solve(program: Program, store: FrameStore, connect: Connect) -> tuple[Sequence[FrameResult], Problem | None]:
    found = solve_program(program, store, connect, "report", SolveObserver())
    return found.frames, found.reason
