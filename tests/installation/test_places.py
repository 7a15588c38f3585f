"""Where frames are kept and Blender is found."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from lappet.installation import check_places


@pytest.fixture(autouse=True)
def _plain(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("LAPPET_STORE", str(tmp_path / "frames"))
    monkeypatch.delenv("LAPPET_BLENDER_PYTHON", raising=False)


def test_a_store_that_can_be_written_says_how_much_room_it_has(tmp_path: Path) -> None:
    store, _ = check_places()
    assert store.value.startswith(f"{tmp_path / 'frames'}, ")
    assert store.value.split(" GiB free")[0].rpartition(" ")[2].replace(".", "").isdigit()


def test_a_store_that_is_no_folder_is_broken_and_names_the_remedy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    monkeypatch.setenv("LAPPET_STORE", str(tmp_path / "file" / "frames"))
    store, _ = check_places()
    assert store.state == "broken"
    assert "LAPPET_STORE" in store.remedy


def test_a_disk_that_is_nearly_full_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("lappet.installation.places.LEAST_FREE", 2**60)
    store, _ = check_places()
    assert store.state == "missing"
    assert "free some space" in store.remedy


def test_blender_is_looked_for_where_the_variable_says(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LAPPET_BLENDER_PYTHON", sys.executable)
    assert check_places()[1].state == "ok"
    monkeypatch.setenv("LAPPET_BLENDER_PYTHON", "/no/such/python")
    found = check_places()[1]
    assert found.state == "missing"
    assert "/no/such/python" in found.value
