"""The errors of forces and of the measures of seams, against what converges as it is known to."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from lappet.daemon.solved_frame import SolvedFrame
from lappet.output.solve_to_cache import SolveResult, solve_procedure
from lappet.procedure import Hook, Incision, Procedure, Suture, Undermine
from lappet.solve.error_estimate import FrameErrorEstimate, RestSkin
from lappet.solve.force_sums import force_sums
from lappet.solve.hook_forces import HookForce
from lappet.solve.mean_tension import MeanTension
from lappet.solve.measure_errors import Reckoning, with_errors
from lappet.solve.measures import FrameMeasures
from lappet.solve.seam_measures import SeamMeasure, SeamState
from lappet.solve.seams import SAMPLES
from lappet.solve.store import FrameStore
from lappet.solve.suture_forces import SutureForce
from small_procedure import TOP, small_procedure

ORDER = 1.25
ERRORS = [item.name for item in fields(SeamMeasure) if "_error_" in item.name]


def suture(name: str, force: float, *, resolved: bool = True) -> SutureForce:
    closure = name.rpartition("_")[0]
    return SutureForce(1.0, name, closure, 0.0, force, 0.0, force, 0.0, 0.1, 0.5, 5000.0, resolved, force, force)


def seam(*, gap: float = 0.2, shift: float = 0.0, length: float = 20.0, ear: float = 0.5) -> SeamState:
    """A straight seam, of which one place gapes more than the others; its line is shifted aside."""
    along = np.linspace(0.0, length, SAMPLES)
    points = np.stack([along, np.full(SAMPLES, shift), np.zeros(SAMPLES)], axis=1)
    gaps = np.full(SAMPLES, 0.1)
    gaps[20] = gap
    measure = SeamMeasure(
        1.0, "top", length, length, length, length, length, 0.0, gap, 1.0, 1.0, 0.3, 0.1, ear, None, 100.0, 0.005
    )
    return SeamState(measure, ("top",), points, gaps, np.full(SAMPLES, 0.1), np.full(SAMPLES, 0.3))


def test_the_share_of_displacements_that_is_not_known_is_that_of_what_moves() -> None:
    skin = RestSkin(np.arange(2), np.zeros((2, 3)))
    frame = SolvedFrame(1.0, np.array([[3.0, 0.0, 0.0], [0.0, 4.0, 0.0]], np.float32))
    error = FrameErrorEstimate(0.9, 0.5, 0.2, 0.1, 0.7, 0.4)
    found = Reckoning.of(frame, frame, error, skin, ORDER)
    assert found.relative == pytest.approx(0.5 / math.sqrt(12.5))
    assert found.algebraic == pytest.approx(0.1 / math.sqrt(12.5))
    assert (found.order, found.left) == (ORDER, 0.2)
    still = replace(frame, points=np.zeros((2, 3), np.float32))
    assert Reckoning.of(still, still, error, skin, ORDER).relative == 1.0
    assert Reckoning.of(still, still, replace(error, rms=0.0), skin, ORDER).relative == 0.0


def test_the_tension_is_compared_over_the_whole_skin() -> None:
    skin = RestSkin(np.arange(2), np.zeros((2, 3)))
    error = FrameErrorEstimate(0.9, 0.5, 0.2, 0.1, 0.7, 0.4)
    points = np.ones((3, 3), np.float32)
    tensions = [np.array(each, np.float32) for each in ([3.0, 4.0, 100.0], [3.0, 3.0, 0.0], [])]
    frame, coarse, unknown = (SolvedFrame(1.0, points, tension=each) for each in tensions)
    # The third vertex is not of the skin.
    assert Reckoning.of(frame, coarse, error, skin, ORDER).tension == pytest.approx(1.0 / 5.0)
    assert Reckoning.of(frame, frame, error, skin, ORDER).tension == 0.0
    assert Reckoning.of(frame, unknown, error, skin, ORDER).tension == 0.0
    assert Reckoning.of(unknown, coarse, error, skin, ORDER).tension == 0.0


@pytest.mark.parametrize("stiffening", [0.02, -0.03, 0.3])
def test_the_error_of_a_force_that_converges_as_the_displacements_do_is_its_own(stiffening: float) -> None:
    truth, h = 50.0, 1.0
    force, coarse = (truth * math.exp(stiffening * each**ORDER) for each in (h, 2.0 * h))
    relative = abs(1.0 - math.exp(-abs(stiffening) * h**ORDER))  # what the displacements say too
    found = Reckoning(ORDER, relative, 0.0, 0.0).force(force, coarse)
    assert found == pytest.approx(abs(force - truth), rel=0.05 if abs(stiffening) < 0.1 else 0.35)


def test_forces_that_agree_by_chance_have_the_error_of_the_displacements_and_a_locked_one_at_most_itself() -> None:
    reckoning = Reckoning(ORDER, 0.2, 0.0, 0.0)
    assert reckoning.force(100.0, 100.0) == pytest.approx(20.0)
    assert reckoning.force(100.0, 1e6) == pytest.approx(100.0 * math.sqrt(0.2), rel=1e-3)
    assert reckoning.force(100.0, 1e6) > reckoning.force(100.0, 120.0) >= 20.0
    assert replace(reckoning, relative=1.0).force(100.0, 1e6) == pytest.approx(100.0)
    # A thread that is slack here and taut there.
    assert reckoning.force(0.0, 30.0) == pytest.approx(30.0 / (2.0**ORDER - 1.0))
    assert reckoning.force(0.0, 0.0) == 0.0


def measures(factor: float, *lost: str, state: SeamState | None = None, tension: float = 20.0) -> FrameMeasures:
    """Forces that are a factor greater than others, without those that the lattice does not resolve."""
    forces = {"top_1": 10.0, "top_2": 40.0, "deep_1": 50.0}
    rows = tuple(suture(name, factor * force, resolved=name not in lost) for name, force in forces.items())
    seams = (state or seam(),)
    hooks = (HookForce(1.0, "hook", 30.0 * factor, 0.0, 0.0, 30.0 * factor),)
    where = MeanTension(tension, (0.0, 0.0, 0.0), 25.0)
    return FrameMeasures(rows, force_sums(rows, seams), hooks, seams, where)


def test_sums_and_closures_have_the_relative_errors_of_what_both_lattices_resolve() -> None:
    reckoning = Reckoning(ORDER, 0.1, 0.0, 0.0)
    found = with_errors(measures(1.0, "deep_1"), measures(1.3, "top_1"), reckoning)
    share = reckoning.of_ratio(1.3)
    assert [row.force_error_mn for row in found.sutures] == [
        pytest.approx(10.0 * share),  # with the ratio of its closure: the coarse lattice does not resolve it
        pytest.approx(40.0 * share),
        None,  # meaningless
    ]
    sums = found.sums
    assert sums is not None
    assert sums.total_error_mn == pytest.approx(50.0 * share)
    assert sums.greatest_error_mn == pytest.approx(40.0 * share)
    (top,) = sums.closures
    assert top.total_error_mn == pytest.approx(50.0 * share)
    assert top.force_error_mn == pytest.approx((10.0 * share, 40.0 * share))
    assert top.tension_n_per_mm is not None
    assert top.tension_error_n_per_mm == pytest.approx(top.tension_n_per_mm * share)  # the scar's length is the same
    assert found.hooks[0].force_error_mn == pytest.approx(30.0 * share)


def test_where_the_coarse_lattice_resolves_no_suture_the_displacements_tell() -> None:
    found = with_errors(measures(1.0), measures(3.0, "top_1", "top_2", "deep_1"), Reckoning(ORDER, 0.1, 0.0, 0.0))
    assert found.sums is not None
    assert found.sums.total_error_mn == pytest.approx(20.0)
    assert [row.force_error_mn for row in found.sutures] == pytest.approx([2.0, 8.0, 10.0])


def test_a_seam_is_compared_place_by_place() -> None:
    reckoning = Reckoning(ORDER, 0.0, 0.0, 0.0)
    moved = seam(gap=0.2)
    gaps = moved.gap.copy()
    gaps[20], gaps[40] = gaps[40], gaps[20]  # as wide at most, but elsewhere
    coarse = replace(measures(1.0), seams=(replace(moved, gap=gaps),))
    found = with_errors(measures(1.0), coarse, reckoning).seams[0].measure
    first = 2.0**ORDER - 1.0
    assert found.greatest_gap_error_mm == pytest.approx(0.1 / first)
    assert found.open_area_error_mm2 == pytest.approx(2 * 0.1 / first * 20.0 / (SAMPLES - 1))
    assert found.step_off_error_mm == found.edge_mismatch_error_mm == 0.0


def test_how_lips_lie_to_each_other_is_compared_where_they_meet() -> None:
    fine = seam(gap=2.0)  # at one place they do not
    assert np.flatnonzero(~fine.meets).tolist() == [20]
    step, mismatch = fine.step.copy(), fine.mismatch.copy()
    step[20], mismatch[20] = 3.0, -3.0
    step[30], mismatch[40] = 0.2, 0.5
    coarse = replace(measures(1.0), seams=(replace(fine, step=step, mismatch=mismatch),))
    found = with_errors(measures(1.0, state=fine), coarse, Reckoning(ORDER, 0.0, 0.0, 0.0)).seams[0].measure
    assert found.step_off_error_mm == pytest.approx(0.1 / (2.0**ORDER - 1.0))
    assert found.edge_mismatch_error_mm == pytest.approx(0.2 / (2.0**ORDER - 1.0))


def test_a_scar_may_be_off_as_far_as_its_line_is_and_a_dog_ear_no_less_than_displacements_are() -> None:
    reckoning = Reckoning(ORDER, 0.1, 0.0, 0.0)
    fine = measures(1.0, state=seam(ear=0.5))
    found = with_errors(fine, measures(1.0, state=seam(shift=0.3, ear=0.7)), reckoning).seams[0].measure
    assert found.scar_length_error_mm == pytest.approx(0.3 / (2.0**2 - 1.0))
    assert found.start_dog_ear_error_mm == pytest.approx(0.2 / (2.0**2 - 1.0))
    assert found.end_dog_ear_error_mm is None
    alike = with_errors(fine, measures(1.0, state=seam(ear=0.5)), reckoning).seams[0].measure
    assert alike.start_dog_ear_error_mm == pytest.approx(0.05)


def test_the_tension_converges_with_order_1() -> None:
    fine, coarse = measures(1.0, tension=20.0), measures(1.0, tension=17.0)
    tension = with_errors(fine, coarse, Reckoning(ORDER, 0.1, 0.05, 0.0)).mean_tension
    assert tension is not None
    assert tension.error == pytest.approx(3.0 + 0.05 * 20.0)
    # The greatest tensions may agree by chance: no less than what the skin's as a whole differs by is not known.
    alike = with_errors(fine, measures(1.0, tension=20.0), Reckoning(ORDER, 0.1, 0.0, 0.0, 0.3)).mean_tension
    assert alike is not None
    assert alike.error == pytest.approx(0.3 * 20.0)


def test_what_is_still_to_come_is_added_to_every_length() -> None:
    exact, early = (
        with_errors(measures(1.0), measures(1.0), Reckoning(ORDER, 0.1, 0.0, left)).seams[0].measure
        for left in (0.0, 0.02)
    )
    for name in ("scar_length_error_mm", "greatest_gap_error_mm", "edge_mismatch_error_mm", "step_off_error_mm"):
        assert getattr(early, name) == pytest.approx(getattr(exact, name) + 0.04)
    assert early.open_area_error_mm2 == pytest.approx((exact.open_area_error_mm2 or 0.0) + 0.04 * 20.0)
    assert early.start_dog_ear_error_mm == pytest.approx((exact.start_dog_ear_error_mm or 0.0) + 0.02)


@pytest.mark.slow
def test_every_force_and_measure_of_a_solve_has_an_error_and_none_without_the_estimate(tmp_path: Path) -> None:
    procedure = sewn()
    with_it = solve_procedure(procedure, tmp_path / "a.usdc", store=FrameStore(tmp_path / "a"))
    without = solve_procedure(procedure, tmp_path / "b.usdc", store=FrameStore(tmp_path / "b"), error_estimate=False)
    assert with_it.errors is not None
    assert with_it.errors.coarse == ()  # not kept
    for force, error in forces(with_it):
        assert error is not None
        assert 0.0 < error <= max(force, 1e-3)
    last = with_it.seams[-1]
    missing = {"start_dog_ear_error_mm", "end_dog_ear_error_mm"}  # the rim is near
    assert {name for name in ERRORS if getattr(last, name) is None} <= missing
    assert with_it.measures[-1].mean_tension is not None
    assert with_it.measures[-1].mean_tension.error is not None
    assert len(without.suture_forces) == len(with_it.suture_forces) > 0
    assert {error for _, error in forces(without)} == {None}
    assert all(getattr(row, name) is None for row in without.seams for name in ERRORS)
    assert without.measures[-1].sums is not None
    assert without.measures[-1].sums.total_error_mn is None


def forces(result: SolveResult) -> list[tuple[float, float | None]]:
    """The forces of sutures and hooks with their errors."""
    sutures = [(row.force_mn, row.force_error_mn) for row in result.suture_forces]
    return sutures + [(row.force_mn, row.force_error_mn) for row in result.hook_forces]


def sewn() -> Procedure:
    """A slit of the small procedure that a hook draws open, sewn twice."""
    slit = Incision("slit", 3.0, ((-6.0, 0.0, TOP), (6.0, 0.0, TOP)), kerf=0.1)
    around = Undermine("freed", 3.0, ((-8.0, -6.0, TOP), (8.0, -6.0, TOP), (8.0, 6.0, TOP), (-8.0, 6.0, TOP)))
    target = ((4.0, (0.0, 4.0, TOP)), (6.0, (0.0, 5.5, TOP + 1.0)))
    hook = Hook("hook", (0.0, 4.0, TOP), target, 4.0, 9.0, 100.0)
    sutures = [Suture(f"stitch_{k}", ((x, -0.6, TOP), (x, 0.6, TOP)), 5.0) for k, x in enumerate((-3.0, 3.0))]
    return small_procedure(events=(slit, around, hook, *sutures))
