"""The estimated errors of what is measured at a frame: forces, tensions, and the measures of seams.

The coarse program (`lappet.solve.error_estimate`) has the same sutures, hooks and seams; what is measured there differs
by what the lattice costs:

- A force is the product of a stiffness and a displacement, so its error is relative. There are two indicators of it:
  where forces converge geometrically, ``F_h = F_0 exp(c h^p)``, the difference of the two is
  ``1 - exp(-|ln(F_2h / F_h)| / (2^p - 1))``; and what is not known of the displacements, the root mean square of their
  estimated error over that of the displacements. Either is too small by chance here and there, the first too large
  where cells of the coarse program hold several sutures. Their geometric mean is taken, or the second where that is
  larger. Where the coarse lattice resolves none of the sutures there is the second only, which is half of the error
  in the median (fitted).
- Gap, step-off, mismatch and open area are compared place by place along the seam, step-off and mismatch where its lips
  meet: the greatest of a line need not be in the same place on both lattices. They converge as displacements do.
- The length of a scar may be off by as much as its line is, which converges with order 2.
- A dog-ear, which lies away from the wound, is not known better than the displacements are; where the two lattices
  differ by more, with order 2.
- The greatest mean tensions of two lattices may agree by chance, but what the tension of the whole skin differs by is
  not known of the greatest either: the root mean square of the difference over that of the tension, with order 1.

These orders are fitted on `lappet.reports.error_estimate.fitting_scenes`.

What stopping early costs is added, as displacement still to come. Where a frame has no frame of the coarse program to
be compared with, nothing has an error.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from lappet.daemon.solved_frame import SolvedFrame
from lappet.program.program import Program
from lappet.solve.coarse_program import RATIO
from lappet.solve.error_estimate import ErrorEstimate, FrameErrorEstimate, RestSkin
from lappet.solve.force_sums import ClosureForces, ForceSums, force_sums
from lappet.solve.hook_forces import HookForce
from lappet.solve.mean_tension import MeanTension
from lappet.solve.measures import FrameMeasures, Gauges
from lappet.solve.seam_measures import SeamMeasure, SeamState
from lappet.solve.suture_forces import SutureForce

FORCE_ORDER, SHAPE_ORDER, TENSION_ORDER = 1.25, 2.0, 1.0
"""Orders of convergence (fitted): of forces, of the length of a scar and dog-ears, of the tension."""

ALONE = 2.0
"""Error of a force over that of the displacements, where there is nothing else to tell it by (fitted)."""


@dataclass(frozen=True)
class Reckoning:
    """What the errors of a frame are reckoned with.

    Parameters
    ----------
    order
        Order of convergence of the displacements.
    relative
        Root mean square error of the displacements over that of the displacements, at most 1; that of the lattice
        with the order of the forces.
    algebraic
        The part of it that stopping early has.
    left
        Greatest displacement still to come in mm.
    tension
        Root mean square difference of the skin's tension in the coarse program over that of the tension, at most 1.
    """

    order: float
    relative: float
    algebraic: float
    left: float
    tension: float = 0.0

    @classmethod
    def of(
        cls, frame: SolvedFrame, coarse: SolvedFrame, error: FrameErrorEstimate, skin: RestSkin, order: float
    ) -> Reckoning:
        """Take what there is for a frame.

        Parameters
        ----------
        frame
            The frame.
        coarse
            The frame of the coarse program.
        error
            Its estimated displacement error.
        skin
            The skin of its epoch.
        order
            Order of convergence of the displacements.

        Returns
        -------
        Reckoning
            What its errors are reckoned with.
        """
        moved = np.asarray(frame.points, np.float64)[skin.vertices] - skin.points
        size = float(np.sqrt(np.mean(np.einsum("ij,ij->i", moved, moved)))) if len(moved) else 0.0
        left, left_rms = error.algebraic_greatest or 0.0, error.algebraic_rms or 0.0
        lattice = error.discretization_rms or 0.0
        slower = (RATIO**order - 1.0) / (RATIO**FORCE_ORDER - 1.0)
        relative = _share(error.rms + lattice * (slower - 1.0), size)
        return cls(order, relative, _share(left_rms, size), left, _tension_apart(frame, coarse, skin))

    def force(self, force: float, coarse: float) -> float:
        """Estimate the error of a force.

        Parameters
        ----------
        force
            The force, at least 0.
        coarse
            The same in the coarse program.

        Returns
        -------
        float
            The error in the force's unit, at most the force itself unless that is 0.
        """
        if force <= 0.0:
            return coarse / (RATIO**FORCE_ORDER - 1.0)
        return force * self.of_ratio(coarse / force)

    def of_ratio(self, ratio: float | None) -> float:
        """Estimate the relative error of a force.

        Parameters
        ----------
        ratio
            The force in the coarse program over the force; None where the coarse lattice does not resolve it.

        Returns
        -------
        float
            The error over the force, 0 to 1.
        """
        if ratio is None:
            return min(1.0, ALONE * self.relative)
        apart = abs(math.log(ratio)) if ratio > 0.0 else math.inf
        found = 1.0 - math.exp(-apart / (RATIO**FORCE_ORDER - 1.0))
        return math.sqrt(self.relative * max(self.relative, found))


def errors_of_measures(
    program: Program,
    gauges: Gauges,
    frames: Sequence[SolvedFrame],
    measures: Sequence[FrameMeasures],
    errors: ErrorEstimate,
) -> list[FrameMeasures]:
    """Estimate the errors of what is measured at the frames of a solve.

    Parameters
    ----------
    program
        The program.
    gauges
        What measures its frames.
    frames
        Its frames.
    measures
        What is measured at each.
    errors
        The estimate of their displacement errors.

    Returns
    -------
    list[FrameMeasures]
        What is measured at each; without errors where there is no frame to compare with.
    """
    skins = {epoch.index: RestSkin.of(epoch) for epoch in program.epochs}
    epochs = {each.time: each.epoch for each in program.frames}
    found = []
    for frame, own, error, coarse in zip(frames, measures, errors.frames, errors.coarse, strict=True):
        if error is None or coarse is None:
            found.append(own)
            continue
        there = gauges.measure(coarse, tension=own.mean_tension is not None)
        found.append(
            with_errors(own, there, Reckoning.of(frame, coarse, error, skins[epochs[frame.time]], errors.order))
        )
    return found


def with_errors(fine: FrameMeasures, coarse: FrameMeasures, reckoning: Reckoning) -> FrameMeasures:
    """Estimate the errors of what is measured at a frame.

    Parameters
    ----------
    fine
        What is measured.
    coarse
        What is measured at the frame of the coarse program.
    reckoning
        What the errors are reckoned with.

    Returns
    -------
    FrameMeasures
        What is measured, with the errors.
    """
    there = {row.suture: row.force_mn for row in coarse.sutures if row.resolved}
    ratios = _Ratios(fine.sutures, there)
    sutures = tuple(replace(row, force_error_mn=_of_suture(row, there, ratios, reckoning)) for row in fine.sutures)
    pulls = {row.hook: row.force_mn for row in coarse.hooks}
    hooks = tuple(_of_hook(row, pulls, reckoning) for row in fine.hooks)
    places = {state.measure.seam: state for state in coarse.seams}
    seams = tuple(
        replace(state, measure=_of_seam(state, places[state.measure.seam], ratios, reckoning))
        if state.measure.seam in places
        else state
        for state in fine.seams
    )
    sums = None if fine.sums is None else _of_sums(force_sums(sutures, seams), seams, ratios, reckoning)
    return FrameMeasures(sutures, sums, hooks, seams, _of_tension(fine.mean_tension, coarse.mean_tension, reckoning))


class _Ratios:
    """The forces of the coarse program over those of the frame, summed over sutures that both resolve."""

    def __init__(self, rows: Sequence[SutureForce], there: Mapping[str, float]) -> None:
        self._rows = [row for row in rows if row.resolved and row.suture in there]
        self._there = there

    def of(self, closures: Sequence[str] | None = None) -> float | None:
        """The ratio over some closures; over all where None, or where no suture of these is resolved by both."""
        own = [row for row in self._rows if closures is None or row.closure in closures]
        force = sum(row.force_mn for row in own)
        if force > 0.0:
            return sum(self._there[row.suture] for row in own) / force
        return None if closures is None else self.of()


def _of_suture(row: SutureForce, there: Mapping[str, float], ratios: _Ratios, reckoning: Reckoning) -> float | None:
    """A suture that the coarse lattice does not resolve has the relative error of its closure."""
    if not row.resolved:
        return None
    if row.suture in there:
        return reckoning.force(row.force_mn, there[row.suture])
    return row.force_mn * reckoning.of_ratio(ratios.of([row.closure]))


def _of_hook(row: HookForce, pulls: Mapping[str, float], reckoning: Reckoning) -> HookForce:
    return replace(row, force_error_mn=reckoning.force(row.force_mn, pulls[row.hook])) if row.hook in pulls else row


def _of_sums(sums: ForceSums, seams: Sequence[SeamState], ratios: _Ratios, reckoning: Reckoning) -> ForceSums:
    scars = {closure: _relative_length(state.measure) for state in seams for closure in state.closures}
    closures = (_of_closure(each, reckoning.of_ratio(ratios.of([each.closure])), scars) for each in sums.closures)
    total = ratios.of()
    error = sums.total_mn * reckoning.of_ratio(total)
    return replace(sums, closures=tuple(closures), total_error_mn=error, coarse_share=total)


def _of_closure(closure: ClosureForces, relative: float, scars: Mapping[str, float]) -> ClosureForces:
    tension = closure.tension_n_per_mm
    return replace(
        closure,
        total_error_mn=closure.total_mn * relative,
        tension_error_n_per_mm=None if tension is None else tension * (relative + scars[closure.closure]),
    )


def _of_seam(state: SeamState, coarse: SeamState, ratios: _Ratios, reckoning: Reckoning) -> SeamMeasure:
    here, there = state.measure, coarse.measure
    left = 2.0 * reckoning.left  # either lip may still come so far
    gap, step, mismatch = (
        np.abs(getattr(state, name) - getattr(coarse, name)) / (RATIO**reckoning.order - 1.0)
        for name in ("gap", "step", "mismatch")
    )
    meets = state.meets
    steps = np.linalg.norm(np.diff(state.points, axis=0), axis=1)
    shares = 0.5 * (np.concatenate([[0.0], steps]) + np.concatenate([steps, [0.0]]))
    line = float(np.linalg.norm(state.points - coarse.points, axis=1).max()) / (RATIO**SHAPE_ORDER - 1.0)
    scar = line + left
    force = reckoning.of_ratio(ratios.of(state.closures))
    tension = None
    if here.tension_n_per_mm is not None:
        tension = here.tension_n_per_mm * (force + scar / max(here.scar_length_mm, 1e-300))
    return replace(
        here,
        scar_length_error_mm=scar,
        greatest_gap_error_mm=float(gap.max()) + left,
        open_area_error_mm2=float(shares @ gap) + left * here.scar_length_mm,
        edge_mismatch_error_mm=None if here.edge_mismatch_mm is None else float(mismatch[meets].max()) + left,
        step_off_error_mm=None if here.step_off_mm is None else float(step[meets].max()) + left,
        start_dog_ear_error_mm=_of_dog_ear(here.start_dog_ear_mm, there.start_dog_ear_mm, reckoning),
        end_dog_ear_error_mm=_of_dog_ear(here.end_dog_ear_mm, there.end_dog_ear_mm, reckoning),
        force_error_mn=here.force_mn * force,
        tension_error_n_per_mm=tension,
    )


def _of_dog_ear(here: float | None, there: float | None, reckoning: Reckoning) -> float | None:
    if here is None or there is None:
        return None
    return max(abs(here - there) / (RATIO**SHAPE_ORDER - 1.0), reckoning.relative * here) + reckoning.left


def _of_tension(here: MeanTension | None, there: MeanTension | None, reckoning: Reckoning) -> MeanTension | None:
    if here is None or there is None:
        return here
    size = abs(here.tension)
    apart = max(abs(here.tension - there.tension), reckoning.tension * size) / (RATIO**TENSION_ORDER - 1.0)
    return replace(here, error=apart + reckoning.algebraic * size)


def _tension_apart(frame: SolvedFrame, coarse: SolvedFrame, skin: RestSkin) -> float:
    """The difference of the tensions over the tension, root mean squares over the skin; 0 where they are not known."""
    if not len(frame.tension) or len(coarse.tension) != len(frame.tension):
        return 0.0
    here, there = (np.asarray(each.tension, np.float64)[skin.vertices] for each in (frame, coarse))
    apart, size = (float(np.sqrt(np.mean(each**2))) for each in (here - there, here))
    return _share(apart, size)


def _relative_length(measure: SeamMeasure) -> float:
    return (measure.scar_length_error_mm or 0.0) / max(measure.scar_length_mm, 1e-300)


def _share(error: float, size: float) -> float:
    return min(1.0, error / size) if size > 0.0 else float(error > 0.0)
