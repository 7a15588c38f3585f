"""`lappet report atlas`: what it measures is what the solve's own report says, and its page shows it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from lappet.commands.cli import cli
from lappet.core.problem_code import ProblemCode
from lappet.designs.library import DESIGNS
from lappet.reports.atlas.design_page import design_pages, rows_of
from lappet.reports.atlas.page import flap_page
from lappet.reports.atlas.run import run_atlas
from lappet.reports.literature.rows import ROWS
from refusals import refuses


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The atlas of one design on a coarse lattice, without pictures."""
    path = tmp_path_factory.mktemp("atlas")
    said: list[str] = []
    rows, _ = run_atlas(["fusiform"], path, said.append, spacing=2.0, pictures=False)
    assert [row.name for row in rows] == ["fusiform"]
    assert said
    return path


def test_a_row_of_the_atlas_says_what_the_report_of_the_solve_says(folder: Path) -> None:
    (row,) = json.loads((folder / "atlas.json").read_text(encoding="utf-8"))["rows"]
    report = json.loads((folder / "fusiform.json").read_text(encoding="utf-8"))
    assert row["frames"] == row["of_frames"] == sum(frame["converged"] for frame in report["frames"]) == 24
    assert row["total_force"] == [report["sutures"][-1]["total_mn"], report["sutures"][-1]["total_error_mn"]]
    assert row["greatest_suture"] == report["sutures"][-1]["greatest_suture"]
    assert row["scar_length"] == pytest.approx(report["seams"][-1]["scar_length_mm"])
    assert row["tension"][0] == pytest.approx(report["greatest_mean_tension"]["kpa"])


def test_the_page_leads_to_every_design_and_shows_the_numbers_of_those_that_were_solved(folder: Path) -> None:
    page = flap_page(json.loads((folder / "atlas.json").read_text(encoding="utf-8")))
    for name, design in DESIGNS.items():
        assert f"[{design.title}](flaps/{name}.md)" in page
    assert "24 of 24" in page
    assert page.count("not solved") == len(DESIGNS) - 1


def test_each_design_has_a_page_with_its_measures_its_numbers_and_those_of_the_literature(folder: Path) -> None:
    row = {"name": "fusiform-scar-3", "value": 1.2, "error": 0.01, "verdict": "disagrees"}
    results = json.loads((folder / "atlas.json").read_text(encoding="utf-8"))
    pages = design_pages(results, {"rows": [row]})
    assert list(pages) == list(DESIGNS)
    for name, page in pages.items():
        assert f"](../images/flaps/{name}_plan.svg)" in page
        assert DESIGNS[name].indication in page
        for parameter in DESIGNS[name].parameters:
            assert f"`{parameter.name}`" in page
        assert (".jpg)" in page, "frames converged" in page) == (name == "fusiform", name == "fusiform")
        assert ("[disagrees](../literature.md#fusiform-scar-3)" in page) == (name == "fusiform")
    with_error = results["rows"][0]["total_force"]
    assert f"{round(with_error[0], -1):.0f}"[:2] in pages["fusiform"]


def test_every_row_of_the_literature_is_on_the_page_of_a_design_or_of_no_design() -> None:
    """Some are of a straight cut, which is no design of the library."""
    placed = {row.name for name in DESIGNS for row in rows_of(name)}
    left = {row.name for row in ROWS} - placed
    assert all(operation.startswith("cut") for row in ROWS if row.name in left for operation in row.measure.operations)
    assert {row.name for row in rows_of("z-plasty")} & {row.name for row in rows_of("multiple-z-plasty")} == set()


def test_a_design_that_the_library_does_not_have_is_refused_before_anything_is_solved(tmp_path: Path) -> None:
    with refuses(ProblemCode.DESIGN_UNKNOWN):
        run_atlas(["fusiform", "limburg"], tmp_path / "atlas", print)
    assert not (tmp_path / "atlas").exists()


def test_the_command_says_what_it_wrote(tmp_path: Path) -> None:
    arguments = ["report", "atlas", "v-y", "-o", str(tmp_path / "atlas"), "--no-pictures", "--spacing", "4"]
    result = CliRunner().invoke(cli, arguments)
    assert result.exit_code == 0, result.output
    assert str(tmp_path / "atlas" / "atlas.json") in result.stdout
