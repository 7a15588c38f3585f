"""The benchmark's numbers are those of the frames and of the kernel suite, by the formulas that it states."""

from __future__ import annotations

import csv
import json
import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lappet.bench import kernels, scenes, sheets, tables
from lappet.bench.circumstances import circumstances, revision
from lappet.bench.scenes import SceneMeasure, measure, pass_times, state_hash
from lappet.core.problem import RefusedError
from lappet.daemon.frame_diagnostics import Diagnostics, PassCounts, StageSeconds
from lappet.daemon.lattice_counts import LatticeCounts
from lappet.daemon.solved_frame import SolvedFrame

WORK = PassCounts(
    evaluations=5,
    evaluation_seconds=0.5,
    linearizations=4,
    linearization_seconds=0.08,
    products=100,
    product_seconds=0.3,
)


LATTICE = LatticeCounts(6400, 100, 90, 10, 150, 1, 20, 0, 0, 100.0, 1000.0, 0.1)


def solved(lattice: LatticeCounts = LATTICE, **changes: Any) -> SolvedFrame:
    plain = Diagnostics(
        converged=True,
        newton=4,
        pcg=30,
        residual=1e-4,
        largest_gap=1e-5,
        minimum_j=0.9,
        peak_bytes=1000.0,
        seconds=StageSeconds(total=2.0, linear=1.5, stability=0.0625),
        work=WORK,
    )
    return SolvedFrame(1.0, np.zeros((1, 3), np.float32), diagnostics=replace(plain, **changes), lattice=lattice)


def row(frames: list[SolvedFrame]) -> SceneMeasure:
    return measure("flap", 1.0, 2, "avx2", 3, 9.0, frames, "0123 1.5 mm")


# --- scenes ------------------------------------------------------------------------------------------------------


def test_a_row_sums_work_and_takes_the_worst_of_the_frames() -> None:
    cut = LatticeCounts(6300, 120, 80, 40, 190, 2, 26, 0, 0, 98.0, 1000.0, 0.1)
    found = row(
        [
            solved(),
            solved(newton=6, residual=5e-4),
            solved(lattice=cut, largest_gap=2e-4, minimum_j=0.4, peak_bytes=2400),
        ]
    )
    assert found.converged
    assert found.reason is None
    assert (found.frames, found.epochs, found.isa) == (3, 3, "avx2")
    assert (found.cells, found.mesh_cells, found.nodes) == (120, 40, 190)
    assert (found.newton_iterations, found.newton_median, found.pcg_iterations) == (14, 4, 90)
    assert found.solver_seconds == 6.0
    assert (found.linear_seconds, found.stability_seconds) == (4.5, 0.1875)
    assert found.newton_iteration_s == pytest.approx(6.0 / 14)
    assert (found.residual, found.largest_gap_mm, found.minimum_j) == (5e-4, 2e-4, 0.4)
    assert found.peak_bytes == 2400
    assert found.bytes_per_cell == 20


def test_passes_are_means_over_the_frames_weighted_by_how_often_they_ran() -> None:
    idle = replace(WORK, products=0, product_seconds=0.0, evaluations=1, evaluation_seconds=0.04)
    update, product = pass_times([each.diagnostics for each in (solved(), solved(work=idle))])
    assert update == pytest.approx(1e3 * (0.54 / 6 + 0.16 / 8))
    assert product == pytest.approx(3.0)


def test_a_frame_that_did_not_converge_makes_the_row_say_why() -> None:
    found = row([solved(), solved(converged=False, reason="the line search found no step")])
    assert not found.converged
    assert found.reason == "the line search found no step"


def test_no_frame_is_refused_by_the_scene_s_name() -> None:
    with pytest.raises(RefusedError, match="flap: No frame was solved"):
        row([])


def test_the_revision_is_a_git_name_or_nothing() -> None:
    found = revision()
    assert found is None or len(found.rstrip("+")) == 12


def test_a_state_is_named_by_its_displacements_to_a_hundredth_of_a_millimetre() -> None:
    nodes = np.array([[0.5, 0.0, 0.0], [3.0, 4.0, 0.0]])
    assert state_hash(nodes).endswith(" 5.000 mm")
    assert state_hash(nodes + 1e-4) == state_hash(nodes).replace("5.000", f"{5 + 1.4e-4:.3f}")
    assert state_hash(nodes + 0.02) != state_hash(nodes)
    assert state_hash(nodes[::-1]) != state_hash(nodes)


def test_scenes_come_from_the_list_of_sizes(tmp_path: Path) -> None:
    (tmp_path / "flap").mkdir()
    (tmp_path / "flap" / "flap.usda").touch()
    (tmp_path / "sizes.toml").write_text(
        "[flap]\nmoderate = { spacing = 1.5 }\nfine = { spacing = 0.5 }\n", encoding="utf-8"
    )
    assert scenes.suite(tmp_path) == [scenes.Scene(tmp_path / "flap" / "flap.usda", 1.5, 0.5)]
    (tmp_path / "sizes.toml").write_text("[graft]\nmoderate = { spacing = 1.5 }\n", encoding="utf-8")
    with pytest.raises(RefusedError, match=r"\[graft\] needs"):
        scenes.suite(tmp_path)


def test_the_suite_holds_the_scenes_of_the_examples() -> None:
    listed = scenes.suite(Path(__file__).resolve().parents[2] / "examples")
    assert {"z_plasty", "rhomboid", "dual_s_plasty"} <= {scene.procedure.stem for scene in listed}
    assert all(scene.fine is None or scene.fine < scene.moderate for scene in listed)
    assert {scene.procedure.stem for scene in listed if scene.fine is None} <= {"dufourmentel_mouly_head"}


@pytest.mark.slow
@pytest.mark.timeout(240)
def test_a_scene_is_solved_and_its_state_is_how_far_its_surface_went(binary: Path, tmp_path: Path) -> None:
    from lappet.usd.stage import write_procedure
    from small_procedure import small_procedure

    file = tmp_path / "small.usda"
    write_procedure(small_procedure(), file)
    found = scenes.solve_scene(file, 2.0, tmp_path)
    assert found.converged
    assert found.isa
    assert found.cells == found.grid_cells + found.mesh_cells
    assert found.update_state_ms > 0
    assert found.product_ms > 0
    assert 0 < float(found.state.split()[1]) < 50


# --- kernels -----------------------------------------------------------------------------------------------------


def entry(name: str, nanoseconds: float, **counters: float) -> dict[str, Any]:
    return {"name": name, "run_type": "iteration", "cpu_time": nanoseconds, "real_time": nanoseconds, "time_unit": "ns",
            **counters}  # fmt: skip


def printed() -> dict[str, Any]:
    """Made-up times: 10 GB/s of memory, 100 GB/s of cache, 50 and 25 operations a nanosecond."""
    product = {"bytes_per_cell": 120.0, "operations_per_cell": 400.0, "set_bytes": 1e9}
    return {
        "context": {"compiler": "GNU", "isa": "avx2", "instruction_sets": "avx2", "stream_bytes": "8"},
        "benchmarks": [
            entry("copy/bytes/any/cache", 200.0, cells=10_000),
            entry("copy/bytes/any/stream/iterations:1/repeats:2", 9e6, cells=1e7),
            entry("copy/bytes/any/stream/iterations:1/repeats:2", 2e6, cells=1e7),
            entry("multiply_add/float/avx2/cache", 2.0, operations=100),
            entry("multiply_add/double/avx2/cache", 4.0, operations=100),
            entry("product/float/avx2/cache", 1600.0, cells=100, **product),
            entry("product/float/avx2/stream/iterations:1", 3000.0, cells=100, **product),
            entry("product/float/avx2/stream/iterations:1", 2400.0, cells=100, **product),
            {**entry("product/float/avx2/cache", 1.0, cells=100, **product), "run_type": "aggregate"},
            entry("evaluate/double/avx2/cache", 6400.0, cells=100, **product),
            entry("product_50000/float/avx2/cache/threads:1/real_time", 1e6, cells=50_000, threads_used=1),
            entry("product_50000/float/avx2/cache/threads:2/real_time", 6e5, cells=50_000, threads_used=2),
            entry("product_50000/float/avx2/cache/threads:2/real_time", 5e5, cells=50_000, threads_used=2),
        ],
    }


def test_the_roofline_is_the_larger_of_traffic_and_arithmetic_over_the_best_time() -> None:
    suite = kernels.read_suite(printed())
    found = {(r.kernel, r.mode): r for r in suite.rows}
    assert set(found) == {("product", "cache"), ("product", "stream"), ("evaluate", "cache")}
    cached, streamed = found["product", "cache"], found["product", "stream"]
    assert cached.ns_per_cell == pytest.approx(16.0)
    assert cached.roofline_fraction == pytest.approx(400 / 50 / 16)  # arithmetic: 8 ns, traffic 1.2 ns
    assert streamed.ns_per_cell == pytest.approx(24.0)
    assert streamed.roofline_fraction == pytest.approx(120 / 10 / 24)  # traffic: 12 ns
    assert found["evaluate", "cache"].roofline_fraction == pytest.approx(400 / 25 / 64)  # the rate of doubles
    assert suite.limits.copy == {"cache": pytest.approx(1e11), "stream": pytest.approx(1e10)}


def test_threads_are_compared_by_their_best_wall_times() -> None:
    one, two = kernels.read_suite(printed()).parallel
    assert (one.threads, one.ms, one.speedup) == (1, pytest.approx(1.0), pytest.approx(1.0))
    assert (two.threads, two.ms, two.speedup, two.cells) == (2, pytest.approx(0.5), pytest.approx(2.0), 50_000)


def test_kernels_without_the_limits_of_the_machine_are_refused() -> None:
    values = printed()
    values["benchmarks"] = values["benchmarks"][5:]
    with pytest.raises(RefusedError, match="without copy or multiply_add"):
        kernels.read_suite(values)


@pytest.fixture(scope="module")
def quick_suite() -> kernels.Suite:
    try:
        program = kernels.find_benchmarks()
    except RefusedError as reason:
        if os.environ.get("CI"):
            raise
        pytest.skip(str(reason))
    return kernels.read_suite(kernels.run_suite(program, repetitions=2, seconds=1e-3, stream_bytes=1 << 24))


KERNELS = {
    "svd", "stress", "stress_derivative", "state_update", "quaternion_of_rotation", "rotation_of_quaternion", "force",
    "force_differential", "stabilization", "gather", "scatter", "product", "evaluate", "diagonal",
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.timeout(120)
def test_every_kernel_is_measured_on_every_instruction_set_of_the_machine(quick_suite: kernels.Suite) -> None:
    sets = quick_suite.context["instruction_sets"].split(",")
    assert "scalar" in sets
    assert quick_suite.context["isa"] in sets
    measured = {(r.kernel, r.isa, r.mode) for r in quick_suite.rows}
    assert {(k, isa, mode) for k in KERNELS for isa in sets for mode in ("cache", "stream")} <= measured
    assert all(r.ns_per_cell > 0 and r.bytes_per_cell > 0 and r.roofline_fraction > 0 for r in quick_suite.rows)
    assert {p.threads for p in quick_suite.parallel} >= {1}


@pytest.mark.slow
@pytest.mark.timeout(120)
def test_operations_are_counted_not_claimed(quick_suite: kernels.Suite) -> None:
    counted = {r.kernel: r.operations_per_cell for r in quick_suite.rows if r.precision == "float"}
    # The 24 of a quaternion's rotation can be counted by hand: 3 doublings, 9 products, 12 sums.
    assert counted["rotation_of_quaternion"] == 24
    # neo-Hookean: 2 + 2 products, 3 (maximum, division, difference), 3 + 6 for ln J, and so on: between 20 and 40
    assert 20 <= counted["stress"] <= 40
    parts = counted["svd"] + counted["stress"] + 2 * counted["quaternion_of_rotation"]
    # What is left of a state update is the derivative and its definiteness; the pass scales it by the volume too.
    assert 0 < counted["state_update"] - parts <= counted["stress_derivative"]
    # A cell's block sums are added up once in a product and once in each of its parts.
    assert counted["product"] < counted["force_differential"] + counted["stabilization"]


@pytest.mark.slow
@pytest.mark.timeout(120)
def test_wider_sets_are_faster_where_arithmetic_counts(quick_suite: kernels.Suite) -> None:
    svd = {r.isa: r.ns_per_cell for r in quick_suite.rows if (r.kernel, r.mode) == ("svd", "cache")}
    wide = [isa for isa in ("neon", "avx2", "avx512") if isa in svd]
    if not wide:
        pytest.skip("this processor has no wide instruction set")
    assert svd["scalar"] > 1.5 * min(svd[isa] for isa in wide)


# --- sheets ------------------------------------------------------------------------------------------------------


def sheet(**changes: Any) -> sheets.SheetMeasure:
    plain = sheets.SheetMeasure(
        "scaling", 1.0, 0.45, "float", 1e-3, 1, "avx2", True, None, 1000, 1.0, 0.1, 5, 50, 1, 1e-4, 0.2, 1.0, 0.5,
        800.0, 500.0, "0123 1 mm",
    )  # fmt: skip
    return replace(plain, **changes)


def test_the_fitted_exponent_is_that_of_a_power_law() -> None:
    cells = np.array([5e4, 1e5, 4e5, 1e6])
    assert sheets.fitted_exponent(cells.tolist(), (3e-6 * cells**1.1).tolist()) == pytest.approx(1.1)
    rows = [sheet(cells=int(n), seconds=1e-5 * float(n) ** 1.05) for n in cells]
    said = sheets.summary([*rows, sheet(cells=2_000_000, seconds=1e9, converged=False)])
    assert said["time_exponent"] == pytest.approx(1.05, abs=1e-3)
    assert said["bytes_exponent"] == pytest.approx(1.0)
    assert said["most_bytes_per_cell"] == 800.0


def test_two_threads_are_compared_with_one_and_only_where_both_are_there() -> None:
    rows = [sheet(benchmark="threads", threads=1, seconds=3.0), sheet(benchmark="threads", threads=2, seconds=1.6)]
    assert sheets.summary(rows)["speedup_on_2_threads"] == pytest.approx(1.875)
    assert "speedup_on_2_threads" not in sheets.summary(rows[:1])


def test_the_box_of_the_sheets_is_closed_and_knows_its_sides() -> None:
    surface, side = sheets.box((10.0, 4.0, 2.0))
    corners = surface.points[surface.triangles]
    volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    assert volume == pytest.approx(80.0)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    for triangle, which in enumerate(side):
        axis, high = divmod(int(which), 2)
        assert normal[triangle, axis] * (1 if high else -1) == pytest.approx(np.linalg.norm(normal[triangle]))
        assert np.all(corners[triangle, :, axis] == (10.0, 4.0, 2.0)[axis] * high)


@pytest.mark.slow
@pytest.mark.timeout(120)
def test_the_twisted_sheet_is_pulled_as_far_as_it_says_on_any_number_of_threads(binary: Path) -> None:
    one, two = (sheets.twisted(2.0, 1e-3, threads=n) for n in (1, 2))
    assert one.converged
    assert one.cells == 50 * 30 * 2
    assert one.residual <= 1e-3
    # the farthest node is a corner of the end: pulled by 30 mm, and turned by 30° about the middle
    corner = 2 * np.hypot(30.0, 2.0) * np.sin(np.radians(15.0))
    assert float(one.state.split()[1]) == pytest.approx(np.hypot(30.0, corner), abs=2e-3)
    assert one.state == two.state
    assert one.update_state_ms > 0
    assert one.product_ms > 0


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_the_twisted_sheet_of_192_000_cells_takes_at_most_750_bytes_a_cell_at_its_peak(binary: Path) -> None:
    fine = sheets.twisted(0.5, 1e-3, threads=2)
    assert fine.converged
    assert fine.cells == 200 * 120 * 8
    assert 300 < fine.bytes_per_cell <= 750
    assert fine.session_bytes_per_cell < fine.bytes_per_cell


# --- files -------------------------------------------------------------------------------------------------------


def test_the_markdown_has_the_layout_of_the_paper_s_table_with_ours_below_theirs() -> None:
    lines = tables.scenes_markdown([row([solved()])]).splitlines()
    heading = next(line for line in lines if line.startswith("| scene"))
    columns = [name.strip() for name in heading.strip("|").split("|")]
    assert columns[:7] == [
        "scene", "cells", "grid_cells", "mesh_cells", "blocks", "newton_iteration_s", "update_state_ms",
    ]  # fmt: skip
    body = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("| ")][1:]
    assert all(len(cells) == len(columns) for cells in body)
    paper = tables.published()["table_1"]["rows"]
    assert len(body) == len(paper) + 1
    # As printed; in one row a digit of the paper is wrong.
    assert [cells for _, cells, grid, mesh, *_ in paper if cells != grid + mesh] == [54003]
    assert body[-1][:6] == ["**flap** (2 threads, avx2)", "100", "90", "10", "20", "0.5"]
    assert body[-1][6] == "120"  # 100 ms an evaluation and 20 ms a linearization
    assert body[-1][8] == "3"


def test_the_files_hold_the_machine_and_rows_of_the_agreed_names(tmp_path: Path) -> None:
    suite = kernels.read_suite(printed())
    head = circumstances(suite.context, 2)
    tables.write_json(tmp_path / "kernels.json", head, rows=suite.rows, parallel=suite.parallel)
    tables.write_json(tmp_path / "scenes.json", head, rows=[row([solved()])])
    tables.write_csv(tmp_path / "kernels.csv", suite.rows, head)
    kept = json.loads((tmp_path / "kernels.json").read_text("utf-8"))
    assert {"machine", "compiler", "isa", "threads", "environment", "revision"} <= set(kept)
    assert {"kernel", "isa", "mode", "ns_per_cell", "roofline_fraction", "bytes_per_cell", "precision"} <= set(
        kept["rows"][0]
    )
    assert {
        "scene", "cells", "grid_cells", "mesh_cells", "blocks", "threads", "isa", "newton_iteration_s",
        "update_state_ms", "product_ms", "pcg_iterations", "residual", "bytes_per_cell", "state",
    } <= set(json.loads((tmp_path / "scenes.json").read_text("utf-8"))["rows"][0])  # fmt: skip
    with (tmp_path / "kernels.csv").open(encoding="utf-8") as file:
        lines = list(csv.DictReader(file))
    assert len(lines) == len(suite.rows)
    assert float(lines[0]["ns_per_cell"]) == suite.rows[0].ns_per_cell
    assert lines[0]["compiler"] == "GNU"
