"""Files that are whole after a power failure: the content reaches the disk before the name does."""

from __future__ import annotations

import contextlib
import errno
import os
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

_NOTHING_LEFT = 65536  # bytes: a disk that has less is full


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


@contextlib.contextmanager
def draft_folder(target: Path) -> Iterator[Path]:
    """Make a hidden folder beside a file for the drafts of it, which is gone afterwards.

    Parameters
    ----------
    target
        The file.

    Yields
    ------
    Path
        The folder, in the file system of the file.

    Raises
    ------
    OSError
        If the file system refuses; names the file where it is one of the folder that was refused.
    """
    with tempfile.TemporaryDirectory(prefix=f".{target.stem}-", dir=target.parent) as folder:
        try:
            yield Path(folder)
        except OSError as error:
            if error.filename is None or not Path(os.fsdecode(error.filename)).is_relative_to(folder):
                raise
            raise OSError(error.errno, error.strerror, str(target)) from error


def check_space(folder: Path, target: Path) -> None:
    """Check that a disk is not full, after another program has failed to write to it without a reason.

    Parameters
    ----------
    folder
        Where it wrote; what it has written must still be there.
    target
        The file, for the error.

    Raises
    ------
    OSError
        If there is no space left; names the file.
    """
    if shutil.disk_usage(folder).free < _NOTHING_LEFT:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(target))


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
