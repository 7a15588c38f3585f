"""`lappet report atlas`: what it measures is what the solve's own report says, and its page shows it."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from lappet.commands.cli import cli
from lappet.core.problem_code import ProblemCode
from lappet.designs.library import DESIGNS
from lappet.models.body_package import FOLDER_VARIABLE, is_fetched
from lappet.models.regional_flaps import REGIONAL_FLAPS, flap_on_model
from lappet.procedure import Landmark
from lappet.reports.atlas.design_page import design_pages, rows_of
from lappet.reports.atlas.page import flap_page
from lappet.reports.atlas.run import run_atlas
from lappet.reports.literature.rows import ROWS
from refusals import refuses
from report_told import Told

DOCS = Path(__file__).resolve().parents[2] / "docs"

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The atlas of one design on a coarse lattice, without pictures."""
    path = tmp_path_factory.mktemp("atlas")
    told = Told()
    rows, _ = run_atlas(["fusiform"], path, told, spacing=2.0, pictures=False)
    assert [row.name for row in rows] == ["fusiform"]
    assert told.lines == [
        "1 solves",
        "fusiform",
        "24 frames",
        f"fusiform: 24 of 24 frames converged, {rows[0].seconds:.0f} s.",
    ]
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
    flat, _, on_a_body = page.partition("\n## On a body\n")
    assert (flat.count("not solved"), on_a_body.count("not solved")) == (len(DESIGNS) - 1, len(REGIONAL_FLAPS))


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
        run_atlas(["fusiform", "limburg"], tmp_path / "atlas", Told())
    assert not (tmp_path / "atlas").exists()


def test_without_the_models_the_patch_is_solved_and_a_sentence_says_what_is_left_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "models"))
    told = Told()
    rows, _ = run_atlas(["upper-lid"], tmp_path / "both", told, spacing=4.0, pictures=False)
    assert [row.name for row in rows] == ["upper-lid"]
    assert "lappet models fetch" in told.lines[0]
    assert told.lines[1] == "1 solves"
    told.lines.clear()
    run_atlas(["fusiform"], tmp_path / "none", told, spacing=4.0, pictures=False)
    assert not any("models" in line for line in told.lines)  # it belongs to no region
    with refuses(ProblemCode.MODELS_NOT_FETCHED):
        run_atlas(["upper-lid"], tmp_path / "models_only", told, places="models")
    assert not (tmp_path / "models_only").exists()


@pytest.mark.skipif(not is_fetched(), reason="the models' package is not there: lappet models fetch")
def test_a_row_on_a_model_says_what_its_report_says_and_how_far_landmarks_went(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    coarse = partial(flap_on_model, spacing=4.0)
    monkeypatch.setattr("lappet.reports.atlas.run.flap_on_model", coarse)
    rows, files = run_atlas(["keystone"], tmp_path, Told(), pictures=False, places="models")
    assert "contact_rows" not in json.loads((tmp_path / "atlas.json").read_text(encoding="utf-8"))
    assert [row.name for row in rows] == ["limb_keystone"]
    results = json.loads((tmp_path / "atlas.json").read_text(encoding="utf-8"))
    assert results["rows"] == []
    (row,) = results["model_rows"]
    report = json.loads((tmp_path / "limb_keystone.json").read_text(encoding="utf-8"))
    assert (row["design"], row["model"], row["spacing"]) == ("keystone", "limb", 4.0)
    assert row["total_force"] == [report["sutures"][-1]["total_mn"], report["sutures"][-1]["total_error_mn"]]
    assert row["newton"] == sum(frame["newton_iterations"] for frame in report["frames"])
    own = {event.label for event in coarse("limb_keystone").events if isinstance(event, Landmark)}
    first, last = (report["frames"][k]["landmarks"] for k in (0, -1))
    for name, (moved, _) in row["moved"].items():
        assert moved == pytest.approx(float(np.linalg.norm(np.subtract(last[name], first[name]))))
    assert "flap middle" in own - set(row["moved"])  # of the flap, not of the body
    assert tmp_path / "limb_keystone.usdc" in files


def model_row(**more: object) -> dict[str, object]:
    usual: dict[str, object] = {"name": "cheek_limberg", "design": "limberg", "model": "cheek", "spacing": 1.0}
    usual |= {"cells": 33_000, "newton": 150, "frames": 40, "of_frames": 40, "reason": "", "total_force": [413.0, 20.0]}
    usual |= {"greatest_suture": "suture_flap/deep/1", "scar_length": 46.0, "open_area": 0.5, "overlap": 1.2}
    return {
        **usual,
        "moved": {"alare left": [0.31, 0.02], "cheilion left": [1.52, 0.1], "menton": [0.05, 0.01]},
        **more,
    }


def page_of(*rows: dict[str, object], contact: tuple[dict[str, object], ...] = ()) -> str:
    results = {"rows": [], "spacing_mm": 1.5, "model_rows": list(rows), "contact_rows": list(contact)}
    return design_pages(results, {"rows": []})["limberg"]


def test_the_page_of_a_design_that_belongs_on_a_body_shows_it_there_with_what_moved() -> None:
    page = page_of(model_row())
    section = page.partition("## On the cheek\n")[2].partition("\n## ")[0]
    assert "![Limberg flap on the cheek, step by step](../images/flaps/cheek_limberg.jpg)" in section
    assert "40 of 40 frames converged" in section
    assert "410 ± 20" in section  # as exact as its error allows
    assert section.index("cheilion left 1.5") < section.index("alare left 0.31")  # the farthest first
    assert "menton" not in section


def test_what_self_contact_changes_stands_beside_what_was_measured_without_it() -> None:
    alone = page_of(model_row())
    assert "[`--self-contact`]" not in alone
    assert "| with `--self-contact` |" not in alone
    with_contact = model_row(newton=813, total_force=[448.0, None], overlap=0.0)
    page = page_of(model_row(), contact=(with_contact,))
    assert "40 of 40 frames converge, 813 Newton iterations in all; the picture shows that solve." in page
    assert "| force of all sutures, mN | 410 ± 20 | 448 |" in page
    assert "| tissue in tissue, mm | 1.2 | 0 |" in page
    stuck = model_row(frames=23, reason="The frame at time 24 did not converge.")
    page = page_of(model_row(), contact=(stuck,))
    assert "23 of 40 frames converge" in page
    assert "The frame at time 24 did not converge." in page
    assert "the picture shows" not in page


def test_an_operation_that_did_not_come_to_its_end_is_shown_as_such() -> None:
    assert "does not come to its end" not in page_of(model_row())
    page = page_of(model_row(frames=23, reason="The frame at time 24 did not converge."))
    assert "23 of 40 frames converged" in page
    assert "**It does not come to its end**: The frame at time 24 did not converge." in page
    assert "cheek_limberg.jpg" not in page_of(model_row(frames=0))
    assert "The last atlas does not have this operation." in page_of()


def test_what_the_last_atlas_solved_on_a_body_has_its_picture_and_is_of_the_design_and_model_that_it_names() -> None:
    results = json.loads((DOCS / "atlas.json").read_text(encoding="utf-8"))
    assert len(results["model_rows"]) > 0
    for row in results["model_rows"]:
        flap = REGIONAL_FLAPS[row["name"]]
        assert (row["design"], row["model"]) == (flap.design, flap.model)
        assert 20_000 < (DOCS / "images" / "flaps" / f"{flap.name}.jpg").stat().st_size < 400_000


def test_the_page_of_all_designs_leads_to_every_operation_on_a_body() -> None:
    page, pages = (
        flap_page({"rows": [], "spacing_mm": 1.5}),
        design_pages({"rows": [], "spacing_mm": 1.5}, {"rows": []}),
    )
    for flap in REGIONAL_FLAPS.values():
        anchor = flap.place.replace(" ", "-")
        assert f"[on {flap.place}](flaps/{flap.design}.md#on-{anchor})" in page
        assert f"\n## On {flap.place}\n" in pages[flap.design]


def test_the_command_says_what_it_wrote(tmp_path: Path) -> None:
    arguments = ["report", "atlas", "v-y", "-o", str(tmp_path / "atlas"), "--no-pictures", "--spacing", "4"]
    result = CliRunner().invoke(cli, arguments)
    assert result.exit_code == 0, result.output
    assert str(tmp_path / "atlas" / "atlas.json") in result.stdout
