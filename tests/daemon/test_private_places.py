"""Where a daemon of one's own listens: places that nobody else has, and an error that says why there is none."""

from __future__ import annotations

import errno
import os
import socket
import tempfile
import time
from pathlib import Path

import pytest

from lappet.core.problem import RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.daemon import stale_sockets
from lappet.daemon.process import DaemonMissing, SolverDaemon
from lappet.daemon.running_daemon import RunningDaemon

posix = pytest.mark.skipif(os.name != "posix", reason="sockets lie in no folder here")


@posix
def test_a_disk_without_room_for_the_socket_is_a_problem_that_names_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An OSError would end a solve that has to start its daemon again, with all that it has solved."""

    def full(**_: object) -> str:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(tmp_path))

    monkeypatch.setattr(tempfile, "mkdtemp", full)
    with pytest.raises(DaemonMissing) as error:
        SolverDaemon("/bin/true").start()
    (problem,) = error.value.problems
    assert (problem.code, problem.prim) == (ProblemCode.FILE_ERROR, str(tmp_path))


@posix
def test_the_keys_that_a_full_disk_holds_in_part_are_removed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr("lappet.daemon.key_writing.os.fsync", full)
    with pytest.raises(DaemonMissing):
        SolverDaemon("/bin/true", listen="tcp://127.0.0.1:0").start()
    assert list(tmp_path.iterdir()) == []


@posix
def test_what_is_left_where_names_are_short_is_removed_too(
    tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A daemon listens there when the folder for temporary files has a long name."""
    temporary, short = tmp_path_factory.mktemp("t"), tmp_path_factory.mktemp("s")
    monkeypatch.setattr(tempfile, "tempdir", str(temporary))
    monkeypatch.setattr(stale_sockets, "SHORT", str(short))
    gone = short / f"{stale_sockets.PREFIX}gone"
    gone.mkdir(mode=0o700)
    with socket.socket(socket.AF_UNIX) as once:
        once.bind(str(gone / stale_sockets.SOCKET))
    os.utime(gone, (time.time() - 3600.0, time.time() - 3600.0))
    stale_sockets.remove_stale_folders()
    assert not gone.exists()


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:0;192.0.2.7:5570", "tcp://localhost:5570;lappet.example:1"])
def test_an_address_that_only_begins_on_this_computer_needs_keys(address: str) -> None:
    """ZeroMQ connects to what follows the semicolon; the token went there in clear."""
    with pytest.raises(RefusedError) as error:
        RunningDaemon(address).keys()
    assert [each.code for each in error.value.problems] == [ProblemCode.DAEMON_NEEDS_KEYS]
