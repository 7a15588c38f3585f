"""`lappet report error-estimate`: the hold-out set of the estimated error."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from lappet.commands.cli import cli
from lappet.daemon.daemon_solver import connect_to
from lappet.reports.error_estimate.files import fitted_totals, totals, value_totals, write_error_estimate
from lappet.reports.error_estimate.fit_orders import fit_orders
from lappet.reports.error_estimate.fitting_scenes import fitting_scenes
from lappet.reports.error_estimate.hold_out_scenes import hold_out_scenes
from lappet.reports.error_estimate.measured_values import ValueRow, groups_of
from lappet.reports.error_estimate.measurement import EXACT, EstimateRow, measure_scene
from lappet.reports.error_estimate.run import chosen_scenes
from lappet.solve.solve_frames import SolveObserver, solve_program
from lappet.solve.store import FrameStore

OPERATIONS = {"hanging-flap", "rotation-flap", "v-y", "dome-flap", "layered-closure", "released-hook"}
TISSUES = {"stiff-fibers", "soft-fibers", "muscle-bar", "strip-over-bone", "punch"}
ROW = EstimateRow(
    "punch", 2.0, 300, 1, 0.1, 0.4, 0.2, 0.5, 2.0, 1.25, 1.0, 1.0, is_trusted=True, uncertainty_mm=0.01,
    uncertainty_max_mm=0.02, reference_order=1.2,
)  # fmt: skip


def test_the_hold_out_set_has_the_operations_and_tissues_that_it_must_and_none_was_fitted_on() -> None:
    held_out, fitted = hold_out_scenes(), fitting_scenes()
    names = {scene.name for scene in held_out}
    assert len(names) == len(held_out) >= 12
    assert names >= OPERATIONS | TISSUES
    assert not names & {scene.name for scene in fitted}
    for scene in held_out:
        assert len(scene.spacings) >= 3
        assert scene.reference[-1] <= min(scene.spacings) / 4.0, scene.name
        assert scene.reference == tuple(scene.reference[0] / 2**k for k in range(3))


def test_the_surface_of_a_scene_is_the_same_at_every_spacing() -> None:
    (scene,) = chosen_scenes(["hanging-flap"])
    coarse, fine = scene.program(2.0), scene.program(0.5, tolerance=1e-5)
    assert coarse.epochs is fine.epochs
    assert (fine.settings.spacing, fine.settings.tolerance) == (0.5, 1e-5)
    assert fine.settings.gravity == coarse.settings.gravity == scene.gravity


def test_the_finest_reference_of_an_operation_with_sutures_takes_the_iterations_of_any_frame(tmp_path: Path) -> None:
    """Its preconditioner has three levels, and on the second a bound that was guessed left it indefinite."""
    (scene,) = chosen_scenes(["rotation-flap"])
    program = scene.program(scene.reference[-1], **EXACT)
    program = replace(program, frames=program.frames[:4])
    frames = solve_program(program, FrameStore(tmp_path), connect_to(None), "test", SolveObserver()).frames
    assert [each.solved.converged for each in frames] == [True] * 4
    assert frames[-1].solved.diagnostics.load_steps == 1
    assert frames[-1].solved.diagnostics.newton <= 15


@pytest.mark.slow
@pytest.mark.parametrize("name", ["stiff-fibers", "muscle-bar", "strip-over-bone"])
def test_the_estimate_of_a_scene_that_it_was_not_fitted_on_lies_within_a_factor_of_three(
    name: str, tmp_path: Path
) -> None:
    (scene,) = chosen_scenes([name])
    scene = replace(scene, spacings=(2.0,), reference=(2.0, 1.0, 0.5))
    (row,) = measure_scene(scene, FrameStore(tmp_path), connect_to(None)).rows
    assert row.reason is None
    assert row.ratio is not None
    assert row.max_ratio is not None
    assert row.is_within, row


def test_the_totals_count_rows_outside_and_name_them_and_a_row_without_an_estimate_is_outside() -> None:
    low = replace(ROW, spacing_mm=1.5, ratio=0.2, max_ratio=0.5)
    unjudged = replace(ROW, spacing_mm=1.0, ratio=None, max_ratio=None)
    failed = replace(unjudged, spacing_mm=0.5, reason="The daemon died.")
    assert [row.is_within for row in (ROW, low, unjudged, failed)] == [True, False, True, False]
    assert [row.is_too_small for row in (ROW, low, unjudged, failed)] == [False, True, False, False]
    said = totals([ROW, low, unjudged, failed])
    assert said[0].startswith("1 of 3 rows (33%; 95% are asked for)")
    assert said[0].endswith("1 cannot be judged.")
    assert said[1].startswith("1 row ")
    assert said[2:] == [
        "Outside: punch at 1.5 mm, 0.2 and 0.5 times the true error.",
        "Outside: punch at 0.5 mm, The daemon died.",
    ]


def test_an_order_is_fitted_to_the_rows_that_were_reckoned_with_it() -> None:
    """Estimates that are (2^2 - 1) / (2^1 - 1) = 3 times too large were reckoned with order 1 where 2 is right."""
    rows = [replace(ROW, ratio=each, max_ratio=each) for each in (2.9, 3.0, 3.1)]
    rows += [replace(ROW, order=1.5, ratio=1.0, max_ratio=1.0), replace(ROW, order=1.5, ratio=None, max_ratio=None)]
    first, held = fit_orders(rows)
    assert (first.order, first.rows, first.within, first.within_best) == (1.0, 3, 2, 3)
    assert abs(first.best - 2.0) < 0.05
    assert (held.order, held.rows, held.within, held.within_best) == (1.5, 1, 1, 1)
    assert abs(held.best - 1.5) < 1e-9
    assert fitted_totals(rows)[1] == (
        "Order 1.5: 1 of 1 rows within, 0 below a third; with 1.5 most would be within: 1, 0 below a third."
    )


def test_the_files_hold_every_row(tmp_path: Path) -> None:
    machine = {"machine": {"processor": "a processor", "cores": 1, "memory_bytes": 1 << 30}}
    head = {**machine, "compiler": "a compiler", "isa": "sse42", "threads": 1, "revision": "abc", "date": "today"}
    rows = [ROW, replace(ROW, spacing_mm=1.0)]
    files = write_error_estimate(tmp_path, head, chosen_scenes(["punch"]), rows, VALUES)
    names = ["error_estimate.json", "error_estimate.csv", "error_estimate.md", "error_estimate_values.csv"]
    assert [file.name for file in files] == names
    values = json.loads(files[0].read_text())
    assert [row["spacing_mm"] for row in values["rows"]] == [2.0, 1.0]
    assert "punch" in values["scenes"]
    with files[1].open() as lines:
        assert len(list(csv.DictReader(lines))) == 2
    with files[3].open() as lines:
        assert [float(line["value"]) for line in csv.DictReader(lines)] == [row.value for row in VALUES]
    assert totals(rows)[0] in files[2].read_text()
    assert value_totals(VALUES)[0] in files[2].read_text()


def value(name: str, force: float, estimate: float | None, reference: float, uncertainty: float = 0.1) -> ValueRow:
    return ValueRow("v-y", 2.0, "suture force", name, "mN", force, estimate, reference, uncertainty)


VALUES = (value("a", 30.0, 4.0, 27.0), value("b", 50.0, 4.0, 46.0), value("c", 20.0, 9.0, 20.05))


def test_values_are_judged_as_groups_without_what_the_reference_does_not_know() -> None:
    (group,) = groups_of(VALUES)
    assert (group.count, group.error, group.error_max) == (2, pytest.approx(12.5**0.5), 4.0)
    assert group.ratios == pytest.approx((4.0 / 12.5**0.5, 1.0))
    assert group.is_within
    assert not group.is_too_small
    (low,) = groups_of([value("a", 30.0, 0.9, 27.0)])
    assert not low.is_within
    assert low.is_too_small
    (unknown,) = groups_of([*VALUES, value("d", 30.0, None, 27.0)])
    assert unknown.ratios == ()
    assert not unknown.is_within
    assert "1 of 1 groups (100%)" in value_totals(VALUES)[0]
    assert value_totals([]) == []


@pytest.mark.slow
def test_the_forces_of_a_closure_have_an_estimate_within_a_factor_of_three_at_1_mm(tmp_path: Path) -> None:
    (scene,) = chosen_scenes(["fusiform-closure"])
    scene = replace(scene, spacings=(1.0,), reference=(1.0, 0.5, 0.25))
    groups = {
        each.quantity: each for each in groups_of(measure_scene(scene, FrameStore(tmp_path), connect_to(None)).values)
    }
    assert groups["suture force"].count == 6
    for quantity in ("suture force", "sum of suture forces", "greatest suture force", "closing tension"):
        assert groups[quantity].is_within, groups[quantity]


def test_a_scene_that_is_not_there_is_refused_with_the_names_that_are() -> None:
    found = CliRunner().invoke(cli, ["report", "error-estimate", "nose"])
    assert found.exit_code == 1
    assert "'nose'" in found.output
    assert "rotation-flap" in found.output
