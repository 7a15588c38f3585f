"""A file gets its name after the disk has its content."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from lappet.core.durable import replace_durably


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
