"""The estimate of a solve's displacement error: what the lattice costs and what stopping early costs, in mm.

- Algebraic: the Newton step left over at the end of a frame, K^-1 residual, which the daemon sends along.
- Discretization: the same frames are solved once more on a lattice of twice the spacing h. Where displacements converge
  as h^p, what is left at h is (u_h - u_2h) / (2^p - 1) (Richardson), each u with its own Newton step left over added.
- One point per cell errs to both sides: held edges too stiffly, bending too softly. Where the two happen to cancel,
  between two spacings or at one, that difference says little. Where nothing else spoils the order a second indicator
  is asked, full quadrature at 4h, which costs next to nothing: what lies between the two, times `ONE_POINT_SHARE`. The
  estimate is the geometric mean of both.

- Gaps: what sutures and grips are open beyond what was asked for.

The parts add at each place by their lengths: a part may cancel another in one solve, but nothing says that it does, so
the total is never below a part. They are taken at the vertices of the skin and at the landmarks.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.cutting.epoch import Epoch
from lappet.daemon.frame_solver import Connect
from lappet.daemon.solved_frame import LatticeCounts, SolvedFrame
from lappet.geometry.labeled_surface import FaceOrigin
from lappet.program.program import Program
from lappet.solve.solve_frames import FrameResult, SolveObserver, solve_program
from lappet.solve.store import FrameStore

RATIO = 2.0  # of the spacings
# Orders of convergence: where nothing lowers it; where a held side meets a free one, whose stress is singular (between
# the 1.2 that it leaves in the limit and 2), or where the surface runs across cells; with wound edges, hooks and
# sutures. `lappet report error-time` measures them.
FULL_ORDER, HELD_ORDER, WOUNDED_ORDER = 2.0, 1.5, 1.25
# What the second indicator is worth: in all boxes of the report the error of one point is 0.7 to 19 % of its distance
# to full quadrature at four times the spacing.
FAR_RATIO, FAR_QUADRATURE, ONE_POINT_SHARE = 4.0, 4, 0.022
# The coarse program only has to be better than its own discretization. Sutures that are nearer to each other than its
# cells contradict each other a little there: they get more room, and one point per cell, which bends where more would
# lock.
COARSE_TOLERANCE, COARSE_GAP = 3e-3, 1e-2
SUTURED_TOLERANCE, SUTURED_GAP = 1e-2, 1e-1
# Chosen: a frame is not to be trusted where its error exceeds this share of the largest displacement, or the spacing.
# What is below the least share of the spacing is nothing to warn about, however little has moved.
TRUSTED_SHARE, LEAST_DOUBTED = 0.1, 0.05


@dataclass(frozen=True)
class FrameErrorEstimate:
    """The estimated displacement error of a frame over the skin's vertices.

    A part that could not be had is None; the totals are those of the parts that are there, added at each place by their
    lengths.

    Parameters
    ----------
    greatest
        Greatest error in mm.
    rms
        Root mean square error in mm.
    algebraic_greatest
        Greatest error of stopping early in mm.
    algebraic_rms
        Root mean square error of stopping early in mm.
    discretization_greatest
        Greatest error of the lattice in mm.
    discretization_rms
        Root mean square error of the lattice in mm.
    gaps_greatest
        Largest gap of sutures and grips in mm.
    gaps_rms
        Root mean square gap of the sutures in mm.
    landmarks
        Error of each landmark of the frame in mm, in the order of its array.
    place
        Rest point in mm of the vertex whose error is greatest; None without vertices.
    largest_displacement
        Largest displacement of the skin from rest in mm.
    is_trusted
        Whether the greatest error is at most the spacing, and at most a tenth of the largest displacement or a
        twentieth of the spacing.
    """

    greatest: float
    rms: float
    algebraic_greatest: float | None
    algebraic_rms: float | None
    discretization_greatest: float | None
    discretization_rms: float | None
    gaps_greatest: float = 0.0
    gaps_rms: float = 0.0
    landmarks: tuple[float, ...] = ()
    place: tuple[float, float, float] | None = None
    largest_displacement: float = 0.0
    is_trusted: bool = True


@dataclass(frozen=True, eq=False)
class RestSkin:
    """The skin's vertices, at which errors are estimated.

    Parameters
    ----------
    vertices
        Their indices in the epoch's surface, shape (s,).
    points
        Their rest points in mm, shape (s, 3).
    """

    vertices: NDArray[np.integer]
    points: NDArray[np.float64]

    @classmethod
    def of(cls, epoch: Epoch) -> RestSkin:
        """Take the skin of an epoch.

        Parameters
        ----------
        epoch
            The epoch.

        Returns
        -------
        RestSkin
            Its skin.
        """
        surface = epoch.surface
        vertices = np.unique(surface.triangles[surface.origin == FaceOrigin.SKIN])
        return cls(vertices, np.asarray(surface.points[vertices], float))


@dataclass(frozen=True)
class ErrorEstimate:
    """The estimate of a solve.

    Parameters
    ----------
    frames
        One per frame, None where there is none.
    spacing
        Spacing of the coarse program in mm.
    order
        Order of convergence that was reckoned with.
    seconds
        Time that the estimate took.
    reason
        Why frames lack the discretization part, or None.
    """

    frames: tuple[FrameErrorEstimate | None, ...]
    spacing: float
    order: float
    seconds: float
    reason: Problem | None = None


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
    if wounded:
        return WOUNDED_ORDER
    settings = program.settings
    whole = lattice is not None and lattice.fine_voxels == lattice.cells * settings.fine_ratio**3
    surfaces = [epoch.surface for epoch in program.epochs]
    held = any(np.any(each.fixed) or np.any(each.resting) for each in surfaces) or bool(program.retractors)
    # What does not draw in when it is pulled does so at no held edge.
    draws_in = any(each.poissons_ratio > 0.0 or each.fiber_k1 > 0.0 for each in settings.materials)
    smooth = whole and not (held and draws_in) and not len(program.bones.points)
    return FULL_ORDER if smooth else HELD_ORDER


def coarse_program(program: Program) -> Program:
    """Make the program on a lattice of `RATIO` times the spacing, with the same surfaces and constraints.

    Parameters
    ----------
    program
        The program.

    Returns
    -------
    Program
        The coarse program.
    """
    settings = program.settings
    sutured = bool(program.sutures)
    return replace(
        program,
        settings=replace(
            settings,
            spacing=RATIO * settings.spacing,
            quadrature=1 if sutured else settings.quadrature,
            precision="float",
            tolerance=max(settings.tolerance, SUTURED_TOLERANCE if sutured else COARSE_TOLERANCE),
            gap_tolerance=max(settings.gap_tolerance, SUTURED_GAP if sutured else COARSE_GAP),
            strain=False,
        ),
    )


def far_coarse_program(program: Program) -> Program | None:
    """Make the program of the second indicator.

    Parameters
    ----------
    program
        The program.

    Returns
    -------
    Program | None
        The program, or None where the estimate does without.
    """
    if program.settings.quadrature != 1 or expected_order(program) == WOUNDED_ORDER:
        return None
    near = coarse_program(program)
    spacing = FAR_RATIO * program.settings.spacing
    return replace(near, settings=replace(near.settings, spacing=spacing, quadrature=FAR_QUADRATURE))


def coarse_programs(program: Program) -> tuple[Program, ...]:
    """List all programs that the estimate solves besides.

    Parameters
    ----------
    program
        The program.

    Returns
    -------
    tuple[Program, ...]
        The programs.
    """
    far = far_coarse_program(program)
    return (coarse_program(program),) if far is None else (coarse_program(program), far)


def estimate_errors(
    program: Program,
    frames: Sequence[FrameResult],
    store: FrameStore,
    connect: Connect,
    solver: str,
    watch: SolveObserver | None = None,
) -> ErrorEstimate:
    """Estimate the errors of solved frames.

    The coarse programs' frames are looked up in and kept in the store like any others. Ctrl-C ends the coarse program
    and leaves the rest of the frames without their discretization part. Without its second indicator a frame has the
    first alone.

    Parameters
    ----------
    program
        The program.
    frames
        Solved frames, the first ones in order.
    store
        Where frames are kept.
    connect
        Makes the solver.
    solver
        What identifies it.
    watch
        Is told how the coarse solves go.

    Returns
    -------
    ErrorEstimate
        The estimate.
    """
    begun = time.perf_counter()
    known = replace(program, frames=program.frames[: len(frames)])
    partner, other = coarse_program(known), far_coarse_program(known)
    solved = solve_program(partner, store, connect, solver, watch or SolveObserver())
    far: Sequence[FrameResult] = ()
    if other is not None and not solved.interrupted:
        far = solve_program(other, store, connect, solver, watch or SolveObserver()).frames
    order = expected_order(program, frames[0].solved.lattice if frames else None)
    skins = {epoch.index: RestSkin.of(epoch) for epoch in program.epochs}
    spacing = program.settings.spacing
    errors = [
        frame_error(
            frame.solved,
            _at(solved.frames, index),
            skins[frame.constraints.epoch],
            order,
            spacing,
            _at(far, index),
        )
        for index, frame in enumerate(frames)
    ]
    reason = None
    if len(solved.frames) < len(frames):
        at = partner.settings.spacing
        reason = problem(ProblemCode.ESTIMATE_MISSING, "", f"{at:g}", spacing=at, said=solved.reason)
    return ErrorEstimate(tuple(errors), partner.settings.spacing, order, time.perf_counter() - begun, reason)


def frame_error(
    frame: SolvedFrame,
    coarse: SolvedFrame | None,
    skin: RestSkin,
    order: float,
    spacing: float,
    far: SolvedFrame | None = None,
) -> FrameErrorEstimate | None:
    """Estimate the error of one frame.

    Parameters
    ----------
    frame
        The frame.
    coarse
        The same frame of the coarse program, or None.
    skin
        The skin of the frame's epoch.
    order
        Order of convergence to reckon with.
    spacing
        Lattice spacing of the frame in mm.
    far
        The same frame of the far coarse program, or None.

    Returns
    -------
    FrameErrorEstimate | None
        The estimate, or None where no part can be had.
    """
    algebraic = _left_over(frame, "correction", skin.vertices)
    if algebraic is None and coarse is None:
        return None
    where = (("points", "correction", skin.vertices), ("landmarks", "landmark_correction", slice(None)))
    at_skin, at_marks = (_parts(frame, coarse, far, order, *names) for names in where)
    left, near = _lengths(at_skin.left), _lengths(at_skin.near)
    # The greatest and the root mean square are each held against their own.
    share, rms_share = (_mean(norm(_lengths(at_skin.far)), norm(near)) for norm in (_greatest, _rms))
    total = left + share * near
    gaps = np.abs(frame.suture_gaps)
    gap, gap_rms = max(frame.diagnostics.largest_gap, _greatest(gaps)), _rms(gaps)
    greatest = _greatest(total) + gap
    displacement = _greatest(_lengths(frame.points[skin.vertices] - skin.points))
    marks = [_mean(f, n) for f, n in zip(_lengths(at_marks.far), _lengths(at_marks.near), strict=True)]
    landmarks = _lengths(at_marks.left) + np.array(marks) * _lengths(at_marks.near)
    return FrameErrorEstimate(
        greatest,
        _rms(left + rms_share * near) + gap_rms,
        algebraic_greatest=None if algebraic is None else _greatest(left),
        algebraic_rms=None if algebraic is None else _rms(left),
        discretization_greatest=None if coarse is None else share * _greatest(near),
        discretization_rms=None if coarse is None else rms_share * _rms(near),
        gaps_greatest=gap,
        gaps_rms=gap_rms,
        landmarks=tuple(float(length) for length in landmarks),
        place=_point(skin.points[np.argmax(total)]) if len(total) else None,
        largest_displacement=displacement,
        is_trusted=greatest <= min(spacing, max(TRUSTED_SHARE * displacement, LEAST_DOUBTED * spacing)),
    )


class _Parts(NamedTuple):
    """Displacements that are left at n places, each of shape (n, 3), in mm.

    To the equilibrium of the lattice; from there to the truth, by the coarse program (0 without one) and by the far one
    (as `near` without one).
    """

    left: NDArray[np.float64]
    near: NDArray[np.float64]
    far: NDArray[np.float64]


def _parts(
    frame: SolvedFrame,
    coarse: SolvedFrame | None,
    far: SolvedFrame | None,
    order: float,
    name: str,
    left_over: str,
    places: NDArray[np.integer] | slice,
) -> _Parts:
    def equilibrium(of: SolvedFrame) -> NDArray[np.float64]:
        found = np.asarray(getattr(of, name)[places], float)
        left = _left_over(of, left_over, places)
        return found if left is None else found + left

    here = equilibrium(frame)
    left = here - getattr(frame, name)[places]
    if coarse is None or getattr(coarse, name).shape != getattr(frame, name).shape:
        return _Parts(left, np.zeros_like(here), np.zeros_like(here))
    near = (here - equilibrium(coarse)) / (RATIO**order - 1.0)
    if far is None or getattr(far, name).shape != getattr(frame, name).shape:
        return _Parts(left, near, near)
    return _Parts(left, near, ONE_POINT_SHARE * (here - equilibrium(far)))


def _left_over(frame: SolvedFrame, name: str, places: NDArray[np.integer] | slice) -> NDArray[np.float64] | None:
    """The Newton step left over at these places, or None where the frame came without."""
    step: NDArray[Any] = getattr(frame, name)
    return np.asarray(step[places], float) if len(step) else None


def _at(frames: Sequence[FrameResult], index: int) -> SolvedFrame | None:
    return frames[index].solved if index < len(frames) else None


def _mean(one: float, other: float) -> float:
    """What the second must be multiplied with to be the geometric mean of both."""
    return math.sqrt(one / other) if other > 0.0 else 1.0


def _lengths(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.linalg.norm(vectors, axis=1)


def _greatest(lengths: NDArray[np.float64]) -> float:
    return float(lengths.max(initial=0.0))


def _rms(lengths: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(lengths**2))) if len(lengths) else 0.0


def _point(point: NDArray[np.float64]) -> tuple[float, float, float]:
    return float(point[0]), float(point[1]), float(point[2])
