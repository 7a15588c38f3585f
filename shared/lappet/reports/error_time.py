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

from lappet.error_estimate import companion, expected_order, frame_error
from lappet.frame_solver import Connect
from lappet.program import FaceOrigin, Program
from lappet.reports.reference import Reference, fitted_order, greatest, observed_orders, richardson, rms
from lappet.reports.report_error import ReportError
from lappet.solve import FrameResult, Watcher, solve_program
from lappet.store import FrameStore

DEFAULT: dict[str, Any] = {"quadrature": 1, "tolerance": 1e-3, "precision": "float", "preconditioner": "twoLevel"}
CHOICES: dict[str, tuple[Any, ...]] = {
    "quadrature": (1, 4, 8),
    "tolerance": (1e-2, 1e-3, 1e-4),
    "precision": ("float", "double"),
    "preconditioner": ("twoLevel", "chebyshev"),
}
EXACT: dict[str, Any] = {**DEFAULT, "tolerance": 1e-6, "precision": "double"}


class Scene(Protocol):
    """What is solved. `reference`: three spacings, each half of the one before, finer than those of the report."""

    @property
    def name(self) -> str: ...

    @property
    def what(self) -> str: ...

    @property
    def spacings(self) -> tuple[float, ...]: ...

    @property
    def reference(self) -> tuple[float, float, float]: ...

    @property
    def is_box(self) -> bool: ...

    def program(self, spacing: float, **settings: Any) -> Program: ...


@dataclass(frozen=True)
class Measure:
    """One row: the last frame's error against the reference and its estimate, over the skin's vertices, in mm.

    error_mm, estimate_mm: root mean square; the others the greatest. seconds: all frames; estimate_seconds: what the
    estimate takes besides. Where the scene did not converge errors are None and `reason` says why.
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
    reason: str | None = None


@dataclass(frozen=True)
class Convergence:
    """How a scene converges at one quadrature with the tolerance out of the way. orders: from spacing to spacing."""

    scene: str
    quadrature: int
    spacings: tuple[float, ...]
    errors_mm: tuple[float, ...]
    orders: tuple[float, ...]
    fitted: float


@dataclass(frozen=True, eq=False)
class SceneReport:
    """A scene's rows, its convergence and its reference."""

    scene: Scene
    reference: Reference
    rows: tuple[Measure, ...]
    convergence: tuple[Convergence, ...]


def combinations(product: bool) -> Iterator[dict[str, Any]]:
    """The settings to run, the default first: all of them, or each varied alone."""
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
    """Measures a scene. say: is told of every solve."""
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
    """The vertices (s,) of the last epoch's skin."""
    surface = program.epochs[-1].surface
    return np.unique(surface.triangles[surface.origin == FaceOrigin.SKIN])


def _solve(program: Program, connect: Connect) -> tuple[tuple[FrameResult, ...], str | None]:
    with tempfile.TemporaryDirectory() as folder:  # nothing is looked up
        found = solve_program(program, FrameStore(Path(folder)), connect, "report", Watcher())
    return found.frames, found.reason


def _seconds(frames: Sequence[FrameResult]) -> float:
    lattices = {frame.constraints.epoch: frame.header["lattice"] for frame in frames}
    built = sum(float(counts["seconds"]) for counts in lattices.values())
    return built + sum(float(frame.header["seconds"]["total"]) for frame in frames)


def _reference(scene: Scene, connect: Connect) -> Reference:
    settings = EXACT if scene.is_box else {**DEFAULT, "tolerance": 1e-4}
    positions = []
    for spacing in scene.reference:
        program = scene.program(spacing, **settings)
        frames, reason = _solve(program, connect)
        if reason is not None:
            raise ReportError(f"The reference of {scene.name} at {spacing:.3g} mm failed: {reason}")
        positions.append(frames[-1].arrays["points"][skin_of(program)].astype(float))
    return richardson(*positions)


def _measure(scene: Scene, spacing: float, chosen: dict[str, Any], reference: Reference, connect: Connect) -> Measure:
    program = scene.program(spacing, correction=True, **chosen)
    frames, reason = _solve(program, connect)
    row = Measure(
        scene=scene.name,
        spacing_mm=spacing,
        **chosen,
        default=chosen == DEFAULT,
        cells=max((int(frame.header["lattice"]["cells"]) for frame in frames), default=0),
        frames=len(frames),
        seconds=_seconds(frames),
        estimate_seconds=None,
        newton_iterations=sum(int(frame.header["newton"]) for frame in frames),
        pcg_iterations=sum(int(frame.header["pcg"]) for frame in frames),
        error_mm=None,
        error_max_mm=None,
        estimate_mm=None,
        estimate_max_mm=None,
        reason=reason,
    )
    if reason is not None:
        return row
    skin = skin_of(program)
    off = frames[-1].arrays["points"][skin] - reference.points
    partners, failure = _solve(companion(program), connect)
    partner = partners[-1] if failure is None else None
    estimate = frame_error(frames[-1], partner, skin, expected_order(program))
    return replace(
        row,
        error_mm=rms(off),
        error_max_mm=greatest(off),
        estimate_mm=None if estimate is None or partner is None else estimate.rms,
        estimate_max_mm=None if estimate is None or partner is None else estimate.greatest,
        estimate_seconds=_seconds(partners),
    )


def _convergence(scene: Scene, quadrature: int, reference: Reference, connect: Connect) -> Convergence | None:
    settings = {**(EXACT if scene.is_box else {**DEFAULT, "tolerance": 1e-4}), "quadrature": quadrature}
    errors = []
    for spacing in scene.spacings:
        program = scene.program(spacing, **settings)
        frames, reason = _solve(program, connect)
        if reason is not None:
            return None
        errors.append(rms(frames[-1].arrays["points"][skin_of(program)] - reference.points))
    return Convergence(
        scene.name,
        quadrature,
        scene.spacings,
        tuple(errors),
        tuple(observed_orders(scene.spacings, errors)),
        fitted_order(scene.spacings, errors),
    )
