"""A picture that the disk had no room for is no picture."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from types import SimpleNamespace

import pytest

from lappet.drawing.skin_source import FigureError
from lappet_blender.figure.png_file import publish_png


def png(width: int, height: int) -> bytes:
    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = b"".join(b"\0" + bytes(range(width)) * 3 for _ in range(height))
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def test_a_whole_picture_gets_its_name(tmp_path: Path) -> None:
    draft, path = tmp_path / ".draft.png", tmp_path / "picture.png"
    draft.write_bytes(png(40, 30))
    publish_png(draft, path)
    assert path.read_bytes() == png(40, 30)
    assert not draft.exists()


@pytest.mark.parametrize("kept", [None, 0, 8, 100, -1, -12])
def test_a_part_of_a_picture_is_refused_and_the_old_one_stays(tmp_path: Path, kept: int | None) -> None:
    draft, path = tmp_path / ".draft.png", tmp_path / "picture.png"
    path.write_bytes(png(4, 3))
    if kept is not None:
        draft.write_bytes(png(40, 30)[:kept])
    with pytest.raises(FigureError, match="whether the folder is writable and has space"):
        publish_png(draft, path)
    assert path.read_bytes() == png(4, 3)
    assert not draft.exists()


def test_a_part_of_a_picture_on_a_full_disk_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    draft, path = tmp_path / ".draft.png", tmp_path / "picture.png"
    draft.write_bytes(png(40, 30)[:100])
    monkeypatch.setattr("lappet.core.durable.shutil.disk_usage", lambda _: SimpleNamespace(free=0))
    with pytest.raises(FigureError, match=r"picture\.png: No space left on device; free some space"):
        publish_png(draft, path)
    assert list(tmp_path.iterdir()) == []
