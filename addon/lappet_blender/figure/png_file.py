"""Pictures appear whole or not at all: a draft gets its name when it ends as a PNG does."""

from __future__ import annotations

from pathlib import Path

from lappet.core.durable import check_space
from lappet.drawing.skin_source import FigureError

_BEGINS, _ENDS = b"\x89PNG\r\n\x1a\n", b"\x00\x00\x00\x00IEND\xaeB`\x82"


def publish_png(draft: Path, path: Path) -> None:
    """Give a draft its name. Blender says nothing when the disk is full and leaves a part of a file, or none.

    Raises FigureError where the draft is no whole picture; it is removed then.
    """
    data = draft.read_bytes() if draft.is_file() else b""
    if not (data.startswith(_BEGINS) and data.endswith(_ENDS)):
        try:
            check_space(path.parent, path)
        except OSError as error:
            raise FigureError(f"{path}: {error.strerror}; free some space, or choose another folder.") from error
        finally:
            draft.unlink(missing_ok=True)
        raise FigureError(
            f"Blender wrote no whole picture to {path}; see whether the folder is writable and has space."
        )
    draft.replace(path)
