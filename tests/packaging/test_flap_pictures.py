"""`flap_pictures.py`: rows of designs that a run left out stay, and it stays known which run each row is from."""

from __future__ import annotations

from flap_pictures import merged


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
