"""The estimate of a solve's displacement error: what the lattice costs and what stopping early costs, in mm.

- Discretization: the same frames are solved once more on a lattice of twice the spacing h. Where displacements converge
  as h^p, the error at h is |u_h - u_2h| / (2^p - 1) (Richardson).
- Algebraic: the Newton step left over at the end of a frame, K^-1 residual, which the daemon sends along.

Both are taken at the vertices of the skin and at the landmarks.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lappet.frame_solver import Connect
from lappet.program import Epoch, FaceOrigin, Program
from lappet.solve import FrameResult, Watcher, solve_program
from lappet.store import FrameStore

RATIO = 2.0  # of the spacings
# Observed orders of convergence: smooth fields, and fields with wound edges, hooks and sutures (`lappet report
# error-time` measures them).
SMOOTH_ORDER, WOUNDED_ORDER = 1.5, 1.25
# The companion only has to be better than its own discretization. Sutures that are nearer to each other than its cells
# contradict each other a little there: they get more room, and one point per cell, which bends where more would lock.
COMPANION_TOLERANCE, COMPANION_GAP = 3e-3, 1e-2
SUTURED_TOLERANCE, SUTURED_GAP = 1e-2, 1e-1


@dataclass(frozen=True)
class FrameError:
    """The estimated displacement error of a frame in mm: greatest and root mean square over the skin's vertices.

    landmarks: per landmark of the frame, in the order of its array. A part that could not be had is None; the totals
    are those of the parts that are there.
    """

    greatest: float
    rms: float
    algebraic_greatest: float | None
    algebraic_rms: float | None
    discretization_greatest: float | None
    discretization_rms: float | None
    landmarks: tuple[float, ...] = ()


@dataclass(frozen=True)
class ErrorEstimate:
    """The estimate of a solve. frames: one per frame, None where there is none. spacing: of the companion, mm. order:
    that was reckoned with. seconds: that it took. reason: why frames lack the discretization part, or None.
    """

    frames: tuple[FrameError | None, ...]
    spacing: float
    order: float
    seconds: float
    reason: str | None = None


def expected_order(program: Program) -> float:
    """The order of convergence to reckon with: `SMOOTH_ORDER` where nothing is cut, hooked or sutured."""
    wounded = (
        len(program.epochs) > 1
        or any(np.any(epoch.surface.origin == FaceOrigin.WOUND_WALL) for epoch in program.epochs)
        or bool(program.hooks)
        or bool(program.sutures)
    )
    return WOUNDED_ORDER if wounded else SMOOTH_ORDER


def companion(program: Program) -> Program:
    """The program on a lattice of `RATIO` times the spacing: the same surfaces and constraints."""
    settings = program.settings
    sutured = bool(program.sutures)
    return replace(
        program,
        settings=replace(
            settings,
            spacing=RATIO * settings.spacing,
            quadrature=1 if sutured else settings.quadrature,
            precision="float",
            tolerance=max(settings.tolerance, SUTURED_TOLERANCE if sutured else COMPANION_TOLERANCE),
            gap_tolerance=max(settings.gap_tolerance, SUTURED_GAP if sutured else COMPANION_GAP),
            correction=False,
            strain=False,
        ),
    )


def estimate_errors(
    program: Program,
    frames: Sequence[FrameResult],
    store: FrameStore,
    connect: Connect,
    solver: str,
    watch: Watcher | None = None,
) -> ErrorEstimate:
    """The estimate for solved frames of a program, the first ones in order.

    The companion's frames are looked up in and kept in the store like any others. Ctrl-C ends the companion and leaves
    the rest of the frames without their discretization part.
    """
    begun = time.perf_counter()
    partner = replace(companion(program), frames=program.frames[: len(frames)])
    solved = solve_program(partner, store, connect, solver, watch or Watcher())
    order = expected_order(program)
    skins = {epoch.index: _skin(epoch) for epoch in program.epochs}
    errors = []
    for index, frame in enumerate(frames):
        other = solved.frames[index] if index < len(solved.frames) else None
        errors.append(frame_error(frame, other, skins[frame.constraints.epoch], order))
    reason = None
    if len(solved.frames) < len(frames):
        reason = f"At {partner.settings.spacing:g} mm, for the estimate of the error: {solved.reason}"
    return ErrorEstimate(tuple(errors), partner.settings.spacing, order, time.perf_counter() - begun, reason)


def frame_error(
    frame: FrameResult, coarse: FrameResult | None, skin: NDArray[np.integer], order: float
) -> FrameError | None:
    """The error of one frame. coarse: the same frame of the companion. skin: (s,) the vertices of the skin."""
    algebraic = frame.arrays.get("correction")
    algebraic = algebraic[skin].astype(float) if algebraic is not None and len(algebraic) else None
    marks = frame.arrays.get("landmark_correction")
    discretization = None
    at_marks = np.zeros(len(frame.arrays["landmarks"]))
    if coarse is not None:
        share = 1.0 / (RATIO**order - 1.0)
        difference = frame.arrays["points"][skin].astype(float) - coarse.arrays["points"][skin]
        discretization = share * difference
        if len(coarse.arrays["landmarks"]) == len(at_marks):
            at_marks += share**2 * _squares(frame.arrays["landmarks"] - coarse.arrays["landmarks"])
    if algebraic is None and discretization is None:
        return None
    if marks is not None and len(marks) == len(at_marks):
        at_marks += _squares(marks)
    squares = sum((_squares(part) for part in (algebraic, discretization) if part is not None), np.zeros(len(skin)))
    greatest, rms = _norms(squares)
    parts = [(None, None) if part is None else _norms(_squares(part)) for part in (algebraic, discretization)]
    return FrameError(
        greatest,
        rms,
        algebraic_greatest=parts[0][0],
        algebraic_rms=parts[0][1],
        discretization_greatest=parts[1][0],
        discretization_rms=parts[1][1],
        landmarks=tuple(float(v) for v in np.sqrt(at_marks)),
    )


def _skin(epoch: Epoch) -> NDArray[np.integer]:
    surface = epoch.surface
    return np.unique(surface.triangles[surface.origin == FaceOrigin.SKIN])


def _squares(vectors: NDArray[np.floating]) -> NDArray[np.float64]:
    return np.einsum("ij,ij->i", vectors, vectors).astype(np.float64)


def _norms(squares: NDArray[np.float64]) -> tuple[float, float]:
    """The greatest and the root mean square of lengths that are given squared."""
    if not len(squares):
        return 0.0, 0.0
    return float(np.sqrt(squares.max())), float(np.sqrt(squares.mean()))
