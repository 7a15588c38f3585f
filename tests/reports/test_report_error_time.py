"""`lappet report error-time` and `lappet solve --target-error`."""

from __future__ import annotations

import csv
import json
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from lappet.commands.cli import cli
from lappet.daemon.daemon_solver import connect_to
from lappet.geometry.mesh_faults import refuse_faults
from lappet.geometry.surface_check import signed_volume
from lappet.reports.box_scenes import (
    BAR,
    BLOCK,
    BOXES,
    CANTILEVER,
    CANTILEVER_SLACK,
    COOK,
    SHELF,
    BoxScene,
    grid_box,
)
from lappet.reports.clamped_edge import edge_exponent
from lappet.reports.error_time.files import markdown, write_error_time
from lappet.reports.error_time.measurement import (
    CHOICES,
    DEFAULT,
    EXACT,
    Convergence,
    Measure,
    SceneReport,
    combinations,
    error_time,
)
from lappet.reports.error_time.reference import Reference, fitted_order, observed_orders, richardson, rms
from lappet.reports.error_time.totals import totals
from lappet.solve.solve_frames import SolveObserver, solve_program
from lappet.solve.store import FrameStore
from lappet.usd.stage import write_procedure
from small_procedure import small_procedure


def test_richardson_finds_the_limit_and_the_order_of_a_regular_sequence() -> None:
    limit, slope = np.array([[1.0, 2.0, 3.0], [0.0, -1.0, 4.0]]), np.array([[0.3, -0.1, 0.2], [0.05, 0.4, 0.0]])
    for order in (1.0, 1.5, 2.0):
        found = richardson(*(limit + slope * h**order for h in (4.0, 2.0, 1.0)))
        np.testing.assert_allclose(found.points, limit, atol=1e-12)
        assert found.order == pytest.approx(order)
        assert found.uncertainty == pytest.approx(rms(slope))
        assert found.uncertainty_max == pytest.approx(np.linalg.norm(slope, axis=1).max())


def test_a_sequence_that_does_not_converge_is_as_uncertain_as_its_last_difference() -> None:
    ones = np.ones((3, 3))
    found = richardson(0.0 * ones, 1.0 * ones, -1.0 * ones)
    assert found.order < 0.0
    assert found.uncertainty >= rms(2.0 * ones)


def test_orders_are_those_of_a_power_law() -> None:
    spacings = (4.0, 2.0, 1.5, 1.0)
    errors = [0.01 * h**1.7 for h in spacings]
    np.testing.assert_allclose(observed_orders(spacings, errors), 1.7)
    assert fitted_order(spacings, errors) == pytest.approx(1.7)


def test_the_product_of_settings_is_complete_and_starts_with_the_default() -> None:
    everything = list(combinations(product=True))
    assert everything[0] == DEFAULT
    assert len(everything) == np.prod([len(values) for values in CHOICES.values()])
    assert len({tuple(each.values()) for each in everything}) == len(everything)
    alone = list(combinations(product=False))
    assert all(sum(each[name] != DEFAULT[name] for name in DEFAULT) <= 1 for each in alone)


@pytest.mark.parametrize("scene", BOXES, ids=lambda scene: scene.name)
def test_the_boxes_are_closed_and_their_halves_are_the_coarse_programs_of_others(scene: object) -> None:
    surface, side = grid_box((4.0, 3.0, 2.0), (4, 3, 2))
    refuse_faults("box", surface.points, surface.triangles)
    assert signed_volume(surface.points, surface.triangles) == pytest.approx(24.0)
    assert sorted(set(side)) == [0, 1, 2, 3, 4, 5]
    surface = scene.program(2.0).epochs[0].surface  # type: ignore[attr-defined]
    refuse_faults("scene", surface.points, surface.triangles)


@pytest.mark.slow
def test_a_smooth_solution_converges_with_second_order() -> None:
    found = []
    for spacing in (6.0, 3.0, 1.5):
        program = SHELF.program(spacing, **EXACT)
        with tempfile.TemporaryDirectory() as store:
            solved = solve_program(program, FrameStore(Path(store)), connect_to(None), "test", SolveObserver())
        found.append(solved.frames[-1].solved.points.astype(float))
    assert richardson(*found).order > 1.8


def test_the_exponent_at_a_clamped_edge_is_williams() -> None:
    # Square corners: 0.711 at a Poisson's ratio of 0.3 (Williams 1952), 1 without lateral contraction.
    assert edge_exponent(0.3) == pytest.approx(0.711, abs=2e-3)
    assert edge_exponent(0.0) == 1.0
    assert edge_exponent(0.45) == pytest.approx(0.622, abs=2e-3)
    assert edge_exponent(0.45, 60.0) > edge_exponent(0.45) > edge_exponent(0.45, 132.5) > 0.5
    assert COOK.edge_exponent == pytest.approx(0.528, abs=2e-3)
    assert SHELF.edge_exponent is None


def test_away_from_what_is_held_is_a_quarter_of_the_length() -> None:
    places = np.array([[11.9, 0.0, 0.0], [12.0, 0.0, 0.0], [36.0, 0.0, 0.0], [36.1, 0.0, 0.0]])
    assert CANTILEVER.away(places).tolist() == [False, True, True, True]
    assert BAR.away(places).tolist() == [False, True, True, False]


@pytest.mark.slow
def test_without_lateral_contraction_a_held_end_lowers_the_order_no_more() -> None:
    def order(scene: BoxScene, quadrature: int) -> float:
        found = []
        for spacing in (3.0, 1.5, 0.75):
            program = scene.program(spacing, **{**EXACT, "quadrature": quadrature})
            with tempfile.TemporaryDirectory() as store:
                solved = solve_program(program, FrameStore(Path(store)), connect_to(None), "test", SolveObserver())
            found.append(solved.frames[-1].solved.points.astype(float))
        return richardson(*found).order

    for quadrature in (1, 8):
        assert order(CANTILEVER_SLACK, quadrature) > 1.85
        assert order(CANTILEVER, quadrature) < 1.6


def test_totals_count_what_can_be_judged_and_name_what_lies_outside() -> None:
    row = Measure(
        "bar", 2.0, **DEFAULT, default=True, cells=1, frames=1, seconds=1.0, estimate_seconds=0.1, newton_iterations=1,
        pcg_iterations=1, error_mm=0.1, error_max_mm=0.2, estimate_mm=0.2, estimate_max_mm=0.7, within_3=True,
        max_within_3=False,
    )  # fmt: skip
    below = replace(row, within_3=None, max_within_3=None)
    reference = Reference(np.zeros((1, 3)), 1.5, 0.15, 0.3)
    curve = Convergence("shelf", 1, (2.0, 1.0), (0.1, 0.05), (1.0,), 1.0, (0.1, 0.05), 1.0)
    report = SceneReport(SHELF, reference, (row, below), (curve, replace(curve, quadrature=8, fitted=1.9)))
    said = totals([report]).splitlines()
    assert said[0].startswith("Root mean square: 1 of 1 estimates lie within a factor 3")
    assert said[1].startswith("Greatest: 0 of 1")
    assert "1 cannot be judged" in said[1]
    assert said[2].startswith("Outside: bar 2 mm")
    assert said[3] == "Order: 1 of 2 reach 1.8 where nothing lowers it; shelf at quadrature 1 1.00."
    head = {"machine": {"processor": "p", "cores": 1, "memory_bytes": 1 << 30}, "compiler": "c", "isa": "i"}
    text = markdown({**head, "threads": 1, "revision": "r", "date": "d"}, [report])
    assert "cannot be judged" in text
    assert said[2] in text


@pytest.mark.slow
def test_the_report_of_a_block_holds_what_others_need_to_plot_it(tmp_path: Path) -> None:
    scene = replace(BLOCK, spacings=(4.0, 2.0), reference=(4.0, 2.0, 1.0))
    report = error_time(scene, connect_to(None), product=False)
    assert report.reference.order > 0.5
    assert report.reference.uncertainty < report.reference.uncertainty_max
    default = [row for row in report.rows if row.default]
    assert all(row.within_3 for row in default)
    assert all(found.away_errors_mm is not None for found in report.convergence)
    assert [row.spacing_mm for row in default] == [4.0, 2.0]
    assert default[0].error_mm is not None
    assert default[1].error_mm is not None
    assert default[1].error_mm < default[0].error_mm  # finer is better
    machine = {"machine": {"processor": "a processor", "cores": 1, "memory_bytes": 1 << 30}}
    head = {**machine, "compiler": "a compiler", "isa": "sse42", "threads": 1, "revision": "abc", "date": "today"}
    files = write_error_time(tmp_path, head, [report])
    assert [file.suffix for file in files] == [".json", ".csv", ".md", ".png"]
    assert files[3].stat().st_size > 10_000
    values = json.loads(files[0].read_text())
    asked = {"scene", "spacing_mm", "quadrature", "tolerance", "precision", "preconditioner", "seconds", "error_mm"}
    assert all(asked | {"estimate_mm", "within_3", "max_within_3"} <= row.keys() for row in values["rows"])
    assert {"machine", "compiler", "isa", "threads", "revision"} <= values.keys()
    with files[1].open() as lines:
        assert len(list(csv.DictReader(lines))) == len(values["rows"]) == len(report.rows)


def test_a_scene_that_is_not_there_is_refused_with_the_names_that_are() -> None:
    found = CliRunner().invoke(cli, ["report", "error-time", "nose"])
    assert found.exit_code == 1
    assert "'nose'" in found.output
    assert "cantilever" in found.output


@pytest.mark.slow
def test_a_target_error_is_met_by_the_settings_that_it_chose(tmp_path: Path) -> None:
    procedure = small_procedure()
    path = tmp_path / "small.usda"
    write_procedure(procedure, path)
    report = tmp_path / "report.json"
    target = 0.2
    options = ["--target-error", str(target), "--store", str(tmp_path / "store"), "--report", str(report)]
    found = CliRunner().invoke(cli, ["solve", str(path), *options])
    assert found.exit_code == 0, found.output
    assert "Chosen for an error of 0.2 mm: spacing" in found.output
    frames = json.loads(report.read_text())["frames"]
    assert max(frame["estimated_error_mm"]["rms"] for frame in frames) <= target


def test_a_target_error_and_a_spacing_exclude_each_other(tmp_path: Path) -> None:
    found = CliRunner().invoke(cli, ["solve", str(tmp_path / "p.usda"), "--target-error", "0.1", "--spacing", "1"])
    assert found.exit_code == 2
    assert "leave --spacing out" in found.output
