"""A file gets its name after the disk has its content."""

from __future__ import annotations

import errno
import os
from pathlib import Path
from types import SimpleNamespace

import pytest

from lappet.core.durable import check_space, draft_folder, replace_durably


def test_the_content_is_on_the_disk_before_the_name_and_the_name_before_the_return(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fresh, target = tmp_path / "fresh", tmp_path / "target"
    fresh.write_bytes(b"new")
    target.write_bytes(b"old")
    seen: list[str] = []
    sync = os.fsync

    def noted(handle: int) -> None:
        what = Path(f"/proc/self/fd/{handle}").resolve() if Path("/proc/self/fd").is_dir() else None
        seen.append(f"{what.name if what and what.is_file() else 'folder'}: {target.read_bytes().decode()}")
        sync(handle)

    monkeypatch.setattr("lappet.core.durable.os.fsync", noted)
    replace_durably(fresh, target)
    assert seen == ["fresh: old", "folder: new"]
    assert target.read_bytes() == b"new"
    assert not fresh.exists()


def test_what_is_refused_of_a_draft_is_said_of_the_file_and_no_draft_is_left(tmp_path: Path) -> None:
    target, other = tmp_path / "scene.glb", tmp_path / "texture.png"

    def refused_at(draft: bool) -> None:
        with draft_folder(target) as folder:
            (folder / "draft").write_bytes(b"half")
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(folder / "draft" if draft else other))

    for draft, named in ((True, target), (False, other)):
        with pytest.raises(OSError, match="No space left") as told:
            refused_at(draft)
        assert told.value.filename == str(named)
        assert told.value.errno == errno.ENOSPC
    assert list(tmp_path.iterdir()) == []


def test_a_disk_is_full_where_another_program_failed_without_a_reason(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = tmp_path / "skin.abc"
    check_space(tmp_path, target)
    monkeypatch.setattr("lappet.core.durable.shutil.disk_usage", lambda _: SimpleNamespace(free=4096))
    with pytest.raises(OSError, match="No space left") as told:
        check_space(tmp_path, target)
    assert told.value.filename == str(target)
