"""The demo finds a place for its files: its own folder, another name, another folder."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from lappet.core.problem import RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.demo.free_folder import NAME, free_folder


def test_the_folder_is_made_where_the_user_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert free_folder() == tmp_path / NAME
    assert (tmp_path / NAME).is_dir()


def test_the_folder_of_an_earlier_demo_is_taken_again(tmp_path: Path) -> None:
    first = free_folder([tmp_path])
    (first / "z_plasty.usda").write_text("#usda 1.0\n", encoding="utf-8")
    assert free_folder([tmp_path]) == first


@pytest.mark.parametrize("kind", ["file", "folder", "link"])
def test_what_is_somebody_elses_is_left_alone(tmp_path: Path, kind: str) -> None:
    if kind == "file":
        (tmp_path / NAME).write_text("mine", encoding="utf-8")
    elif kind == "link":
        (tmp_path / NAME).symlink_to(tmp_path / "gone" / "long ago")
    else:
        (tmp_path / NAME).mkdir()
        (tmp_path / NAME / "mine.txt").write_text("mine", encoding="utf-8")
    assert free_folder([tmp_path]) == tmp_path / f"{NAME}-2"


def test_where_nothing_can_be_written_the_next_place_is_tried(tmp_path: Path) -> None:
    no_folder = tmp_path / "file"
    no_folder.write_text("", encoding="utf-8")
    assert free_folder([no_folder, tmp_path]) == tmp_path / NAME


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="nothing is read-only for root")
def test_a_folder_that_may_not_be_written_is_passed_by(tmp_path: Path) -> None:
    locked = tmp_path / "locked"
    locked.mkdir(mode=0o500)
    assert free_folder([locked, tmp_path]) == tmp_path / NAME


def test_no_place_at_all_is_refused_with_the_first(tmp_path: Path) -> None:
    no_folder = tmp_path / "file"
    no_folder.write_text("", encoding="utf-8")
    with pytest.raises(RefusedError) as told:
        free_folder([no_folder])
    assert told.value.problems[0].code == ProblemCode.FILE_ERROR
    assert str(no_folder) in told.value.problems[0].prim


@pytest.mark.skipif(os.name != "posix", reason="Windows keeps a folder that somebody is in")
def test_from_a_folder_that_is_gone_it_goes_to_the_next_place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "gone").mkdir()
    (tmp_path / "documents").mkdir()
    monkeypatch.chdir(tmp_path / "gone")
    (tmp_path / "gone").rmdir()
    monkeypatch.setattr("platformdirs.user_documents_path", lambda: tmp_path / "documents")
    assert free_folder() == tmp_path / "documents" / NAME
