"""What the site has of flaps: rows of the atlas that a run left out stay, with their run; operations as files."""

from __future__ import annotations

from pathlib import Path

import pytest

from flap_downloads import write_downloads
from flap_pictures import merged, without_contact
from lappet.designs.library_operation import flap_on_patch
from lappet.models.body_package import is_fetched
from lappet.models.regional_flaps import flap_on_model
from lappet.usd.stage import read_procedure
from website.pages import download_section


def run(revision: str, *names: str) -> dict:
    return {"revision": revision, "date": "now", "rows": [{"name": name} for name in names], "spacing_mm": 1.5}


def revisions(results: dict) -> dict[str, str]:
    return {name: each["revision"] for each in results["runs"] for name in each["designs"]}


def test_a_run_of_single_designs_replaces_their_rows_and_keeps_the_others_with_their_revision() -> None:
    first = merged(run("a", "limberg", "note"), run("b", "note", "webster"))
    assert [row["name"] for row in first["rows"]] == ["limberg", "note", "webster"]
    assert revisions(first) == {"limberg": "a", "note": "b", "webster": "b"}
    second = merged(first, run("c", "limberg"))
    assert revisions(second) == {"limberg": "c", "note": "b", "webster": "b"}
    assert len(second["runs"]) == 2


def test_runs_on_one_machine_and_revision_are_one_with_the_date_of_the_last() -> None:
    both = merged(merged(run("a", "limberg"), {**run("a", "note"), "date": "later"}), run("b", "webster"))
    assert [(each["revision"], each["date"], each["designs"]) for each in both["runs"]] == [
        ("a", "later", ["limberg", "note"]),
        ("b", "now", ["webster"]),
    ]


def test_a_run_of_all_designs_leaves_one_run() -> None:
    both = merged(merged(run("a", "limberg"), run("b", "note")), run("c", "limberg", "note"))
    assert [each["revision"] for each in both["runs"]] == ["c"]


def test_a_run_on_models_alone_keeps_every_row_of_the_patch_and_its_spacing() -> None:
    patch = merged(run("a", "limberg"), run("b", "note"))
    models = {**run("c"), "spacing_mm": 9.0, "model_rows": [{"name": "cheek_limberg"}, {"name": "nose_bilobed"}]}
    both = merged(patch, models)
    assert (both["spacing_mm"], both["rows"], both["runs"]) == (patch["spacing_mm"], patch["rows"], patch["runs"])
    again = merged(both, {**run("d"), "model_rows": [{"name": "nose_bilobed", "frames": 40}]})
    assert [row["name"] for row in again["model_rows"]] == ["cheek_limberg", "nose_bilobed"]
    assert [(each["revision"], each["designs"]) for each in again["model_runs"]] == [
        ("c", ["cheek_limberg"]),
        ("d", ["nose_bilobed"]),
    ]


def test_rows_with_self_contact_stay_beside_the_others_and_give_the_picture_where_they_came_to_their_end() -> None:
    rows = [{"name": "cheek_limberg"}, {"name": "nose_bilobed"}]
    both = merged(run("a", "limberg"), {**run("b"), "model_rows": rows})
    assert without_contact(both) == {"cheek_limberg", "nose_bilobed"}
    ended, stuck = ({"name": row["name"], "frames": n, "of_frames": 40} for row, n in zip(rows, (40, 23), strict=True))
    both = merged(both, {**run("c"), "contact_rows": [ended, stuck]})
    assert without_contact(both) == {"nose_bilobed"}
    assert both["model_rows"] == rows
    assert [(each["revision"], each["designs"]) for each in both["contact_runs"]] == [
        ("c", ["cheek_limberg", "nose_bilobed"])
    ]


def test_the_site_offers_the_operation_of_a_design_as_it_is(tmp_path: Path) -> None:
    files = write_downloads(tmp_path, ["note"])
    assert {"note.usda"} <= {file.name for file in files} <= {"note.usda", "note.blend"}
    assert read_procedure(tmp_path / "note" / "note.usda") == flap_on_patch("note")
    assert all(10_000 < file.stat().st_size < 2_000_000 for file in files)
    section = download_section([file.name for file in files], "note")
    assert "[note.usda](note.usda)" in section
    assert "body" not in section
    assert download_section([], "note") == ""


@pytest.mark.skipif(not is_fetched(), reason="the models' package is not there: lappet models fetch")
def test_the_site_offers_a_design_on_a_body_too_where_it_belongs_on_one(tmp_path: Path) -> None:
    files = write_downloads(tmp_path, ["a-t"])
    assert {"a-t.usda", "lip_a_t.usda"} <= {file.name for file in files}
    read = read_procedure(tmp_path / "a-t" / "lip_a_t.usda")
    assert read == flap_on_model("lip_a_t", scenery=False)
    assert all(file.stat().st_size < 8_000_000 for file in files)
    section = download_section([file.name for file in files], "a-t")
    assert section.index("a-t.usda") < section.index("on a body") < section.index("[lip_a_t.usda](lip_a_t.usda)")
