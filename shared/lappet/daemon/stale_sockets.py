"""The folders of daemons' sockets: where they are made; what a daemon killed with its client left is removed later."""

from __future__ import annotations

import contextlib
import errno
import os
import shutil
import socket
import stat
import tempfile
import time
from pathlib import Path

PREFIX = "lappet-"
SOCKET = "socket"
SHORT = "/tmp"  # where the folder for temporary files has too long a name for a socket
_SECONDS = 60.0  # a younger one may be about to listen


def socket_places() -> tuple[str, ...]:
    """Find the folders in which those of sockets are made.

    Returns
    -------
    tuple[str, ...]
        The folder for temporary files first, then one with a short name.
    """
    return tuple(dict.fromkeys((tempfile.gettempdir(), SHORT)))


def remove_stale_folders() -> None:
    """Remove the user's own folders for sockets at which nobody listens any more; does nothing on Windows."""
    if os.name != "posix":
        return
    for place in socket_places():
        with contextlib.suppress(OSError):
            for folder in Path(place).glob(f"{PREFIX}*"):
                with contextlib.suppress(OSError):
                    if _is_stale(folder):
                        shutil.rmtree(folder, ignore_errors=True)


def _is_stale(folder: Path) -> bool:
    """Whether it is ours, private, not young, and holds nothing but a socket that refuses connections."""
    status = folder.lstat()
    private = stat.S_ISDIR(status.st_mode) and stat.S_IMODE(status.st_mode) == 0o700 and status.st_uid == os.getuid()
    if not private or time.time() - status.st_mtime < _SECONDS:
        return False
    place = folder / SOCKET
    if [each.name for each in folder.iterdir()] != [SOCKET] or not stat.S_ISSOCK(place.lstat().st_mode):
        return False
    with socket.socket(socket.AF_UNIX) as peer:
        peer.settimeout(1.0)
        return peer.connect_ex(str(place)) == errno.ECONNREFUSED
