"""The real daemon and its client: PROTOCOL.md, message by message, and what happens when either end dies."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import msgpack
import numpy as np
import pytest
import zmq
from numpy.typing import NDArray

from lappet.client import DaemonDied, DaemonMissing, SolveCancelled, SolverClient, SolverRefused
from lappet.daemon import SolverDaemon, find_daemon
from lappet.frame_solver import Iteration
from lappet.program import Epoch, FrameConstraints, SolverSettings, Surface
from lappet.wire import Message, WireError, decode, encode

pytestmark = [pytest.mark.slow, pytest.mark.timeout(120)]


@pytest.fixture(scope="module")
def binary() -> Path:
    try:
        return find_daemon()
    except DaemonMissing as reason:
        pytest.skip(str(reason))


@pytest.fixture
def daemon(binary: Path) -> Iterator[SolverDaemon]:
    with SolverDaemon(binary, arguments=("--max-message-bytes", "4000000", "--max-clients", "4")) as running:
        yield running
        assert running.alive(), f"the daemon did not live through the test: {running.death()}"


class Raw:
    """A DEALER that sends whatever it is told."""

    def __init__(self, daemon: SolverDaemon, *, greet: bool = True) -> None:
        self.context = zmq.Context()
        self.socket: zmq.Socket[bytes] = self.context.socket(zmq.DEALER)
        self.socket.setsockopt(zmq.LINGER, 0)
        self.socket.connect(daemon.address)
        self.ids = iter(range(1, 10_000))
        if greet:
            assert self.ask("hello", {"token": daemon.token, "client": "raw"}).type == "welcome"

    def receive(self, timeout: float = 10.0) -> Message:
        while self.socket.poll(int(timeout * 1000)):
            message = decode(self.socket.recv_multipart())
            if message.type != "progress":
                return message
        raise AssertionError(f"no reply within {timeout} s")

    def send(self, kind: str, fields: dict[str, Any] | None = None, arrays: dict[str, Any] | None = None) -> int:
        identifier = next(self.ids)
        self.socket.send_multipart(encode(Message(kind, identifier, None, fields or {}, arrays or {})))
        return identifier

    def ask(self, kind: str, fields: dict[str, Any] | None = None, arrays: dict[str, Any] | None = None) -> Message:
        identifier = self.send(kind, fields, arrays)
        reply = self.receive()
        assert reply.id == identifier
        return reply

    def refused(self, *frames: bytes) -> tuple[str, str]:
        self.socket.send_multipart(frames)
        reply = self.receive()
        assert reply.type == "error", reply
        return reply.fields["code"], reply.fields["message"]

    def close(self) -> None:
        self.context.destroy(linger=0)


@pytest.fixture
def raw(daemon: SolverDaemon) -> Iterator[Raw]:
    with contextlib.closing(Raw(daemon)) as peer:
        yield peer


def box(size: tuple[float, float, float] = (4.0, 4.0, 2.0)) -> Surface:
    """A closed box, fixed below."""
    points = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float) * size
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))], np.int32)
    m = len(triangles)
    below = np.isin(np.arange(m), (8, 9))
    return Surface(
        points, triangles, np.zeros((m, 3, 2), np.float32), np.zeros(m, np.uint8), below, np.zeros(m, np.bool_)
    )


def pull(time_code: float = 1.0, by: float = 0.2) -> FrameConstraints:
    """A hook on the upper face of the box, drawn upwards."""
    return FrameConstraints(
        time_code,
        0,
        hook_anchors=np.array([[2.0, 1.0, 2.0]]),
        hook_triangles=np.array([10], np.int32),
        hook_targets=np.array([[2.0, 1.0, 2.0 + by]]),
        hook_stiffness=np.array([10.0]),
    )


def epoch_arrays(**changes: Any) -> dict[str, NDArray[Any]]:
    surface = box()
    m = len(surface.triangles)
    arrays = {
        "points": surface.points,
        "triangles": surface.triangles,
        "fixed": surface.fixed.astype(np.uint8),
        "bed": surface.bed.astype(np.uint8),
        "grip": np.full(m, -1, np.int32),
        "landmarks": np.zeros((0, 3)),
        "landmark_triangles": np.zeros(0, np.int32),
        **changes,
    }
    return {name: array for name, array in arrays.items() if array is not None}


def open_fields(**changes: Any) -> dict[str, Any]:
    settings = {
        "spacing": 1.0, "fine_ratio": 4, "origin": [0.0, 0.0, 0.0], "quadrature": 1, "precision": "float",
        "tolerance": 1e-3, "gap_tolerance": 1e-3, "max_newton": 100, "bed_stiffness": 10.0, "gravity": [0.0, 0.0, 0.0],
        "time_budget": 0.0, "memory_budget": 1 << 30, "threads": 1, "sutures": 2, "retractors": 0,
    }  # fmt: skip
    material = {"model": "neoHookean", "youngs_modulus": 50.0, "poissons_ratio": 0.45, "density": 1100.0}
    return {"settings": {**settings, **changes}, "material": material}


@contextlib.contextmanager
def long_solve(client: SolverClient) -> Iterator[FrameConstraints]:
    """Prepares a solve that lasts for many seconds: a tolerance that no arithmetic reaches, on 8 000 cells."""
    size = (24.0, 24.0, 6.0)
    client.open(SolverSettings(spacing=0.75, precision="double", tolerance=1e-12, max_newton=1000, threads=1))
    client.set_epoch(Epoch(0, 1.0, box(size), 1))
    yield FrameConstraints(
        1.0,
        0,
        hook_anchors=np.array([[12.0, 6.0, 6.0]]),
        hook_triangles=np.array([10], np.int32),
        hook_targets=np.array([[20.0, 12.0, 14.0]]),
        hook_stiffness=np.array([500.0]),
    )


class Started:
    """Runs an action once the solve has reported progress, from another thread."""

    def __init__(self, action: Callable[[], object]) -> None:
        self.action = action
        self.at = 0.0
        self.iterations: list[Iteration] = []

    def __call__(self, iteration: Iteration) -> None:
        self.iterations.append(iteration)
        if len(self.iterations) == 1:
            self.at = time.monotonic()
            threading.Thread(target=self.action).start()


# --- what the daemon answers ---------------------------------------------------------------------------------------


def test_a_frame_is_solved_and_its_state_goes_on(daemon: SolverDaemon) -> None:
    with SolverClient(daemon=daemon) as client:
        assert client.welcome["threads"] >= 1
        assert client.welcome["max_message_bytes"] == 4_000_000
        assert client.open(SolverSettings(spacing=1.0, sutures=2, threads=1)) >= 1
        counts = client.set_epoch(Epoch(0, 1.0, box(), 1))
        assert counts["cells"] > 0
        seen: list[Iteration] = []
        first = client.solve(pull(1.0, 0.2), seen.append)
        assert first.converged
        assert first.points.shape == (8, 3)
        assert first.points.dtype == np.float32
        assert first.time == 1.0
        assert first.hook_forces.shape == (1, 3)
        assert first.state.suture_gaps.shape == (2, 3)
        assert all(iteration.time == 1.0 for iteration in seen)
        second = client.solve(pull(2.0, 0.4))
        client.set_state(first.state)
        again = client.solve(pull(2.0, 0.4))
        for name, array in second.arrays.items():
            np.testing.assert_array_equal(again.arrays[name], array, err_msg=name)
        with pytest.raises(AttributeError, match="no 'colour'"):
            _ = first.colour


def test_a_wrong_token_is_refused_and_nothing_is_served_before_hello(daemon: SolverDaemon) -> None:
    peer = Raw(daemon, greet=False)
    with contextlib.closing(peer):
        for kind in ("ping", "open", "epoch", "state", "solve", "cancel", "close", "bye", "shutdown"):
            assert peer.ask(kind).fields["code"] == "out_of_order"
        reply = peer.ask("hello", {"token": daemon.token[:-1], "client": "raw"})
        assert reply.fields["code"] == "unauthorized"
        assert peer.ask("ping").fields["code"] == "out_of_order"
    with pytest.raises(SolverRefused, match="token is wrong") as error, SolverClient(daemon.address, "guess"):
        pass
    assert error.value.code == "unauthorized"


def test_large_messages_are_not_read_before_hello(daemon: SolverDaemon) -> None:
    with contextlib.closing(Raw(daemon, greet=False)) as peer:
        reply = peer.ask("epoch", {"index": 0}, {"points": np.zeros((40_000, 3))})
        assert reply.fields["code"] == "malformed"
        assert "before 'hello'" in reply.fields["message"]


@pytest.mark.parametrize(
    "frame",
    [b"", b"\x00", b"\xc1", b"not msgpack", b"\xff" * 1000, b"\x91" * 60_000, b"\xdf\xff\xff\xff\xff", b"x" * 100_000],
)
def test_malformed_headers_are_answered(raw: Raw, frame: bytes) -> None:
    code, sentence = raw.refused(frame)
    assert code == "malformed"
    assert sentence.endswith(".")
    assert raw.ask("ping").type == "pong"


@pytest.mark.parametrize(
    ("header", "says"),
    [
        ({"v": 1, "type": "ping", "id": 5}, "no list 'arrays'"),
        ({"v": 7, "type": "ping", "id": 5, "arrays": []}, "version 7"),
        ({"v": 1, "type": "dance", "id": 5, "arrays": []}, "'dance' is not known"),
        ({"v": 1, "type": "frame", "id": 5, "arrays": []}, "'frame' is not known"),
        ({"v": 1, "type": 5, "id": 5, "arrays": []}, "'type'"),
        ({"v": 1, "type": "ping", "id": -5, "arrays": []}, "'id'"),
        ({"v": 1, "type": "ping", "id": "5", "arrays": []}, "'id'"),
        ({"v": 1, "type": "ping", "id": 5, "arrays": [], "x": b"\x00"}, "neither number"),
        ({"v": 1, "type": "ping", "id": 5, "arrays": [], "x": 1}, "does not know"),
        ({"v": 1, "type": "ping", "id": 5, "session": -1, "arrays": []}, "'session'"),
        ({"v": 1, "type": "ping", "id": 5, "arrays": [{"name": "a", "dtype": "O", "shape": [1]}]}, "dtype 'O'"),
        ({"v": 1, "type": "ping", "id": 5, "arrays": [{"name": "a", "dtype": "f8", "shape": [2**60]}]}, "too large"),
        ({"v": 1, "type": "ping", "id": 5, "arrays": [{"name": "a", "dtype": "f8", "shape": [2**20]}]}, "4000000"),
    ],
)
def test_headers_that_break_the_protocol_are_answered(raw: Raw, header: dict[str, Any], says: str) -> None:
    code, sentence = raw.refused(msgpack.packb(header))
    assert code == "malformed"
    assert says in sentence
    assert raw.ask("ping").type == "pong"


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"points": np.zeros((8, 2))}, "shape (8, 2)"),
        ({"points": np.zeros((8, 3), np.float32)}, "dtype f4"),
        ({"points": np.full((8, 3), np.nan)}, "holds nan"),
        ({"points": None}, "no array 'points'"),
        ({"triangles": np.full((12, 3), 8, np.int32)}, "there are 8 surface points"),
        ({"triangles": np.full((12, 3), -1, np.int32)}, "holds -1"),
        ({"fixed": np.zeros(11, np.uint8)}, "shape (11)"),
        ({"grip": np.zeros(12, np.int32)}, "'grip' holds 0"),
        ({"landmarks": np.zeros((2, 3))}, "'landmark_triangles'"),
        ({"colour": np.zeros(3)}, "'colour'"),
    ],
)
def test_epochs_that_make_no_sense_are_named(raw: Raw, changes: dict[str, Any], says: str) -> None:
    assert raw.ask("open", open_fields()).type == "opened"
    reply = raw.ask("epoch", {"index": 0}, epoch_arrays(**changes))
    assert reply.fields["code"] in ("malformed", "invalid_input")
    assert says in reply.fields["message"]
    assert raw.ask("epoch", {"index": 0}, epoch_arrays()).type == "lattice"


def test_truncated_and_missing_array_frames_are_answered(raw: Raw) -> None:
    raw.ask("open", open_fields())
    frames = encode(Message("epoch", 500, None, {"index": 0}, epoch_arrays()))
    assert raw.refused(frames[0], frames[1][:-1], *frames[2:])[0] == "malformed"
    assert raw.refused(frames[0], frames[1] + b"\x00", *frames[2:])[0] == "malformed"
    assert raw.refused(*frames[:-1])[0] == "malformed"
    assert raw.refused(*frames, b"")[0] == "malformed"
    assert raw.refused(frames[0], *[b""] * 500)[0] == "malformed"
    assert raw.ask("epoch", {"index": 0}, epoch_arrays()).type == "lattice"


@pytest.mark.parametrize(
    ("changes", "code", "says"),
    [
        ({"spacing": "1"}, "malformed", "'spacing' of 'settings' is a text"),
        ({"spacing": 0.0}, "invalid_input", "spacing"),
        ({"spacing": float("nan")}, "invalid_input", "finite"),
        ({"origin": [0.0, 0.0]}, "malformed", "three numbers"),
        ({"threads": 2**40}, "invalid_input", "threads"),
        ({"sutures": -1}, "invalid_input", "sutures"),
        ({"fine_ratio": 4.5}, "malformed", "whole number"),
        ({"precision": "half"}, "invalid_input", "half"),
        ({"quadrature": 3}, "invalid_input", "quadrature"),
        ({"color": 1}, "malformed", "'color'"),
    ],
)
def test_settings_that_make_no_sense_are_named(raw: Raw, changes: dict[str, Any], code: str, says: str) -> None:
    reply = raw.ask("open", open_fields(**changes))
    assert (reply.fields["code"], says in reply.fields["message"]) == (code, True), reply.fields
    assert raw.ask("open", open_fields()).type == "opened"


def test_what_comes_out_of_order_is_refused_and_the_session_goes_on(raw: Raw) -> None:
    solve = {
        name: np.asarray(getattr(pull(), name))
        for name in FrameConstraints.__dataclass_fields__
        if name not in ("time", "epoch")
    }
    assert raw.ask("epoch", {"index": 0}, epoch_arrays()).fields["code"] == "out_of_order"
    assert raw.ask("close").fields["code"] == "out_of_order"
    assert raw.ask("open", open_fields()).type == "opened"
    assert raw.ask("solve", {"time": 1.0}, solve).fields["code"] == "out_of_order"
    assert raw.ask("open", open_fields()).fields["code"] == "out_of_order"
    assert raw.ask("epoch", {"index": 0}, epoch_arrays()).type == "lattice"
    far = {**solve, "hook_triangles": np.array([12], np.int32)}
    assert "there are 12 triangles" in raw.ask("solve", {"time": 1.0}, far).fields["message"]
    short = {**solve, "hook_targets": np.zeros((2, 3))}
    assert raw.ask("solve", {"time": 1.0}, short).fields["code"] == "malformed"
    assert raw.ask("solve", {"time": float("inf")}, solve).fields["code"] == "invalid_input"
    assert raw.ask("solve", {"time": 1.0}, solve).type == "frame"
    state = {
        "nodes": np.zeros((1, 3), np.float32),
        "suture_gaps": np.zeros((2, 3)),
        "suture_multipliers": np.zeros((2, 3)),
        "grip_multipliers": np.zeros(0),
    }
    assert raw.ask("state", {"precision": "float"}, state).fields["code"] == "invalid_input"
    assert raw.ask("state", {"precision": "double"}, state).fields["code"] == "malformed"
    assert raw.ask("close").type == "accepted"
    assert raw.ask("open", open_fields()).type == "opened"


def test_garbage_from_a_raw_socket_does_not_kill_it(daemon: SolverDaemon, raw: Raw) -> None:
    host, port = daemon.address.removeprefix("tcp://").split(":")
    rng = np.random.default_rng(7)
    for start in (b"", b"GET / HTTP/1.1\r\n\r\n", b"\xff" + bytes(8) + b"\x7f\x03", b"\x01\x00"):
        with socket.create_connection((host, int(port)), timeout=5) as connection, contextlib.suppress(OSError):
            connection.sendall(start + rng.bytes(200_000))
    assert raw.ask("ping").type == "pong"


def test_two_clients_have_sessions_of_their_own(daemon: SolverDaemon) -> None:
    with SolverClient(daemon=daemon) as first, SolverClient(daemon.address, daemon.token) as second:
        numbers = {client.open(SolverSettings(threads=1)) for client in (first, second)}
        assert len(numbers) == 2
        first.set_epoch(Epoch(0, 1.0, box(), 1))
        with pytest.raises(SolverRefused, match="'epoch' first"):
            second.solve(pull())
        second.set_epoch(Epoch(0, 1.0, box((4.0, 4.0, 3.0)), 1))
        assert first.solve(FrameConstraints(1.0, 0)).points[:, 2].max() == pytest.approx(2.0, abs=1e-3)
        assert second.solve(FrameConstraints(1.0, 0)).points[:, 2].max() == pytest.approx(3.0, abs=1e-3)


def test_clients_that_leave_make_room(daemon: SolverDaemon) -> None:
    for _ in range(3):
        with contextlib.ExitStack() as stack:
            end = time.monotonic() + 10.0
            clients = 0
            while clients < 4:  # those of the turn before may still be leaving
                try:
                    stack.enter_context(SolverClient(daemon.address, daemon.token))
                    clients += 1
                except SolverRefused:
                    assert time.monotonic() < end
                    time.sleep(0.05)
            with pytest.raises(SolverRefused, match="4 clients already"):
                stack.enter_context(SolverClient(daemon.address, daemon.token))


# --- while a solve runs ------------------------------------------------------------------------------------------


def test_a_ping_is_answered_and_a_cancel_obeyed_while_a_solve_runs(daemon: SolverDaemon) -> None:
    answered: list[float] = []

    with SolverClient(daemon=daemon) as client, long_solve(client) as frame:

        def ping_then_cancel() -> None:
            with SolverClient(daemon.address, daemon.token) as other:
                answered.append(other.ping())
            client.cancel()

        started = Started(ping_then_cancel)
        with pytest.raises(SolveCancelled) as error:
            client.solve(frame, started)
        assert time.monotonic() - started.at < 10.0
        assert error.value.code == "cancelled"
        assert answered
        assert answered[0] < 1.0
        client.open(SolverSettings(threads=1))
        client.set_epoch(Epoch(0, 1.0, box(), 1))
        assert client.solve(pull()).converged


def test_ctrl_c_cancels_the_solve_and_the_session_goes_on(daemon: SolverDaemon) -> None:
    with SolverClient(daemon=daemon) as client, long_solve(client) as frame:
        started = Started(lambda: os.kill(os.getpid(), signal.SIGINT))
        with pytest.raises(KeyboardInterrupt):
            client.solve(frame, started)
        assert time.monotonic() - started.at < 10.0
        assert client.ping() < 1.0
        client.open(SolverSettings(threads=1))
        client.set_epoch(Epoch(0, 1.0, box(), 1))
        assert client.solve(pull()).converged


def test_an_error_in_the_progress_callback_cancels_the_solve(daemon: SolverDaemon) -> None:
    def fail(_: Iteration) -> None:
        raise RuntimeError("the window is gone")

    with SolverClient(daemon=daemon) as client, long_solve(client) as frame:
        with pytest.raises(RuntimeError, match="the window is gone"):
            client.solve(frame, fail)
        assert client.ping() < 1.0


# --- life and death ----------------------------------------------------------------------------------------------


def test_a_daemon_killed_in_a_solve_is_noticed_within_two_seconds(binary: Path) -> None:
    with SolverDaemon(binary) as daemon, SolverClient(daemon=daemon) as client, long_solve(client) as frame:
        pid = daemon.pid
        assert pid is not None
        started = Started(lambda: os.kill(pid, signal.SIGKILL))
        with pytest.raises(DaemonDied, match="SIGKILL"):
            client.solve(frame, started)
        assert time.monotonic() - started.at < 2.0
        with pytest.raises(DaemonDied):
            client.ping()


def test_a_daemon_that_hangs_is_noticed(binary: Path) -> None:
    with SolverDaemon(binary) as daemon, SolverClient(daemon=daemon, silence=1.0) as client:
        assert daemon.pid is not None
        os.kill(daemon.pid, signal.SIGSTOP)
        try:
            with pytest.raises(DaemonDied, match="not answered for 1 s"):
                client.ping()
        finally:
            os.kill(daemon.pid, signal.SIGCONT)


def test_nobody_at_the_address_is_an_error_that_says_so() -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
        with pytest.raises(DaemonDied, match="is it running there"), SolverClient(address, "x", silence=0.5):
            pass
    with pytest.raises(DaemonMissing, match="is no address"), SolverClient("nowhere", "x"):
        pass


def test_the_daemon_ends_with_its_client_even_when_that_is_killed(binary: Path) -> None:
    program = (
        "import sys, time\n"
        "from lappet.client import SolverClient\n"
        "from lappet.daemon import SolverDaemon\n"
        "daemon = SolverDaemon(sys.argv[1]).start()\n"
        "client = SolverClient(daemon=daemon).connect()\n"
        "print(daemon.pid, flush=True)\n"
        "time.sleep(60)\n"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    with subprocess.Popen(
        [sys.executable, "-c", program, str(binary)], stdout=subprocess.PIPE, env=environment, text=True
    ) as client:
        assert client.stdout is not None
        pid = int(client.stdout.readline())
        assert Path(f"/proc/{pid}").exists()
        client.kill()
        client.wait()
        end = time.monotonic() + 5.0
        while _runs(pid) and time.monotonic() < end:
            time.sleep(0.05)
        assert not _runs(pid)


def _runs(pid: int) -> bool:
    with contextlib.suppress(OSError):
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    return False


def test_the_client_leaves_no_process_behind(binary: Path) -> None:
    with SolverDaemon(binary) as daemon, SolverClient(daemon=daemon) as client, long_solve(client):
        pid = daemon.pid
    assert pid is not None
    assert not _runs(pid)
    assert not [thread for thread in threading.enumerate() if thread.name == "lappet-heartbeat"]


def test_shutdown_ends_it(binary: Path) -> None:
    with SolverDaemon(binary) as daemon, contextlib.closing(Raw(daemon)) as peer:
        assert peer.ask("shutdown").type == "accepted"
        end = time.monotonic() + 5.0
        while daemon.alive() and time.monotonic() < end:
            time.sleep(0.02)
        assert not daemon.alive()
        assert "status 0" in daemon.death()


def test_silence_ends_it_and_a_heartbeat_keeps_it(binary: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("lappet.connection._HEARTBEAT_SECONDS", 0.2)
    monkeypatch.setattr("lappet.connection._PING_SECONDS", 0.1)
    with SolverDaemon(binary, arguments=("--silence", "1.5")) as daemon:
        with SolverClient(daemon=daemon) as client:
            time.sleep(3.0)
            assert client.ping() < 1.0
        end = time.monotonic() + 5.0
        while daemon.alive() and time.monotonic() < end:
            time.sleep(0.05)
        assert not daemon.alive()
        assert "heard nothing" in daemon.death()


@pytest.mark.parametrize(
    "address", ["tcp://0.0.0.0:*", "tcp://*:*", "tcp://192.0.2.1:5000", "ipc:///tmp/lappet", "tcp://127.0.0.1"]
)
def test_it_listens_on_loopback_only(binary: Path, address: str) -> None:
    with pytest.raises(DaemonDied, match=r"only loopback is served"):
        SolverDaemon(binary, arguments=("--address", address)).start()


def test_it_does_not_start_without_a_token(binary: Path) -> None:
    environment = {name: value for name, value in os.environ.items() if name != "LAPPET_TOKEN"}
    done = subprocess.run([binary], input="", capture_output=True, text=True, timeout=10, env=environment, check=False)
    assert done.returncode == 1
    assert "LAPPET_TOKEN is not set" in done.stderr
    assert subprocess.run([binary, "--nonsense"], capture_output=True, timeout=10, check=False).returncode == 2


def test_a_frame_of_another_epoch_and_a_message_too_large_are_not_sent(daemon: SolverDaemon) -> None:
    with SolverClient(daemon=daemon) as client:
        client.open(SolverSettings(threads=1))
        client.set_epoch(Epoch(0, 1.0, box(), 1))
        with pytest.raises(ValueError, match="belongs to epoch 3"):
            client.solve(FrameConstraints(1.0, 3))
        many = Surface(
            np.zeros((200_000, 3)),
            np.zeros((1, 3), np.int32),
            np.zeros((1, 3, 2), np.float32),
            np.zeros(1, np.uint8),
            np.zeros(1, np.bool_),
            np.zeros(1, np.bool_),
        )
        with pytest.raises(WireError, match="coarser surface"):
            client.set_epoch(Epoch(1, 2.0, many, 1))
        assert client.ping() < 1.0


# --- finding and starting it ---------------------------------------------------------------------------------------


def test_a_missing_daemon_is_named_with_the_mend(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("LAPPET_SOLVERD", str(tmp_path / "nothing"))
    with pytest.raises(DaemonMissing, match=r"LAPPET_SOLVERD names .*nothing.*unset it"):
        find_daemon()
    monkeypatch.delenv("LAPPET_SOLVERD")
    monkeypatch.setattr("lappet.daemon.BINARY", "no-such-daemon")
    with pytest.raises(DaemonMissing, match="make setup"):
        find_daemon()


@pytest.mark.parametrize(
    ("script", "kind", "says"),
    [
        ("echo 'no licence' >&2; exit 3", DaemonDied, r"status 3.*no licence"),
        ("kill -SEGV $$", DaemonDied, "SIGSEGV"),
        ("echo hello", DaemonMissing, "not a Lappet daemon"),
        ("echo starting up >&2; exec sleep 20", DaemonDied, r"did not listen within 0.5 s.*starting up"),
    ],
)
def test_a_program_that_does_not_start_is_named_with_its_last_words(
    tmp_path: Path, script: str, kind: type[Exception], says: str
) -> None:
    program = tmp_path / "lappet-solverd"
    program.write_text(f"#!/bin/sh\n{script}\n")
    program.chmod(0o755)
    with pytest.raises(kind, match=says):
        SolverDaemon(program, start_timeout=0.5).start()
