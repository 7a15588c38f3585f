"""`lappet compare`: measures of operations against what is known of them, and against the report of the same solve."""

from __future__ import annotations

import csv
import math
from dataclasses import replace
from pathlib import Path
from xml.dom import minidom

import numpy as np
import pytest
from click.testing import CliRunner

from lappet.commands.cli import cli
from lappet.core.problem_code import ProblemCode
from lappet.designs.library_operation import flap_on_patch
from lappet.output.comparison import compared, comparison_rows
from lappet.output.skin_regions import AT_SCAR, skin_regions
from lappet.output.solve_to_cache import SolveResult, solve_procedure
from lappet.procedure import Landmark, Procedure, SkinLine, Undermine
from lappet.program.settings import SolverSettings
from lappet.solve.force_sums import force_sums
from lappet.tissue.patch import flat_patch
from lappet.usd.cache_end import CacheEnd, read_cache_end
from lappet.usd.stage import write_procedure
from refusals import refuses
from small_procedure import small_procedure

SQUARE = ((-10.0, -5.0, 4.0), (10.0, -5.0, 4.0), (10.0, 5.0, 4.0), (-10.0, 5.0, 4.0))


def end_of(**given) -> CacheEnd:
    """The end of an operation on a patch whose skin lines run along x, with one seam of 20 mm along x."""
    line = SkinLine("line", ((-30.0, 0.0, 4.0), (30.0, 0.0, 4.0)))
    tissue = flat_patch((80.0, 60.0, 4.0), spacing=2.0)
    values = {
        "procedure": Procedure(tissue, events=(Undermine("under", 1, SQUARE),), skin_lines=(line,)),
        "time": 9.0,
        "forces": {"one": 30.0, "two": 50.0},
        "seams": {"skin": np.column_stack([np.linspace(-10.0, 10.0, 65), np.zeros(65), np.full(65, 4.0)])},
        "measures": {
            "skin": {"tension": 0.1, "scarLength": 20.0, "openArea": 1.5, "startDogEar": 0.4, "endDogEar": math.nan}
        },
        "landmarks": {"ala": (np.array([5.0, 5.0, 4.0]), np.array([5.0, 8.0, 8.0]))},
        "tension": np.array([1.0, 2.0, 100.0]),
        "area": np.array([600.0, 399.0, 1.0]),
    }
    return CacheEnd(**(values | given))


def test_an_operation_is_measured_as_it_is() -> None:
    found = compared("one", end_of())
    assert (found.closing_force_mn, found.greatest_force_mn) == (80.0, 50.0)
    assert (found.scar_length_mm, found.open_area_mm2, found.dog_ear_mm) == (20.0, 1.5, 0.4)
    assert found.undermined_mm2 == pytest.approx(200.0)
    assert found.moved_mm == {"ala": pytest.approx(5.0)}
    assert found.scar_to_lines_deg == pytest.approx(0.0, abs=1e-4)


def test_the_greatest_tension_leaves_out_a_hundredth_of_the_skin() -> None:
    found = compared("one", end_of())
    assert found.greatest_tension_kpa == 2.0
    assert found.mean_tension_kpa == pytest.approx((600.0 + 798.0 + 100.0) / 1000.0)


def test_a_scar_across_the_lines_of_the_skin_is_at_90_degrees_to_them() -> None:
    across = np.column_stack([np.zeros(65), np.linspace(-10.0, 10.0, 65), np.full(65, 4.0)])
    assert compared("one", end_of(seams={"skin": across})).scar_to_lines_deg == pytest.approx(90.0, abs=0.1)


def test_what_is_not_known_is_left_empty() -> None:
    found = compared("one", end_of(tension=np.zeros(0), area=np.zeros(0), forces={}, measures={}, seams={}))
    rows = {row[0]: row[1] for row in comparison_rows([found])}
    assert rows["greatest tension of the skin, kPa"] == rows["greatest dog-ear, mm"] == ""
    assert rows["closing force, mN"] == "0"


def test_it_is_said_how_many_sutures_are_left_out_where_some_are() -> None:
    coarse, fine = (compared(name, end_of(unresolved=left)) for name, left in (("coarse", ("three",)), ("fine", ())))
    (row,) = (row for row in comparison_rows([coarse, fine]) if "left out" in row[0])
    assert row[1:] == ["1", "0"]
    assert not any("left out" in row[0] for row in comparison_rows([fine, fine]))


def test_landmarks_are_shown_that_more_than_one_operation_has() -> None:
    other = end_of(landmarks={"lid": (np.zeros(3), np.ones(3))})
    both = [compared("one", end_of()), compared("two", other)]
    assert not any("moved" in row[0] for row in comparison_rows(both))
    assert comparison_rows([both[0], both[0]])[-2] == ["ala moved, mm", "5", "5"]


@pytest.fixture(scope="module")
def solved(tmp_path_factory: pytest.TempPathFactory) -> SolveResult:
    """A small fusiform excision, solved by the daemon."""
    folder = tmp_path_factory.mktemp("compared")
    procedure = flap_on_patch("fusiform", {"length": 24.0, "width": 8.0}, spacing=2.0)
    tissue = procedure.tissue
    corners = tissue.points[tissue.face_vertex_indices.reshape(-1, 4)].mean(axis=1)
    left = np.flatnonzero((corners[:, 0] < 0.0) & (corners[:, 2] > 4.0 - 1e-6))
    line = Landmark("margin", ((-15.0, -15.0, 4.0), (0.0, -15.0, 4.0), (15.0, -15.0, 4.0)), "margin")
    tissue = replace(tissue, subsets={**tissue.subsets, "left_half": left})
    procedure = replace(procedure, tissue=tissue).with_events(line)
    return solve_procedure(procedure, folder / "one.usdc", SolverSettings(spacing=2.0), error_estimate=False)


def test_the_end_of_a_cache_says_what_the_solve_measured(solved: SolveResult) -> None:
    assert solved.output is not None
    end = read_cache_end(solved.output)
    last = solved.measures[-1]
    assert end.time == solved.frames[-1].solved.time
    forces = {each.suture: each.force_mn for each in last.sutures if each.resolved}
    assert end.forces == pytest.approx(forces, rel=1e-5, abs=1e-4)
    assert set(end.unresolved) == {each.suture for each in last.sutures if not each.resolved} != set()
    assert compared("one", end).closing_force_mn == pytest.approx(force_sums(last.sutures).total_mn, rel=1e-5)
    for state in last.seams:
        own = end.measures[state.measure.seam]
        assert own["scarLength"] == pytest.approx(state.measure.scar_length_mm, rel=1e-5)
        assert own["openArea"] == pytest.approx(state.measure.open_area_mm2, rel=1e-4, abs=1e-5)
    # The skin of the patch is about as large as at rest, less what was excised.
    assert end.area.sum() == pytest.approx(72.0 * 56.0, rel=0.06)


def test_the_tension_of_a_region_is_that_of_its_skin(solved: SolveResult) -> None:
    """The excision is symmetric: half of the skin has half of the area and the mean tension of the whole."""
    assert solved.output is not None
    end = read_cache_end(solved.output)
    regions = skin_regions(end)
    assert set(regions) == {"left_half", AT_SCAR}
    (tension, area), (at_scar, near) = regions["left_half"], regions[AT_SCAR]
    assert area.sum() == pytest.approx(0.5 * end.area.sum(), rel=0.03)
    whole = np.average(end.tension, weights=end.area)
    assert np.average(tension, weights=area) == pytest.approx(whole, rel=0.05)
    assert np.average(at_scar, weights=near) > 1.2 * whole
    # A scar of 24 mm or a little more with 10 mm to each side and half a disk at each end.
    assert near.sum() == pytest.approx(20.0 * 25.5 + np.pi * 100.0, rel=0.06)


def test_a_line_of_landmarks_tells_how_far_it_moved_and_how_much_longer_it_is(solved: SolveResult) -> None:
    assert solved.output is not None
    end = read_cache_end(solved.output)
    (rest, now) = end.lines["margin"]
    assert list(end.lines) == ["margin"]  # and no edge of a seam, which the design made
    found = compared("one", end)
    assert found.moved_mm["margin"] == pytest.approx(np.linalg.norm(now - rest, axis=1).max())
    assert -0.2 < found.stretched["margin"] < 0.2
    assert found.moved_mm["margin"] > 0.1


def test_regions_and_ways_of_landmarks_are_rows_of_the_table() -> None:
    found = replace(compared("one", end_of()), regions={"nose": (3.0, 2.0)})
    rows = {row[0]: row[1] for row in comparison_rows([found])}
    assert (rows["nose: greatest tension, kPa"], rows["nose: mean tension, kPa"]) == ("3", "2")
    assert rows["ala moved along x, y, z, mm"] == "0.0 3.0 4.0"


def test_the_command_writes_table_figure_and_plate(solved: SolveResult, tmp_path: Path) -> None:
    arguments = ["compare", str(solved.output), str(solved.output), "--csv", str(tmp_path / "t.csv")]
    result = CliRunner().invoke(cli, [*arguments, "-o", str(tmp_path / "t.png"), "--plate", str(tmp_path / "p.svg")])
    assert result.exit_code == 0, result.output
    plate = (tmp_path / "p.svg").read_text(encoding="utf-8")
    assert all(f'id="caption-{letter}"' in plate for letter in "ABCD")
    assert "closing force" in plate
    minidom.parseString(plate)
    rows = list(csv.reader((tmp_path / "t.csv").open(encoding="utf-8")))
    assert rows[0] == ["measure", "one", "one"]
    assert rows[1][0] == "closing force, mN"
    assert rows[1][1] == rows[1][2] != ""
    assert (tmp_path / "t.png").stat().st_size > 10_000


def test_a_procedure_without_solved_frames_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "p.usda"
    write_procedure(small_procedure(), path)
    with refuses(ProblemCode.COMPARE_NO_CACHE):
        read_cache_end(path)
