"""The estimate of a solve's displacement error: what the lattice costs and what stopping early costs, in mm.

- Algebraic: the displacement still to come at the end of a frame, K^-1 residual, which the daemon sends along.
- Discretization: the same frames are solved once more on a lattice of twice the spacing h that lies otherwise in the
  tissue (`coarse_program`). Where displacements converge as h^p, what is left at h is (u_h - u_2h) / (2^p - 1)
  (Richardson), each u with its own displacement still to come added.
- Gaps: what sutures and grips are open beyond what was asked for.

The parts add at each place by their lengths: a part may cancel another in one solve, but nothing says that it does, so
the total is never below a part. They are taken at the vertices of the skin and at the landmarks.
`lappet report error-estimate` holds the total against the true error of scenes that nothing here was fitted on.
"""

from __future__ import annotations

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
from lappet.daemon.solved_frame import SolvedFrame
from lappet.geometry.labeled_surface import FaceOrigin
from lappet.program.program import Program
from lappet.solve.coarse_program import RATIO, coarse_program, expected_order
from lappet.solve.other_branch import OtherBranch, other_branches
from lappet.solve.solve_frames import FrameResult, SolveObserver, solve_program
from lappet.solve.store import FrameStore

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
    other_branch
        The coarse solve's path leads to another equilibrium, so that the frame is one of several; the error is then
        that to the coarse equilibrium on the frame's own branch. None where that is not so.
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
    other_branch: OtherBranch | None = None


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
    coarse
        The frame of the coarse program that each is compared with, on the frame's own branch; None where there is none.
    """

    frames: tuple[FrameErrorEstimate | None, ...]
    spacing: float
    order: float
    seconds: float
    reason: Problem | None = None
    coarse: tuple[SolvedFrame | None, ...] = ()


def estimate_errors(
    program: Program,
    frames: Sequence[FrameResult],
    store: FrameStore,
    connect: Connect,
    solver: str,
    watch: SolveObserver | None = None,
) -> ErrorEstimate:
    """Estimate the errors of solved frames.

    The coarse program's frames are looked up in and kept in the store like any others. Ctrl-C ends the coarse program
    and leaves the rest of the frames without their discretization part.

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
    order = expected_order(program, frames[0].solved.lattice if frames else None)
    partner = coarse_program(known, order)
    solved = solve_program(partner, store, connect, solver, watch or SolveObserver())
    skins = {epoch.index: RestSkin.of(epoch) for epoch in program.epochs}
    spacing = program.settings.spacing
    compared = [_at(solved.frames, index) for index in range(len(frames))]
    errors = [
        frame_error(frame.solved, compared[index], skins[frame.constraints.epoch], order, spacing)
        for index, frame in enumerate(frames)
    ]
    # A coarse frame on another branch is no measure of the lattice: that on the frame's own branch is. Where tissue
    # touches itself there is none to be found, as the fine frame's shape passes through itself on the coarse lattice.
    doubted = {
        index: frames[index].solved
        for index, error in enumerate(errors)
        if error and not error.is_trusted and not frames[index].solved.diagnostics.self_contacts
    }
    coarse = {index: kept for index in doubted if (kept := _with_state(solved.frames, index, store)) is not None}
    for index, branch in other_branches(partner, doubted, coarse, connect).items():
        compared[index] = branch.frame
        skin = skins[frames[index].constraints.epoch]
        error = frame_error(doubted[index], branch.frame, skin, order, spacing)
        errors[index] = None if error is None else replace(error, other_branch=branch)
    reason = None
    if len(solved.frames) < len(frames):
        at = partner.settings.spacing
        reason = problem(ProblemCode.ESTIMATE_MISSING, "", f"{at:g}", spacing=at, said=solved.reason)
    seconds = time.perf_counter() - begun
    return ErrorEstimate(tuple(errors), partner.settings.spacing, order, seconds, reason, tuple(compared))


def frame_error(
    frame: SolvedFrame,
    coarse: SolvedFrame | None,
    skin: RestSkin,
    order: float,
    spacing: float,
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

    Returns
    -------
    FrameErrorEstimate | None
        The estimate, or None where no part can be had.
    """
    algebraic = _left_over(frame, "correction", skin.vertices)
    if algebraic is None and coarse is None:
        return None
    where = (("points", "correction", skin.vertices), ("landmarks", "landmark_correction", slice(None)))
    at_skin, at_marks = (_parts(frame, coarse, order, *names) for names in where)
    left, lattice = _lengths(at_skin.left), _lengths(at_skin.lattice)
    total = left + lattice
    gaps = np.abs(frame.suture_gaps)
    gap, gap_rms = max(frame.diagnostics.largest_gap, _greatest(gaps)), _rms(gaps)
    greatest = _greatest(total) + gap
    displacement = _greatest(_lengths(frame.points[skin.vertices] - skin.points))
    return FrameErrorEstimate(
        greatest,
        _rms(total) + gap_rms,
        algebraic_greatest=None if algebraic is None else _greatest(left),
        algebraic_rms=None if algebraic is None else _rms(left),
        discretization_greatest=None if coarse is None else _greatest(lattice),
        discretization_rms=None if coarse is None else _rms(lattice),
        gaps_greatest=gap,
        gaps_rms=gap_rms,
        landmarks=tuple(float(each) for each in _lengths(at_marks.left) + _lengths(at_marks.lattice)),
        place=_point(skin.points[np.argmax(total)]) if len(total) else None,
        largest_displacement=displacement,
        is_trusted=greatest <= min(spacing, max(TRUSTED_SHARE * displacement, LEAST_DOUBTED * spacing)),
    )


class _Parts(NamedTuple):
    """Displacements that are left at n places, each of shape (n, 3), in mm.

    To the equilibrium of the lattice; from there to the truth, 0 without a coarse program.
    """

    left: NDArray[np.float64]
    lattice: NDArray[np.float64]


def _parts(
    frame: SolvedFrame,
    coarse: SolvedFrame | None,
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
        return _Parts(left, np.zeros_like(here))
    return _Parts(left, (here - equilibrium(coarse)) / (RATIO**order - 1.0))


def _left_over(frame: SolvedFrame, name: str, places: NDArray[np.integer] | slice) -> NDArray[np.float64] | None:
    """The Newton step left over at these places, or None where the frame came without."""
    step: NDArray[Any] = getattr(frame, name)
    return np.asarray(step[places], float) if len(step) else None


def _with_state(frames: Sequence[FrameResult], index: int, store: FrameStore) -> SolvedFrame | None:
    """The frame as the store keeps it, or None where it is not there."""
    return store.get(frames[index].key, SolvedFrame) if index < len(frames) else None


def _at(frames: Sequence[FrameResult], index: int) -> SolvedFrame | None:
    return frames[index].solved if index < len(frames) else None


def _lengths(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.linalg.norm(vectors, axis=1)


def _greatest(lengths: NDArray[np.float64]) -> float:
    return float(lengths.max(initial=0.0))


def _rms(lengths: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.mean(lengths**2))) if len(lengths) else 0.0


def _point(point: NDArray[np.float64]) -> tuple[float, float, float]:
    return float(point[0]), float(point[1]), float(point[2])
