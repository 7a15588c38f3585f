"""A daemon with keys: who is let in, and who may send what (PROTOCOL.md, "Keys" and "Roles")."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pytest
import zmq

from box_scene import epoch_arrays, open_fields
from keyed_daemon import KeyedDaemon, KeyedPeer, until, write

pytestmark = [
    pytest.mark.slow,
    pytest.mark.timeout(120),
    pytest.mark.skipif(os.name != "posix", reason="there is a broker on POSIX systems only"),
]

LEAST = {
    **dict.fromkeys(("hello", "ping", "bye", "follow"), "follower"),
    **dict.fromkeys(("open", "epoch", "state", "solve", "close", "cancel", "share"), "author"),
    "shutdown": "admin",
}
ORDER = ("follower", "author", "admin")


@pytest.fixture
def keyed(binary: Path, tmp_path: Path) -> KeyedDaemon:
    return KeyedDaemon(binary, tmp_path)


def refused_to_start(daemon: KeyedDaemon) -> str:
    done = subprocess.run(
        daemon.command(), stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=10, check=False
    )
    assert done.returncode == 1, done
    assert not done.stdout
    return done.stderr


def test_a_user_with_a_key_is_served(keyed: KeyedDaemon) -> None:
    with keyed as daemon, daemon.peer("anna") as anna:
        assert anna.ask("open", open_fields()).type == "opened"
        assert anna.ask("epoch", {"index": 0}, epoch_arrays()).type == "lattice"


def test_an_unknown_key_another_server_and_no_key_at_all_are_never_heard(keyed: KeyedDaemon) -> None:
    with keyed as daemon:
        stranger = tuple(key.decode() for key in zmq.curve_keypair())
        for pair, server in ((stranger, None), (daemon.pairs["anna"], stranger[0])):
            peer = KeyedPeer(daemon, pair, greet=False, server_key=server)
            assert not peer.is_heard(1.0)
            peer.close()
        context = zmq.Context()
        plain = context.socket(zmq.DEALER)
        plain.connect(daemon.address)
        plain.send(b"hello")
        assert not plain.poll(1000)
        context.destroy(linger=0)
        with daemon.peer("anna") as anna:
            assert anna.ask("ping").type == "pong"


def test_every_message_has_a_least_role(keyed: KeyedDaemon) -> None:
    roles = {"fred": "follower", "anna": "author", "root": "admin"}
    with keyed as daemon:
        for name, role in roles.items():
            for kind, least in LEAST.items():
                if kind == "shutdown" and role == "admin":
                    continue  # below
                with daemon.peer(name) as peer:
                    reply = peer.ask(kind, {"client": "x"} if kind == "hello" else {})
                    refused = reply.type == "error" and reply.fields["code"] == "unauthorized"
                    assert refused == (ORDER.index(role) < ORDER.index(least)), (name, kind, reply)
                    if refused:
                        assert f"needs the role {least}" in reply.fields["message"]
        with daemon.peer("root") as root:
            assert root.ask("shutdown").type == "accepted"
        assert until(lambda: not daemon.alive())
        assert daemon.process is not None
        assert daemon.process.returncode == 0
        daemon.__enter__()  # the fixture's end wants one that lives


def test_the_table_of_roles_is_that_of_the_protocol() -> None:
    text = (Path(__file__).parents[2] / "PROTOCOL.md").read_text(encoding="utf-8")
    table = text.split("### Roles", 1)[1].split("\n\n", 3)
    rows = [line.strip("| ").split(" | ") for part in table for line in part.splitlines() if line.startswith("| `")]
    told = {kind.strip("` "): row[0].strip("` ") for row in rows for kind in row[1].split(",")}
    assert told == LEAST


def test_a_revoked_user_is_refused_from_the_next_message_on(keyed: KeyedDaemon) -> None:
    with keyed as daemon, daemon.peer("anna") as anna, daemon.peer("bert") as bert:
        assert anna.ask("open", open_fields()).type == "opened"
        assert bert.ask("open", open_fields()).type == "opened"
        assert len(daemon.solvers()) == 2
        daemon.revoke("anna")
        time.sleep(1.0)
        assert anna.code("ping") == "unauthorized"
        assert until(lambda: len(daemon.solvers()) == 1), "the session of a revoked user goes on"
        assert bert.ask("epoch", {"index": 0}, epoch_arrays()).type == "lattice"
        with daemon.peer("anna", greet=False) as again:
            assert not again.is_heard(1.0)
        daemon.allow("anna", "author")
        with daemon.peer("anna") as again:
            assert again.ask("ping").type == "pong"


def test_a_user_with_another_key_or_role_is_another_from_the_next_message_on(keyed: KeyedDaemon) -> None:
    with keyed as daemon, daemon.peer("anna") as anna, daemon.peer("bert") as bert:
        del daemon.pairs["anna"]
        daemon.allow("anna", "author")  # a new key
        daemon.allow("bert", "follower")
        time.sleep(1.0)
        assert anna.code("ping") == "unauthorized"
        assert bert.code("open", open_fields()) == "unauthorized"
        with daemon.peer("anna") as new:
            assert new.ask("ping").type == "pong"


def test_a_file_that_is_wrong_later_is_no_user_and_harms_no_other(keyed: KeyedDaemon) -> None:
    with keyed as daemon, daemon.peer("anna") as anna, daemon.peer("bert") as bert:
        write(daemon.users / "anna.pub", f"public = {daemon.pairs['anna'][0]}\nrole = author\ncolor = red\n", 0o644)
        write(daemon.users / "copy.pub", (daemon.users / "fred.pub").read_text(), 0o644)  # fred's key twice
        time.sleep(1.0)
        assert anna.code("ping") == "unauthorized"
        assert bert.ask("ping").type == "pong"
        with daemon.peer("fred", greet=False) as fred:
            assert not fred.is_heard(1.0)
        log = daemon.log.read_text()
        assert "anna.pub', line 3: 'color' is not known here" in log
        assert "one key twice" in log


@pytest.mark.parametrize(
    ("break_it", "says"),
    [
        (lambda d: d.keys.chmod(0o750), "closed to others"),
        (lambda d: (d.keys / "server.key").chmod(0o640), "chmod 600"),
        (lambda d: (d.users / "anna.pub").chmod(0o666), "chmod 644"),
        (lambda d: (d.keys / "server.key").unlink(), "cannot be read"),
        (lambda d: write(d.keys / "server.key", "public = x\nsecret = y\n", 0o600), "line 1: 'public' is no key"),
        (lambda d: d.write_server_key(d.pairs["anna"][0]), "do not belong together"),
        (lambda d: write(d.users / "anna.pub", f"# hers\npublic: {'x' * 40}\n", 0o644), "anna.pub', line 2"),
        (lambda d: d.allow("anna", "king"), "'king' is not known"),
        (lambda d: d.allow("anna", "author", threads=0), "line 3: 'threads' is '0'"),
        (lambda d: d.allow("anna", "author", sessions=1.5), "'sessions' is '1.5'"),
        (lambda d: d.allow("Anna", "author"), "names no user"),
        (lambda d: write(d.users / "carl.pub", (d.users / "anna.pub").read_text(), 0o644), "one key twice"),
        (lambda d: write(d.users / "anna.pub", "# " + 5000 * "x", 0o644), "more than 4096 bytes"),
        (lambda d: write(d.users / "anna.pub", "public = a\0b\n", 0o644), "is no text"),
        (lambda d: (d.users / "link.pub").symlink_to(d.users / "anna.pub"), "link.pub' cannot be read"),
        (lambda d: os.mkfifo(d.users / "pipe.pub"), "is not a regular file"),
    ],
)
def test_a_folder_of_keys_that_is_wrong_is_refused_with_its_place(
    keyed: KeyedDaemon, break_it: object, says: str
) -> None:
    assert callable(break_it)
    break_it(keyed)
    sentence = refused_to_start(keyed)
    assert says in sentence
    assert keyed.server_secret not in sentence


@pytest.mark.skipif(os.name != "posix" or os.geteuid() != 0, reason="only root can be another user")
def test_files_are_the_daemons_users_own_or_roots(binary: Path) -> None:
    nobody = 65534
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        folder.chmod(0o755)
        program = folder / "lappet-solverd"
        shutil.copy(binary, program)
        daemon = KeyedDaemon(program, folder)
        become = f"import os, sys; os.setgid({nobody}); os.setuid({nobody}); os.execv(sys.argv[1], sys.argv[1:])"
        daemon.launcher = [sys.executable, "-c", become]
        for path in (daemon.keys, daemon.users, daemon.keys / "server.key"):
            os.chown(path, nobody, nobody)
        with daemon, daemon.peer("anna") as anna:  # her file is root's
            assert anna.ask("ping").type == "pong"
        os.chown(daemon.users / "anna.pub", 1234, 1234)
        assert "belongs to another user" in refused_to_start(daemon)
        os.chown(daemon.users / "anna.pub", nobody, nobody)
        os.chown(daemon.keys, 1234, 1234)
        daemon.keys.chmod(0o777)
        assert "must belong to the daemon's user" in refused_to_start(daemon)


def test_a_comment_and_a_key_may_hold_any_character_of_a_key(keyed: KeyedDaemon) -> None:
    """`#` and `=` are digits of Z85."""
    while not {"#", "="} <= set(keyed.pairs["anna"][0]):
        del keyed.pairs["anna"]
        keyed.allow("anna", "author")
    path = keyed.users / "anna.pub"
    write(path, "# anna = hers\n\n  " + path.read_text(), 0o644)
    with keyed as daemon, daemon.peer("anna") as anna:
        assert anna.ask("ping").type == "pong"


def test_without_keys_only_this_computer_is_served(binary: Path) -> None:
    for address in ("tcp://0.0.0.0:*", "tcp://*:*", "tcp://192.0.2.1:5000", "tcp://[::]:*"):
        done = subprocess.run(
            [binary, "--listen", address], input="", capture_output=True, text=True, timeout=10, check=False,
            env={**os.environ, "LAPPET_TOKEN": "secret"},
        )  # fmt: skip
        assert done.returncode == 1
        assert "only loopback is served" in done.stderr


@pytest.mark.parametrize("address", ["tcp://0.0.0.0:0", "tcp://*:*", "tcp://[::1]:0"])
def test_with_keys_it_listens_where_it_is_told(keyed: KeyedDaemon, address: str) -> None:
    keyed.listen = address
    with keyed as daemon:
        host = "[::1]" if "[" in address else "127.0.0.1"
        assert daemon.address.startswith(f"tcp://{address[6:-2].replace('*', '0.0.0.0')}:")
        daemon.address = f"tcp://{host}:{daemon.host_and_port()[1]}"
        with daemon.peer("anna") as anna:
            assert anna.ask("ping").type == "pong"


@pytest.mark.parametrize("address", ["tcp://nowhere", "tcp://256.0.0.1:0", "udp://127.0.0.1:0", "tcp://127.0.0.1:x"])
def test_an_address_that_makes_no_sense_is_refused(keyed: KeyedDaemon, address: str) -> None:
    keyed.listen = address
    assert "cannot listen on" in refused_to_start(keyed)
