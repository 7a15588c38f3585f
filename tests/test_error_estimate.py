"""The estimate of the displacement error against errors that are known, and solves without it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lappet.daemon_solver import connect_to
from lappet.error_estimate import ErrorEstimate, FrameError, companion, expected_order, frame_error
from lappet.program import FaceOrigin
from lappet.reports.box_scenes import BAR, BLOCK, CANTILEVER, COOK, BoxScene
from lappet.reports.error_time import DEFAULT, EXACT, skin_of
from lappet.reports.reference import greatest, rms
from lappet.solve import FrameResult, Watcher, solve_procedure, solve_program
from lappet.store import FrameStore
from lappet.target_error import worst_rms
from small_procedure import small_procedure

SETTINGS: tuple[dict[str, Any], ...] = (
    {},
    {"tolerance": 1e-2},
    {"tolerance": 1e-4},
    {"quadrature": 8},
    {"precision": "double"},
    {"preconditioner": "chebyshev"},
)


def solve(scene: BoxScene, spacing: float, store: Path, **settings: Any) -> FrameResult:
    program = scene.program(spacing, **settings)
    found = solve_program(program, FrameStore(store), connect_to(None), "test", Watcher())
    assert found.reason is None
    return found.frames[-1]


@pytest.mark.slow
@pytest.mark.parametrize("scene", [BAR, BLOCK, CANTILEVER, COOK], ids=lambda scene: scene.name)
def test_the_estimate_lies_within_a_factor_of_three_of_the_true_error_at_every_setting(
    scene: BoxScene, tmp_path: Path
) -> None:
    # The truth: a spacing of a third to a quarter, whose own error is small beside that of the solves it is held
    # against.
    spacing = {"bar": 2.0, "block": 2.0, "cantilever": 3.0, "cook": 2.0}[scene.name]
    truth = solve(scene, spacing / 4.0, tmp_path, **{**EXACT, "tolerance": 1e-5}).arrays["points"]
    for changed in SETTINGS:
        settings = {**DEFAULT, **changed, "correction": True}
        program = scene.program(spacing, **settings)
        skin = skin_of(program)
        frame = solve(scene, spacing, tmp_path, **settings)
        found = solve_program(companion(program), FrameStore(tmp_path), connect_to(None), "test", Watcher())
        estimate = frame_error(frame, found.frames[-1], skin, expected_order(program))
        assert estimate is not None
        off = frame.arrays["points"][skin].astype(float) - truth[skin]
        assert rms(off) / 3.0 < estimate.rms < 3.0 * rms(off), (changed, rms(off), estimate.rms)
        assert greatest(off) / 3.0 < estimate.greatest < 3.0 * greatest(off), (
            changed,
            greatest(off),
            estimate.greatest,
        )


@pytest.mark.slow
def test_the_newton_step_left_over_is_the_error_of_stopping_early(tmp_path: Path) -> None:
    exact = solve(BLOCK, 2.0, tmp_path, **{**EXACT, "tolerance": 1e-9}).arrays["points"].astype(float)
    for tolerance in (1e-2, 1e-3, 1e-4):
        early = solve(BLOCK, 2.0, tmp_path, **{**EXACT, "tolerance": tolerance, "correction": True})
        off = rms(early.arrays["points"] - exact)
        # Single precision of the points limits what can be seen.
        assert rms(early.arrays["correction"]) == pytest.approx(off, rel=0.6, abs=1e-6)


@pytest.mark.slow
def test_every_solve_estimates_its_error_and_one_without_the_estimate_solves_nothing_more(tmp_path: Path) -> None:
    procedure = small_procedure()
    with_it = solve_procedure(procedure, tmp_path / "a.usdc", store=FrameStore(tmp_path / "a"))
    without = solve_procedure(procedure, tmp_path / "b.usdc", store=FrameStore(tmp_path / "b"), error_estimate=False)
    assert without.errors is None
    assert all(len(frame.arrays["correction"]) == 0 for frame in without.frames)
    errors = with_it.errors
    assert errors is not None
    assert errors.spacing == 2.0 * with_it.program.settings.spacing
    assert errors.reason is None
    assert len(errors.frames) == len(with_it.frames)
    # Nothing has moved before the slit is pulled open.
    first, last = errors.frames[0], errors.frames[-1]
    assert first is not None
    assert last is not None
    assert first.greatest < 1e-6
    assert 0.0 < last.rms <= last.greatest
    assert len(last.landmarks) == 1
    # The frames themselves are the same bits.
    for one, other in zip(with_it.frames, without.frames, strict=True):
        np.testing.assert_array_equal(one.arrays["points"], other.arrays["points"])
        assert one.key == other.key


def test_a_frame_that_the_companion_lacks_keeps_its_algebraic_part() -> None:
    frame = FrameResult(
        None,  # type: ignore[arg-type]
        "",
        {},
        {
            "points": np.zeros((2, 3), np.float32),
            "landmarks": np.zeros((0, 3)),
            "correction": np.array([[3.0, 0.0, 0.0], [0.0, 4.0, 0.0]], np.float32),
        },
        False,
        0.0,
    )
    error = frame_error(frame, None, np.array([0, 1]), 1.0)
    assert error is not None
    assert error.greatest == 4.0
    assert error.rms == pytest.approx(np.sqrt(12.5))
    assert error.discretization_rms is None
    bare = replace(frame, arrays={**frame.arrays, "correction": np.zeros((0, 3), np.float32)})
    assert frame_error(bare, None, np.array([0, 1]), 1.0) is None


def test_the_two_parts_add_in_squares_and_the_discretization_part_is_richardsons() -> None:
    arrays = {"points": np.array([[1.0, 0.0, 0.0]]), "landmarks": np.zeros((0, 3))}
    fine = FrameResult(None, "", {}, {**arrays, "correction": np.array([[0.0, 0.4, 0.0]])}, False, 0.0)  # type: ignore[arg-type]
    coarse = FrameResult(None, "", {}, {**arrays, "points": np.array([[0.1, 0.0, 0.0]])}, False, 0.0)  # type: ignore[arg-type]
    error = frame_error(fine, coarse, np.array([0]), 2.0)
    assert error is not None
    assert error.discretization_rms == pytest.approx(0.9 / 3.0)
    assert error.rms == pytest.approx(0.5)


def test_wounds_hooks_and_sutures_lower_the_order_that_is_reckoned_with() -> None:
    smooth = BLOCK.program(4.0)
    assert expected_order(smooth) > 1.0
    epoch = smooth.epochs[0]
    walls = epoch.surface.origin.copy()
    walls[0] = FaceOrigin.WOUND_WALL
    cut = replace(smooth, epochs=(replace(epoch, surface=replace(epoch.surface, origin=walls)),))
    assert expected_order(cut) < expected_order(smooth)
    assert expected_order(replace(smooth, hooks=("hook",))) < expected_order(smooth)


def test_an_unknown_frame_makes_the_worst_error_infinite() -> None:
    known = FrameError(0.2, 0.1, None, None, 0.2, 0.1)
    assert worst_rms(ErrorEstimate((known,), 2.0, 1.0, 0.0)) == 0.1
    assert worst_rms(ErrorEstimate((known, None), 2.0, 1.0, 0.0, "why")) == float("inf")
