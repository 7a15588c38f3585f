"""What daemons leave that are killed together with their client is removed by a later start, and nothing else."""

from __future__ import annotations

import os
import socket
import tempfile
import time
from pathlib import Path

import pytest

from lappet.daemon.stale_sockets import SOCKET, remove_stale_folders

pytestmark = pytest.mark.skipif(os.name != "posix", reason="there are no such sockets")

HOUR = 3600.0


@pytest.fixture
def temporary(monkeypatch: pytest.MonkeyPatch, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder for temporary files; a socket's path must be short."""
    folder = tmp_path_factory.mktemp("t")
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    return folder


def left(temporary: Path, name: str, age: float = HOUR, mode: int = 0o700) -> Path:
    """A folder with a socket that nobody listens at."""
    folder = temporary / name
    folder.mkdir()
    with socket.socket(socket.AF_UNIX) as once:
        once.bind(str(folder / SOCKET))
    folder.chmod(mode)
    os.utime(folder, (time.time() - age, time.time() - age))
    return folder


def test_a_folder_whose_daemon_is_gone_is_removed(temporary: Path) -> None:
    gone = left(temporary, "lappet-gone")
    remove_stale_folders()
    assert not gone.exists()


def test_a_folder_at_whose_socket_somebody_listens_stays(temporary: Path) -> None:
    folder = temporary / "lappet-used"
    folder.mkdir(mode=0o700)
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(folder / SOCKET))
        listener.listen(1)
        os.utime(folder, (time.time() - HOUR, time.time() - HOUR))
        remove_stale_folders()
        assert (folder / SOCKET).exists()


def test_what_is_young_or_shared_or_holds_something_else_stays(temporary: Path) -> None:
    kept = [
        left(temporary, "lappet-young", age=1.0),
        left(temporary, "lappet-shared", mode=0o755),
        left(temporary, "other-gone"),
        left(temporary, "lappet-more"),
    ]
    (kept[-1] / "notes").write_text("mine")
    os.utime(kept[-1], (time.time() - HOUR, time.time() - HOUR))
    link = temporary / "lappet-link"
    link.symlink_to(kept[2])
    remove_stale_folders()
    assert all((folder / SOCKET).exists() for folder in kept)
    assert link.is_symlink()
