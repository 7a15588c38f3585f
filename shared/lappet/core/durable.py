"""Files that are whole after a power failure: the content reaches the disk before the name does."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path


def replace_durably(fresh: Path, target: Path) -> None:
    """Give a file that is written another's name, once the disk holds its content.

    Parameters
    ----------
    fresh
        The file, closed; in the same file system.
    target
        Its name from now on.

    Raises
    ------
    OSError
        If the file system refuses.
    """
    with fresh.open("rb+") as file:
        os.fsync(file.fileno())
    fresh.replace(target)
    sync_folder(target.parent)


def write_whole(path: Path, content: bytes) -> None:
    """Write a file so that it is whole or not there: a full disk leaves what had its name before.

    Parameters
    ----------
    path
        The file.
    content
        What it holds.

    Raises
    ------
    OSError
        If the file system refuses; names the file.
    """
    draft = path.with_name(f".{path.name}.part")
    try:
        draft.write_bytes(content)
        replace_durably(draft, path)
    except OSError as error:
        with contextlib.suppress(OSError):
            draft.unlink(missing_ok=True)
        raise OSError(error.errno, error.strerror, str(path)) from error


def sync_folder(folder: Path) -> None:
    """Wait until the disk holds the names in a folder.

    Parameters
    ----------
    folder
        The folder.

    Raises
    ------
    OSError
        If it cannot be opened.
    """
    if os.name != "posix":
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        with contextlib.suppress(OSError):  # some file systems sync no folders; the file itself is safe
            os.fsync(handle)
    finally:
        os.close(handle)
