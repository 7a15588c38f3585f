"""The client of a daemon with keys: it pins the daemon's, shows its own, and says nothing before both are proved."""

from __future__ import annotations

import os
import stat
import time
from pathlib import Path

import pytest

from curve_server import CurveServer
from lappet.core.problem import RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.daemon.client import DaemonRefuses, SolverClient, SolverRefused
from lappet.daemon.key_files import KeyPair, new_pair, read_pair
from lappet.daemon.key_writing import new_own
from lappet.daemon.keys_folder import KeysFolder, Role, User
from lappet.daemon.running_daemon import ClientKeys, RunningDaemon
from lappet.daemon.wire import Message
from lappet.program.settings import SolverSettings


@pytest.fixture
def folder(tmp_path: Path) -> KeysFolder:
    """A daemon's folder of keys; nobody may use it yet."""
    made = KeysFolder(tmp_path / "keys")
    made.make_server()
    return made


@pytest.fixture
def server_pair(folder: KeysFolder) -> KeyPair:
    return read_pair(folder.server_key)


def allowed(folder: KeysFolder, name: str = "anna") -> KeyPair:
    pair = new_pair()
    folder.allow(User(name, pair.public, Role.AUTHOR))
    return pair


def refusal(client: SolverClient) -> ProblemCode:
    begun = time.monotonic()
    with pytest.raises(DaemonRefuses) as error, client:
        pass
    assert time.monotonic() - begun < 5.0  # not only after the silence of 20 s
    return error.value.problems[0].code


def test_a_known_user_is_greeted_and_no_token_is_sent(
    folder: KeysFolder, server_pair: KeyPair, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LAPPET_TOKEN", "of another daemon")
    own = allowed(folder)
    with CurveServer(server_pair, folder) as server:
        with SolverClient(server.address, keys=ClientKeys(server_pair.public, own)) as client:
            assert client.welcome["version"] == "9.9"
            assert client.ping() < 2.0
        hello = server.messages[0]
    assert (hello.type, hello.fields["client"]) == ("hello", "lappet")
    assert "token" not in hello.fields


def test_a_daemon_with_another_key_is_refused_before_anything_is_sent(folder: KeysFolder, server_pair: KeyPair) -> None:
    own = allowed(folder)
    with CurveServer(new_pair(), folder) as stranger:
        client = SolverClient(stranger.address, keys=ClientKeys(server_pair.public, own))
        assert refusal(client) == ProblemCode.DAEMON_OTHER_KEY
        assert stranger.messages == []


def test_a_daemon_without_keys_is_refused_before_anything_is_sent(folder: KeysFolder, server_pair: KeyPair) -> None:
    own = allowed(folder)
    with CurveServer(None) as stranger:
        client = SolverClient(stranger.address, keys=ClientKeys(server_pair.public, own))
        assert refusal(client) == ProblemCode.DAEMON_OTHER_KEY
        assert stranger.messages == []


def test_a_user_who_is_not_known_or_no_longer_is_told_so(folder: KeysFolder, server_pair: KeyPair) -> None:
    own = allowed(folder)
    keys = ClientKeys(server_pair.public, own)
    with CurveServer(server_pair, folder) as server:
        with SolverClient(server.address, keys=keys):
            pass
        assert refusal(SolverClient(server.address, keys=ClientKeys(server_pair.public, new_pair()))) == (
            ProblemCode.DAEMON_KEY_UNKNOWN
        )
        folder.revoke("anna")
        assert refusal(SolverClient(server.address, keys=keys)) == ProblemCode.DAEMON_KEY_UNKNOWN


def test_a_client_without_keys_is_told_to_give_some(folder: KeysFolder, server_pair: KeyPair) -> None:
    with CurveServer(server_pair, folder) as server:
        assert refusal(SolverClient(server.address, "token")) == ProblemCode.DAEMON_WITH_KEYS
        assert server.messages == []


def test_what_a_role_does_not_permit_comes_back_as_a_problem(folder: KeysFolder, server_pair: KeyPair) -> None:
    own = allowed(folder)
    with CurveServer(server_pair, folder) as server:
        server.replies["open"] = Message(
            "error",
            0,
            None,
            {"code": "unauthorized", "message": "'open' needs the role author; anna is a follower."},
            {},
        )
        with (
            SolverClient(server.address, keys=ClientKeys(server_pair.public, own)) as client,
            pytest.raises(SolverRefused) as error,
        ):
            client.open(SolverSettings(spacing=1.0))
    assert error.value.problems[0].code == ProblemCode.SOLVER_UNAUTHORIZED
    assert "needs the role author" in str(error.value)


def test_a_connection_that_was_lost_and_is_refused_says_so_at_once(folder: KeysFolder, server_pair: KeyPair) -> None:
    own = allowed(folder)
    with CurveServer(server_pair, folder) as server:
        client = SolverClient(server.address, keys=ClientKeys(server_pair.public, own)).connect()
    port = int(server.address.rpartition(":")[2])
    try:
        with CurveServer(new_pair(), folder, port=port) as other:
            begun = time.monotonic()
            with pytest.raises(DaemonRefuses) as error:
                client.ping()
            assert time.monotonic() - begun < 10.0
            assert error.value.problems[0].code == ProblemCode.DAEMON_OTHER_KEY
            assert other.messages == []
    finally:
        client.close()


# --- whom the token may be told ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "address",
    [
        "tcp://192.0.2.7:5570",
        "tcp://lappet.example:5570",
        "tcp://[2001:db8::7]:5570",
        "tcp://127.0.0.1.example.org:5570",
        "tcp://*:5570",
        "ws://127.0.0.1:5570",
    ],
)
def test_another_computer_s_daemon_needs_keys(address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LAPPET_TOKEN", "secret")
    with pytest.raises(RefusedError) as error:
        RunningDaemon(address).keys()
    assert [each.code for each in error.value.problems] == [ProblemCode.DAEMON_NEEDS_KEYS]
    with pytest.raises(RefusedError) as error, SolverClient(address):
        pass
    assert [each.code for each in error.value.problems] == [ProblemCode.DAEMON_NEEDS_KEYS]


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:5570", "tcp://127.8.9.10:1", "tcp://[::1]:5570"])
def test_a_daemon_of_this_computer_needs_none(address: str) -> None:
    assert RunningDaemon(address).keys() is None


@pytest.mark.skipif(os.name != "posix", reason="sockets lie in no folder here")
def test_a_socket_where_others_may_listen_gets_no_token(tmp_path: Path) -> None:
    assert RunningDaemon(f"ipc://{tmp_path}/socket").keys() is None
    tmp_path.chmod(0o777)
    for address in (f"ipc://{tmp_path}/socket", "ipc://@lappet"):
        with pytest.raises(RefusedError) as error, SolverClient(address, "secret"):
            pass
        assert error.value.problems[0].code == ProblemCode.DAEMON_OF_ANOTHER


def test_one_key_without_the_other_is_named(tmp_path: Path) -> None:
    secret, public, pair = new_own(tmp_path / "own", "anna")
    for daemon in (
        RunningDaemon("tcp://192.0.2.7:5570", key=str(secret)),
        RunningDaemon("tcp://127.0.0.1:5570", server_key=pair.public),
    ):
        with pytest.raises(RefusedError) as error:
            daemon.keys()
        assert error.value.problems[0].code == ProblemCode.DAEMON_KEY_MISSING
    both = RunningDaemon("tcp://192.0.2.7:5570", str(public), str(secret)).keys()
    assert both == ClientKeys(pair.public, pair)
    assert pair.secret not in repr(both)


def test_a_secret_key_that_others_may_read_is_not_used(tmp_path: Path) -> None:
    secret, public, _ = new_own(tmp_path / "own", "anna")
    assert stat.S_IMODE(secret.stat().st_mode) == 0o600
    secret.chmod(0o640)
    with pytest.raises(RefusedError) as error:
        RunningDaemon("tcp://192.0.2.7:5570", str(public), str(secret)).keys()
    assert error.value.problems[0].code == ProblemCode.KEY_FILE_OPEN
    missing = RunningDaemon("tcp://192.0.2.7:5570", str(public), str(tmp_path / "nobody.key"))
    with pytest.raises(RefusedError) as error:
        missing.keys()
    assert error.value.problems[0].code == ProblemCode.KEY_UNREADABLE
