"""Files that are the user's own: regular, reached through no link, and written by nobody else.

What is found in their place, a link, a pipe, another user's file, counts as absent and is removed. Where the system has
no owners and modes of files (Windows) only their kind is looked at.
"""

from __future__ import annotations

import contextlib
import errno
import io
import os
import secrets
import stat
import tempfile
from pathlib import Path

_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH
_OTHERS = stat.S_IRWXG | stat.S_IRWXO
_READ = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
_SECRET_BYTES = 32
_LINK = (errno.ELOOP, errno.EMLINK, errno.ENXIO)  # what opening a link or a socket says


def own_folder(folder: Path) -> None:
    """Make a folder that only the user may enter, or take from others the right to write to one that is there.

    Parameters
    ----------
    folder
        The folder; it may be named by a link.

    Raises
    ------
    OSError
        If it cannot be made.
    NotADirectoryError
        If something else is there.
    PermissionError
        If it is another user's.
    """
    if not folder.is_dir():
        folder.parent.mkdir(parents=True, exist_ok=True)
        with contextlib.suppress(FileExistsError):
            folder.mkdir(mode=0o700)
    found = folder.stat()
    if not stat.S_ISDIR(found.st_mode):
        raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR), str(folder))
    if not _is_users(found):
        raise PermissionError(errno.EPERM, "the folder belongs to another user", str(folder))
    if os.name == "posix" and found.st_mode & _OTHERS_WRITE:
        folder.chmod(stat.S_IMODE(found.st_mode) & ~_OTHERS_WRITE)


def own_subfolder(folder: Path) -> None:
    """Make a folder in a folder of the user's own; what is no folder in its place is removed.

    Parameters
    ----------
    folder
        The folder.

    Raises
    ------
    OSError
        If the file system refuses.
    """
    if not is_folder(folder):
        remove(folder)
        folder.mkdir(mode=0o700, exist_ok=True)


def is_folder(path: Path) -> bool:
    """Tell whether a path is a folder itself and no link to one.

    Parameters
    ----------
    path
        The path.

    Returns
    -------
    bool
        Whether it is.
    """
    try:
        return stat.S_ISDIR(path.lstat().st_mode)
    except OSError:
        return False


def is_own_file(path: Path) -> bool:
    """Tell whether a path is a file of the user's own.

    Parameters
    ----------
    path
        The path.

    Returns
    -------
    bool
        Whether it is.
    """
    try:
        return _is_own(path.lstat(), _OTHERS_WRITE)
    except OSError:
        return False


def read_own(path: Path, *, forbidden: int = _OTHERS_WRITE) -> bytes | None:
    """Read a file of the user's own; anything else in its place is removed.

    Parameters
    ----------
    path
        The file.
    forbidden
        Rights that nobody but the user may have, as bits of a mode.

    Returns
    -------
    bytes | None
        What it holds, or None where there is no such file or it cannot be read.
    """
    try:
        handle = os.open(path, _READ)
    except OSError as error:
        if error.errno in _LINK:
            remove(path)
        return None
    try:
        with contextlib.suppress(OSError):
            if _is_own(os.fstat(handle), forbidden):
                return io.FileIO(handle, closefd=False).readall()
            remove(path)
    finally:
        os.close(handle)
    return None


def own_secret(path: Path) -> bytes:
    """Read the secret that a file holds, which nobody but the user may read, or make a new one.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    bytes
        The secret, the same for every process that asks.

    Raises
    ------
    OSError
        If the file system refuses.
    """
    for _ in range(3):  # another process may make or remove it meanwhile
        found = read_own(path, forbidden=_OTHERS)
        if found is not None and len(found) == _SECRET_BYTES:
            return found
        remove(path)
        handle, name = tempfile.mkstemp(prefix=".secret-", dir=path.parent)
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(secrets.token_bytes(_SECRET_BYTES))
            with contextlib.suppress(FileExistsError):
                os.link(name, path)  # whole or not at all, and never over one that is there
        finally:
            Path(name).unlink(missing_ok=True)
    raise OSError(errno.EIO, "the key of the store cannot be kept", str(path))


def remove(path: Path) -> None:
    """Remove a file, or what stands in its place; a folder stays.

    Parameters
    ----------
    path
        The path.
    """
    with contextlib.suppress(OSError):
        path.unlink()


def _is_own(found: os.stat_result, forbidden: int) -> bool:
    mode = found.st_mode
    return stat.S_ISREG(mode) and _is_users(found) and not (os.name == "posix" and mode & forbidden)


def _is_users(found: os.stat_result) -> bool:
    return os.name != "posix" or found.st_uid == os.geteuid()
