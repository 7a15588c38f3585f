"""What the site has of flaps: rows of the atlas that a run left out stay, with their run; operations as files."""

from __future__ import annotations

from pathlib import Path

from flap_downloads import write_downloads
from flap_pictures import merged
from lappet.designs.library_operation import flap_on_patch
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


def test_a_run_of_all_designs_leaves_one_run() -> None:
    both = merged(merged(run("a", "limberg"), run("b", "note")), run("c", "limberg", "note"))
    assert [each["revision"] for each in both["runs"]] == ["c"]


def test_the_site_offers_the_operation_of_a_design_as_it_is(tmp_path: Path) -> None:
    files = write_downloads(tmp_path, ["limberg"])
    assert {"limberg.usda"} <= {file.name for file in files} <= {"limberg.usda", "limberg.blend"}
    assert read_procedure(tmp_path / "limberg.usda") == flap_on_patch("limberg")
    assert all(10_000 < file.stat().st_size < 2_000_000 for file in files)
    section = download_section([file.name for file in files])
    assert "[limberg.usda](limberg.usda)" in section
    assert download_section([]) == ""
