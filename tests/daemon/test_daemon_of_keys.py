"""The real daemon with keys, as its client knows it: one of the client's own over TCP, and one that several share."""

from __future__ import annotations

import os
import stat
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from box_scene import box, pull
from lappet.core.problem_code import ProblemCode
from lappet.cutting.epoch import Epoch
from lappet.daemon.client import DaemonRefuses, SolverClient, SolverRefused
from lappet.daemon.key_files import new_pair, read_public
from lappet.daemon.process import SolverDaemon
from lappet.daemon.running_daemon import ClientKeys, RunningDaemon
from lappet.daemon.solved_frame import SolvedFrame
from lappet.program.settings import SolverSettings
from shared_daemon import SharedDaemon

pytestmark = [pytest.mark.slow, pytest.mark.timeout(120)]
SETTINGS = SolverSettings(spacing=1.0, threads=1)


def solved(client: SolverClient) -> SolvedFrame:
    client.open(SETTINGS)
    client.set_epoch(Epoch(0, 1.0, box(), 1))
    return client.solve(pull())


# --- one's own, over TCP -------------------------------------------------------------------------------------------


def test_a_daemon_of_one_s_own_over_tcp_has_fresh_keys_and_no_token(binary: Path) -> None:
    with SolverDaemon(binary, listen="tcp://127.0.0.1:0") as daemon, SolverDaemon(binary) as usual:
        assert daemon.address.startswith("tcp://127.0.0.1:")
        assert daemon.keys is not None
        assert usual.keys is None
        folder = Path(_argument(daemon, "--keys"))
        assert stat.S_IMODE(folder.stat().st_mode) == 0o700
        assert f"LAPPET_TOKEN={daemon.token}".encode() not in Path(f"/proc/{daemon.pid}/environ").read_bytes()
        assert daemon.keys.own.secret not in "".join(each.read_text() for each in folder.rglob("*") if each.is_file())
        with SolverClient(daemon=daemon) as client, SolverClient(daemon=usual) as other:
            frame, same = solved(client), solved(other)
            assert frame.converged
            np.testing.assert_array_equal(frame.points, same.points)
        with SolverDaemon(binary, listen="tcp://127.0.0.1:0") as second:
            assert second.keys is not None
            assert second.keys.server != daemon.keys.server
            assert second.keys.own != daemon.keys.own
    assert not folder.parent.exists()
    assert not daemon.alive()


def test_where_no_socket_is_possible_keys_take_its_place(binary: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("lappet.daemon.process._LONGEST_ADDRESS", 1)
    with SolverDaemon(binary) as daemon, SolverClient(daemon=daemon) as client:
        assert daemon.address.startswith("tcp://127.0.0.1:")
        assert daemon.keys is not None
        assert client.ping() < 1.0


def test_where_a_daemon_knows_no_keys_it_asks_for_the_token(binary: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("lappet.daemon.process._HAS_BROKER", False)
    with SolverDaemon(binary) as daemon, SolverClient(daemon=daemon) as client:
        assert daemon.address.startswith("tcp://127.0.0.1:")
        assert daemon.keys is None
        assert client.ping() < 1.0


@pytest.mark.skipif(os.name != "posix", reason="sockets lie in no folder here")
def test_a_folder_of_the_user_s_with_a_long_name_is_no_hindrance(
    binary: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    deep = tmp_path / ("deep" * 25)
    deep.mkdir()
    monkeypatch.setenv("TMPDIR", str(deep))
    monkeypatch.setattr("tempfile.tempdir", None)
    with SolverDaemon(binary) as daemon, SolverClient(daemon=daemon) as client:
        assert daemon.address.startswith("ipc:///tmp/lappet-")
        assert client.ping() < 1.0
    assert list(deep.iterdir()) == []


def test_others_on_this_computer_do_not_reach_a_daemon_of_one_s_own_over_tcp(binary: Path) -> None:
    with SolverDaemon(binary, listen="tcp://127.0.0.1:0") as daemon:
        assert daemon.keys is not None
        for stranger, code in (
            (SolverClient(daemon.address, daemon.token), ProblemCode.DAEMON_WITH_KEYS),
            (
                SolverClient(daemon.address, keys=ClientKeys(daemon.keys.server, new_pair())),
                ProblemCode.DAEMON_KEY_UNKNOWN,
            ),
            (
                SolverClient(daemon.address, keys=ClientKeys(new_pair().public, daemon.keys.own)),
                ProblemCode.DAEMON_OTHER_KEY,
            ),
        ):
            with pytest.raises(DaemonRefuses) as error, stranger:
                pass
            assert error.value.problems[0].code == code
        with SolverClient(daemon=daemon) as client:
            assert client.ping() < 1.0


def _argument(daemon: SolverDaemon, name: str) -> str:
    arguments = Path(f"/proc/{daemon.pid}/cmdline").read_text().split("\0")
    return arguments[arguments.index(name) + 1]


# --- one that several share, as docs/sharing_a_daemon.md says --------------------------------------------------------


@pytest.fixture
def shared(binary: Path, tmp_path: Path) -> Iterator[SharedDaemon]:
    with SharedDaemon(binary, tmp_path) as daemon:
        yield daemon


def client_of(daemon: RunningDaemon) -> SolverClient:
    return SolverClient(daemon.address, keys=daemon.keys())


def test_an_author_solves_until_revoked_and_is_then_refused_within_a_second(shared: SharedDaemon) -> None:
    anna = shared.user("anna", "author")
    with client_of(anna) as client:
        assert solved(client).converged
        shared.administer("revoke", "anna")
        time.sleep(1.0)
        with pytest.raises((SolverRefused, DaemonRefuses)) as error:
            client.ping()
        assert error.value.problems[0].code in (ProblemCode.SOLVER_UNAUTHORIZED, ProblemCode.DAEMON_KEY_UNKNOWN)
    with pytest.raises(DaemonRefuses) as refused, client_of(anna):
        pass
    assert refused.value.problems[0].code == ProblemCode.DAEMON_KEY_UNKNOWN


def test_what_a_role_does_not_permit_is_a_problem_and_another_role_permits_it_at_once(shared: SharedDaemon) -> None:
    ben = shared.user("ben", "follower")
    with client_of(ben) as client:
        assert client.ping() < 1.0
        with pytest.raises(SolverRefused) as error:
            client.open(SETTINGS)
        assert error.value.problems[0].code == ProblemCode.SOLVER_UNAUTHORIZED
        assert "author" in str(error.value)
        assert client.ping() < 1.0
    key = read_public(str(shared.folder / "users" / "ben.pub"))
    shared.administer("allow", "ben", "--key", key, "--role", "author")
    with client_of(ben) as client:
        assert solved(client).converged


def test_the_daemon_keeps_the_quotas_that_the_command_line_wrote(shared: SharedDaemon) -> None:
    anna = shared.user("anna", "author", "--sessions", "1", "--threads", "1", "--memory-gib", "0.5", "--seconds", "30")
    with client_of(anna) as first, client_of(anna) as second:
        assert first.welcome["threads"] == 1
        first.open(SETTINGS)
        with pytest.raises(SolverRefused) as error:
            second.open(SETTINGS)
        assert "sessions of anna" in str(error.value)
