"""What strangers can cost a daemon with keys before it knows them, and what those whom it knows can.

Each test sends bytes as no client of ours would, through plain sockets where ZeroMQ would not.
"""

from __future__ import annotations

import contextlib
import random
import resource
import socket
import struct
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
import zmq

from keyed_daemon import KeyedDaemon

pytestmark = [
    pytest.mark.slow,
    pytest.mark.timeout(120),
    pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="memory is measured in /proc"),
]

KIB = 1024
MIB = 1024 * KIB
PLACES = 128  # for peers that are not known
COST = 64 * KIB  # of each


def greeting(mechanism: bytes) -> bytes:
    """The 64 bytes with which a peer of ZMTP 3.1 begins."""
    return b"\xff" + bytes(8) + b"\x7f\x03\x01" + mechanism.ljust(20, b"\0") + bytes(32)


@pytest.fixture(autouse=True)
def descriptors() -> Iterator[None]:
    limits = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(4096, limits[1]), limits[1]))
    yield
    resource.setrlimit(resource.RLIMIT_NOFILE, limits)


@pytest.fixture
def keyed(binary: Path, tmp_path: Path) -> Iterator[KeyedDaemon]:
    with KeyedDaemon(binary, tmp_path) as daemon:
        with daemon.peer("anna") as anna:  # whatever is made once for all is made now
            assert anna.ask("ping").type == "pong"
        for _ in range(3):
            with connect(daemon) as stranger:
                stranger.sendall(greeting(b"CURVE") + 3000 * b"x")
                stranger.recv(64)
        yield daemon


def connect(daemon: KeyedDaemon) -> socket.socket:
    return socket.create_connection(daemon.host_and_port(), timeout=5.0)


def crowd(daemon: KeyedDaemon, count: int, stack: contextlib.ExitStack) -> list[socket.socket]:
    return [stack.enter_context(connect(daemon)) for _ in range(count)]


def seconds_until_closed(connection: socket.socket, most: float) -> float:
    begun = time.monotonic()
    connection.settimeout(most)
    try:
        while connection.recv(4096):
            pass
    except TimeoutError:
        return most
    except OSError:
        pass
    return time.monotonic() - begun


def bytes_taken(connection: socket.socket, chunk: bytes, most: int) -> int:
    """How much of an endless stream is sent until the daemon closes the connection."""
    sent = 0
    connection.settimeout(3.0)
    try:
        while sent < most:
            connection.sendall(chunk)
            sent += len(chunk)
    except OSError:
        pass
    return sent


# --- strangers -----------------------------------------------------------------------------------------------------


def test_1013_idle_peers_shut_no_user_out_and_cost_little(keyed: KeyedDaemon) -> None:
    with contextlib.ExitStack() as stack, keyed.peer("bert") as known:
        before = keyed.memory()
        begun = time.monotonic()
        crowd(keyed, 1013, stack)
        assert known.ask("ping").type == "pong"
        asked = time.monotonic()
        with keyed.peer("anna") as anna:
            assert time.monotonic() - asked < 1.0
            assert anna.ask("ping").type == "pong"
            assert asked - begun < 2.0, "the idle peers were closed for their age before anybody asked"
        assert keyed.memory() - before < PLACES * COST


def test_a_daemon_with_few_descriptors_has_places_for_its_users(binary: Path, tmp_path: Path) -> None:
    daemon = KeyedDaemon(binary, tmp_path)
    daemon.launcher = ["/bin/sh", "-c", 'ulimit -n 160; exec "$0" "$@"']
    with daemon, contextlib.ExitStack() as stack:
        crowd(daemon, 300, stack)
        asked = time.monotonic()
        for name in ("anna", "bert", "root"):
            with daemon.peer(name) as peer:
                assert peer.ask("ping").type == "pong"
        assert time.monotonic() - asked < 2.0


def test_peers_that_keep_coming_shut_no_user_out(keyed: KeyedDaemon) -> None:
    with contextlib.ExitStack() as stack:
        for _ in range(10):
            crowd(keyed, 100, stack)
            begun = time.monotonic()
            with keyed.peer("anna"):
                assert time.monotonic() - begun < 1.0


@pytest.mark.parametrize(
    "begins",
    [
        greeting(b"CURVE"),
        greeting(b"NULL"),
        greeting(b"CURVE") + b"\x06" + struct.pack(">Q", 1 << 30) + 3900 * b"x",
        greeting(b"CURVE") + b"\x04\xc8\x05HELLO\x01" + 193 * b"x",
    ],
    ids=["greeting", "null", "long command", "false hello"],
)
def test_a_stranger_costs_64_kib_at_most(keyed: KeyedDaemon, begins: bytes) -> None:
    with contextlib.ExitStack() as stack:
        count = 50  # fewer than handshakes in a second, so that each has all that a stranger can have
        before = keyed.memory()
        for connection in crowd(keyed, count, stack):
            connection.sendall(begins)
        time.sleep(0.5)
        assert keyed.memory() - before < count * COST
    with keyed.peer("anna") as anna:
        assert anna.ask("ping").type == "pong"


@pytest.mark.parametrize(
    ("begins", "then"),
    [
        (b"", b"\xff" * 4096),
        (b"", bytes(4096)),
        (greeting(b"NULL"), (b"\x01\x08" + bytes(8)) * 400),  # parts of a message that does not end
        (greeting(b"CURVE"), (b"\x01\x08" + bytes(8)) * 400),
        (greeting(b"CURVE") + b"\x06" + struct.pack(">Q", 1 << 40), bytes(4096)),  # a command of a terabyte
        (greeting(b"CURVE") + b"\x02" + struct.pack(">Q", 1 << 29), bytes(4096)),
    ],
    ids=["signature", "zeros", "null parts", "curve parts", "command", "frame"],
)
def test_a_stranger_sends_4_kib_at_most(keyed: KeyedDaemon, begins: bytes, then: bytes) -> None:
    before = keyed.memory()
    with connect(keyed) as connection:
        connection.sendall(begins)
        sent = bytes_taken(connection, then, 64 * MIB)
    # What the daemon's system took meanwhile is not the daemon's: its buffers, a few megabytes on one computer.
    assert sent < 8 * MIB
    assert keyed.memory() - before < COST
    with keyed.peer("anna") as anna:
        assert anna.ask("ping").type == "pong"


@pytest.mark.parametrize("begins", [b"", b"\xff", greeting(b"CURVE")[:20], greeting(b"CURVE")])
def test_a_stranger_who_does_not_go_on_is_closed_after_two_seconds(keyed: KeyedDaemon, begins: bytes) -> None:
    with connect(keyed) as connection:
        connection.sendall(begins)
        assert 1.0 < seconds_until_closed(connection, 5.0) < 3.0


def test_a_stranger_who_goes_on_slowly_is_closed_as_soon(keyed: KeyedDaemon) -> None:
    with connect(keyed) as connection:
        begun = time.monotonic()
        with contextlib.suppress(OSError):
            while time.monotonic() - begun < 6.0:
                connection.sendall(b"\xff")
                time.sleep(0.1)
        assert time.monotonic() - begun < 3.5


def test_bytes_that_make_no_sense_end_nothing(keyed: KeyedDaemon) -> None:
    """Beginnings of handshakes with bytes changed, left out or put in at random, the same ones in each run."""
    source = random.Random(14)
    whole = greeting(b"CURVE") + b"\x04\xc8\x05HELLO\x01" + bytes(72) + source.randbytes(120)
    with contextlib.ExitStack() as stack:
        for _ in range(400):
            told = bytearray(whole)
            for _ in range(source.randrange(1, 6)):
                place = source.randrange(len(told))
                told[place : place + source.randrange(3)] = source.randbytes(source.randrange(4))
            connection = stack.enter_context(connect(keyed))
            connection.sendall(bytes(told[: source.randrange(1, len(told) + 1)]))
            time.sleep(0.005)
        with keyed.peer("anna") as anna:
            assert anna.ask("ping").type == "pong"


def test_handshakes_from_one_address_are_counted(binary: Path, tmp_path: Path) -> None:
    with (
        KeyedDaemon(binary, tmp_path, "--handshakes-per-second", "4") as daemon,
        contextlib.ExitStack() as stack,
    ):
        answered = 0
        connections = crowd(daemon, 40, stack)
        for connection in connections:
            connection.sendall(greeting(b"CURVE"))
        for connection in connections:
            connection.settimeout(1.0)
            with contextlib.suppress(OSError):
                answered += bool(connection.recv(64))
        assert 4 <= answered <= 12  # four at once, and four a second
        begun = time.monotonic()
        with daemon.peer("anna"):
            assert time.monotonic() - begun < 3.0


# --- users ---------------------------------------------------------------------------------------------------------


def test_a_user_who_says_no_hello_is_closed(keyed: KeyedDaemon) -> None:
    with keyed.peer("anna", greet=False) as anna:
        monitor = anna.socket.get_monitor_socket(zmq.EVENT_DISCONNECTED)
        begun = time.monotonic()
        assert monitor.poll(8000), "it was not closed"
        assert 3.0 < time.monotonic() - begun < 7.0


@pytest.mark.parametrize(
    ("name", "greet", "most"),
    [("fred", True, 1 * MIB), ("anna", False, 1 * MIB), ("anna", True, 8 * MIB)],
    ids=["follower", "before hello", "author"],
)
@pytest.mark.parametrize("parts", [1, 400_000])
def test_a_message_that_is_too_long_is_cut_off(
    binary: Path, tmp_path: Path, name: str, greet: bool, most: int, parts: int
) -> None:
    """A follower's message has 64 KiB at most, as has anybody's before `hello`; an author's what `welcome` says."""
    with KeyedDaemon(binary, tmp_path, "--max-message-bytes", str(MIB)) as daemon:
        with daemon.peer("root") as root:
            assert root.ask("ping").type == "pong"
        before = largest = daemon.memory()
        with daemon.peer(name, greet=greet) as peer:
            monitor = peer.socket.get_monitor_socket(zmq.EVENT_DISCONNECTED)
            begun = time.monotonic()
            peer.socket.send_multipart([bytes(40_000_000 // parts)] * parts)
            while not monitor.poll(20) and time.monotonic() - begun < 10.0:
                largest = max(largest, daemon.memory())
            assert time.monotonic() - begun < 4.0, "it was not cut off"
        assert largest - before < most
        with daemon.peer(name) as peer:
            assert peer.ask("ping").type == "pong"


def test_a_user_has_eight_connections_and_takes_no_place_of_another(keyed: KeyedDaemon) -> None:
    with contextlib.ExitStack() as stack:
        for _ in range(8):
            stack.enter_context(keyed.peer("anna"))
        ninth = stack.enter_context(keyed.peer("anna", greet=False))
        assert not ninth.is_heard(1.0)
        with keyed.peer("bert") as bert:
            assert bert.ask("ping").type == "pong"


def test_a_place_is_free_as_soon_as_its_user_has_gone(keyed: KeyedDaemon) -> None:
    for _ in range(30):
        with keyed.peer("anna") as anna:
            assert anna.ask("ping").type == "pong"


def test_messages_of_one_user_are_read_at_a_rate_and_hold_up_nobody(binary: Path, tmp_path: Path) -> None:
    arguments = ("--messages-per-second", "20")
    with KeyedDaemon(binary, tmp_path, *arguments) as daemon, daemon.peer("anna") as anna, daemon.peer("bert") as bert:
        begun = time.monotonic()
        for _ in range(60):
            anna.send("ping")
        first = time.monotonic()
        assert bert.ask("ping").type == "pong"
        assert time.monotonic() - first < 0.5
        for _ in range(60):
            assert anna.receive().type == "pong"
        assert 1.5 < time.monotonic() - begun < 6.0  # 20 at once, then 20 a second
