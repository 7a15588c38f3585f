"""A daemon with keys has one process for each session: what happens to one happens to no other."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from box_scene import box, epoch_arrays, open_fields, pull
from keyed_daemon import KeyedDaemon, KeyedPeer, kill, memory_of, state_of, until
from lappet.daemon.process import SolverDaemon
from lappet.daemon.wire import Message, encode
from lappet.program.payloads import Payload, solve_payload
from lappet.program.program import FrameConstraints
from raw_peer import Raw

pytestmark = [
    pytest.mark.slow,
    pytest.mark.timeout(180),
    pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="processes are looked for in /proc"),
]

MIB = 1 << 20
LONG = {"spacing": 0.75, "precision": "double", "tolerance": 1e-12, "max_newton": 1000, "memory_budget": 4 << 30}
LARGE = (240.0, 240.0, 20.0)  # mm; a million cells


@pytest.fixture
def keyed(binary: Path, tmp_path: Path) -> Iterator[KeyedDaemon]:
    with KeyedDaemon(binary, tmp_path) as daemon:
        yield daemon


def frame(time_code: float = 1.0) -> Payload:
    return solve_payload(pull(time_code, 0.2 * time_code))


def prepare(peer: Raw, size: tuple[float, float, float] = (4.0, 4.0, 2.0), **settings: Any) -> None:
    assert peer.ask("open", open_fields(**settings)).type == "opened"
    assert peer.ask("epoch", {"index": 0}, epoch_arrays(points=box(size).points)).type == "lattice"


def solve(peer: Raw, time_code: float = 1.0) -> Message:
    told = frame(time_code)
    return peer.ask("solve", told.fields, told.arrays)


def begin_long_solve(peer: Raw) -> int:
    """Begin a solve that lasts for many seconds: a tolerance that no arithmetic reaches, on 65 000 cells."""
    prepare(peer, (48.0, 48.0, 12.0), **LONG)
    told = solve_payload(
        FrameConstraints(
            1.0,
            0,
            hook_index=np.zeros(1, np.int32),
            hook_anchors=np.array([[24.0, 12.0, 12.0]]),
            hook_triangles=np.array([10], np.int32),
            hook_targets=np.array([[40.0, 24.0, 28.0]]),
            hook_stiffness=np.array([500.0]),
        )
    )
    return peer.send("solve", told.fields, told.arrays)


def solver_of(
    daemon: KeyedDaemon, peer: KeyedPeer, size: tuple[float, float, float] = (4.0, 4.0, 2.0), **settings: Any
) -> int:
    """Open a session; the process that it got."""
    before = set(daemon.solvers())
    prepare(peer, size, **settings)
    (pid,) = set(daemon.solvers()) - before
    return pid


# --- one process for each session ----------------------------------------------------------------------------------


def test_frames_have_the_bits_of_a_daemon_of_ones_own(keyed: KeyedDaemon, binary: Path) -> None:
    with keyed.peer("anna") as anna, SolverDaemon(binary) as daemon:
        alone = Raw(daemon)
        for peer in (anna, alone):
            prepare(peer)
        for time_code in (1.0, 2.0, 3.0):
            ours, theirs = solve(anna, time_code), solve(alone, time_code)
            assert ours.type == theirs.type == "frame"
            for name, array in theirs.arrays.items():
                np.testing.assert_array_equal(ours.arrays[name], array, err_msg=name)
        alone.close()


@pytest.mark.parametrize("end", ["close", "bye", "connection"])
def test_a_process_ends_with_its_session(keyed: KeyedDaemon, end: str) -> None:
    with keyed.peer("bert") as bert:
        other = solver_of(keyed, bert)
        with keyed.peer("anna") as anna:
            begin_long_solve(anna)
            assert len(keyed.solvers()) == 2
            if end == "bye":
                assert anna.ask("bye").type == "accepted"
                assert anna.code("ping") == "out_of_order"
            elif end == "close":
                anna.send("cancel")
                anna.receive()
                anna.receive()
                assert anna.ask("close").type == "accepted"
            else:
                anna.close()
            assert until(lambda: keyed.solvers() == [other], 2.0)
        assert solve(bert).type == "frame"


@pytest.mark.parametrize(
    ("how", "code", "says"),
    [(signal.SIGSEGV, "internal", "signal 11"), (signal.SIGKILL, "memory_budget", "where memory is spent")],
)
def test_a_crash_is_one_sessions(keyed: KeyedDaemon, how: signal.Signals, code: str, says: str) -> None:
    with keyed.peer("anna") as anna, keyed.peer("bert") as bert:
        bystander = solver_of(keyed, bert)
        asked = begin_long_solve(anna)
        (victim,) = set(keyed.solvers()) - {bystander}
        time.sleep(0.3)
        kill(victim, how)
        killed = time.monotonic()
        reply = anna.receive()
        assert time.monotonic() - killed < 2.0
        assert (reply.id, reply.fields["code"]) == (asked, code)
        assert says in reply.fields["message"]
        assert anna.code("epoch", {"index": 0}, epoch_arrays()) == "out_of_order"  # no session
        assert solve(bert).type == "frame"
        prepare(anna)
        assert solve(anna).type == "frame"


def open_files(pid: int) -> set[str]:
    files = set()
    for entry in Path(f"/proc/{pid}/fd").iterdir():
        with contextlib.suppress(OSError):
            files.add(str(entry.readlink()))
    return files


def test_a_process_has_no_connection_of_another(keyed: KeyedDaemon) -> None:
    with keyed.peer("anna") as anna, keyed.peer("bert") as bert:
        first, second = solver_of(keyed, anna), solver_of(keyed, bert)
        kinds = ("socket:", "pipe:")
        ends = [{name for name in open_files(pid) if name.startswith(kinds)} for pid in (first, second, keyed.pid)]
        sockets = {name for name in ends[2] if name.startswith("socket:")}
        assert len(sockets) >= 5  # the door, and two ends of each connection
        assert not ends[0] & ends[1]
        assert not (ends[0] | ends[1]) & sockets


def test_a_process_that_hangs_holds_up_nobody(keyed: KeyedDaemon) -> None:
    with keyed.peer("anna") as anna, keyed.peer("bert") as bert:
        kill(solver_of(keyed, anna), signal.SIGSTOP)
        told = frame()
        anna.send("solve", told.fields, told.arrays)
        assert anna.ask("ping").type == "pong"
        prepare(bert)
        assert solve(bert).type == "frame"


def folder_of(solver: int) -> Path:
    """The folder of the broker whose process it is."""
    words = Path(f"/proc/{solver}/cmdline").read_text().split("\0")
    return Path(words[words.index("--address") + 1].removeprefix("ipc://")).parents[1]


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_no_process_outlives_the_broker(keyed: KeyedDaemon, how: signal.Signals) -> None:
    with keyed.peer("anna") as anna, keyed.peer("bert") as bert:
        begin_long_solve(anna)
        stopped = solver_of(keyed, bert)
        kill(stopped, signal.SIGSTOP)  # one that can do nothing about it
        pids = keyed.solvers()
        assert len(pids) == 2
        folder = folder_of(stopped)
        assert {entry.name[0] for entry in folder.iterdir()} == {"l", "s"}  # a lock, and the sessions' folders
        kill(keyed.pid, how)
        assert until(lambda: all(state_of(pid) == "Z" for pid in pids), 3.0)
    assert keyed.process is not None
    status = keyed.process.wait(5.0)
    if how is not signal.SIGKILL:  # else it could do nothing about it
        assert status == 0
        assert not folder.exists()
    keyed.__enter__()  # the fixture's end wants one that lives
    assert not folder.exists(), "the next broker leaves what a killed one left"


def test_a_daemon_ends_soon_after_somebody_left_in_the_middle_of_much(keyed: KeyedDaemon) -> None:
    """ZeroMQ keeps a connection that broke off with a reply half sent and messages unread until its next heartbeat."""
    for _ in range(3):
        with keyed.peer("anna") as anna:
            for _ in range(400):
                anna.send("ping")
    with keyed.peer("bert") as bert:
        folder = folder_of(solver_of(keyed, bert))
    assert keyed.process is not None
    keyed.process.terminate()
    assert keyed.process.wait(5.0) == 0
    assert not folder.exists()
    assert "The daemon ends: it was told to by a signal." in keyed.log.read_text()
    keyed.__enter__()  # the fixture's end wants one that lives


def test_a_process_whose_broker_has_gone_does_not_begin(binary: Path) -> None:
    options = ["--process-memory", str(4 << 30), "--parent", "1"]
    done = subprocess.run([binary, *options], input="", capture_output=True, text=True, timeout=10, check=False)
    assert done.returncode == 1
    assert "has ended" in done.stderr


def test_another_routing_id_is_no_way_to_a_session(keyed: KeyedDaemon) -> None:
    """Two peers that call themselves the same: each has its own session, and what is sent to one reaches no other."""
    with keyed.peer("anna", routing_id=b"anna") as anna:
        prepare(anna)
        with keyed.peer("bert", routing_id=b"anna") as bert:
            told = frame()
            assert bert.code("solve", told.fields, told.arrays) == "out_of_order"
            assert bert.code("close") == "out_of_order"
            asked = anna.send("solve", told.fields, told.arrays)
            assert anna.receive().id == asked
            assert not bert.socket.poll(300)
            asked = anna.send("solve", told.fields, told.arrays)
        assert anna.receive().id == asked
        session = anna.ask("epoch", {"index": 0}, epoch_arrays()).session
    with keyed.peer("bert", routing_id=b"anna") as bert:  # now that she has gone
        prepare(bert)
        bert.socket.send_multipart(_with_session(bert, session))
        assert bert.receive().fields["code"] == "out_of_order"


def _with_session(peer: KeyedPeer, session: int | None) -> list[bytes]:
    told = frame()
    return [bytes(part) for part in encode(Message("solve", next(peer.ids), session, told.fields, told.arrays))]


# --- following -----------------------------------------------------------------------------------------------------


def follow(peer: KeyedPeer, session: int | None) -> Message:
    peer.socket.send_multipart(encode(Message("follow", 77, session, {}, {})))
    return peer.receive()


def test_a_follower_sees_the_frames_of_a_session_that_is_shared(keyed: KeyedDaemon) -> None:
    with keyed.peer("anna") as anna, keyed.peer("fred") as fred:
        session = anna.ask("open", open_fields()).session
        for number in (session, 12345):
            reply = follow(fred, number)
            assert reply.fields["code"] == "out_of_order"  # hers is hers, and does not differ from none
            assert f"no session {number} that fred may follow" in reply.fields["message"]
        assert anna.ask("share").type == "accepted"
        assert follow(fred, session).type == "accepted"
        assert anna.ask("epoch", {"index": 0}, epoch_arrays()).type == "lattice"
        shown = fred.receive()
        assert (shown.type, shown.id, shown.session) == ("lattice", 77, session)
        solved = solve(anna)
        shown = fred.receive()
        assert (shown.type, shown.id, shown.session) == ("frame", 77, session)
        assert shown.fields == solved.fields
        assert shown.arrays.keys() == solved.arrays.keys()
        for name, array in solved.arrays.items():
            np.testing.assert_array_equal(shown.arrays[name], array, err_msg=name)
        assert fred.code("solve", frame().fields, frame().arrays) == "unauthorized"
        anna.close()
        over = fred.receive()
        assert (over.id, over.fields["code"]) == (77, "cancelled")
        assert over.fields["message"] == f"Session {session} is over."


def test_a_user_follows_their_own_session_from_another_place(keyed: KeyedDaemon) -> None:
    with keyed.peer("anna") as anna, keyed.peer("anna") as again, keyed.peer("bert") as bert:
        session = anna.ask("open", open_fields()).session
        assert follow(again, session).type == "accepted"
        assert follow(bert, session).fields["code"] == "out_of_order"
        assert anna.ask("epoch", {"index": 0}, epoch_arrays()).type == "lattice"
        assert again.receive().type == "lattice"
        assert not bert.socket.poll(200)
        assert again.code("close") == "out_of_order"  # followed, not held


def test_a_follower_who_does_not_read_is_closed_and_holds_up_nobody(binary: Path, tmp_path: Path) -> None:
    daemon = KeyedDaemon(binary, tmp_path, "--max-unread-bytes", str(4 * MIB))
    with daemon, daemon.peer("anna") as anna, daemon.peer("fred", waiting=2) as fred:
        session = anna.ask("open", open_fields()).session
        assert anna.ask("share").type == "accepted"
        assert follow(fred, session).type == "accepted"
        assert anna.ask("epoch", {"index": 0}, fine_sheet()).type == "lattice"
        before = daemon.memory()
        for time_code in range(1, 30):
            assert solve(anna, time_code / 10).type == "frame"
        assert daemon.memory() - before < 32 * MIB
        assert "it does not read what it is sent" in daemon.log.read_text()


# --- quotas --------------------------------------------------------------------------------------------------------


def test_sessions_of_a_user_and_of_all_are_counted(binary: Path, tmp_path: Path) -> None:
    daemon = KeyedDaemon(binary, tmp_path, "--sessions", "1", "--max-sessions", "3")
    daemon.allow("bert", "author", sessions=3)
    with daemon, daemon.peer("anna") as anna, daemon.peer("anna") as anna_again:
        prepare(anna)
        reply = anna_again.ask("open", open_fields())
        assert reply.fields["code"] == "out_of_order"
        assert "1 sessions of anna already" in reply.fields["message"]
        with daemon.peer("bert") as one, daemon.peer("bert") as two, daemon.peer("bert") as three:
            prepare(one)
            prepare(two)
            assert "The daemon has 3 sessions" in three.ask("open", open_fields()).fields["message"]
            one.close()  # without a word
            assert until(lambda: len(daemon.solvers()) == 2, 2.0)
            prepare(three)
        for _ in range(5):  # what was closed counts no more
            assert anna.ask("close").type == "accepted"
            prepare(anna)


def test_a_client_cannot_give_itself_more_memory(binary: Path, tmp_path: Path) -> None:
    daemon = KeyedDaemon(binary, tmp_path, "--memory-gib", "0.125", "--max-message-bytes", str(16 * MIB))
    daemon.allow("bert", "author", memory_gib=8)
    arrays = epoch_arrays(points=box(LARGE).points)
    with daemon, daemon.peer("anna") as anna, daemon.peer("bert") as bert:
        opened = open_fields(memory_budget=1 << 50)
        assert anna.ask("open", opened).type == "opened"
        (pid,) = daemon.solvers()
        limits = Path(f"/proc/{pid}/limits").read_text()
        (data,) = [int(line.split()[3]) for line in limits.splitlines() if line.startswith("Max data size")]
        assert 128 * MIB < data < 128 * MIB + 1500 * MIB
        ends_first, ends_last = (int(Path(f"/proc/{each}/oom_score_adj").read_text()) for each in (pid, daemon.pid))
        assert ends_first > ends_last
        assert anna.code("epoch", {"index": 0}, arrays) == "memory_budget"
        assert memory_of(pid) < 256 * MIB
        assert anna.ask("epoch", {"index": 0}, epoch_arrays()).type == "lattice"
        assert bert.ask("open", opened).type == "opened"
        bert.send("epoch", {"index": 0}, arrays)
        assert bert.receive(60.0).type == "lattice"


def threads_of(pid: int) -> int:
    return len(list(Path(f"/proc/{pid}/task").iterdir()))


def test_a_client_cannot_give_itself_more_threads(binary: Path, tmp_path: Path) -> None:
    daemon = KeyedDaemon(binary, tmp_path)
    daemon.allow("bert", "author", threads=1)
    counts = {}
    with daemon:
        for name in ("anna", "bert"):
            with daemon.peer(name) as peer:
                told = peer.hello().fields["threads"]
                assert told == (1 if name == "bert" else os.cpu_count())
                pid = solver_of(daemon, peer, size=(40.0, 40.0, 10.0), threads=0)
                assert solve(peer).type == "frame"
                counts[name] = threads_of(pid)
    if (os.cpu_count() or 1) > 1:
        assert counts["bert"] < counts["anna"]


def test_a_frame_and_an_epoch_have_their_seconds(binary: Path, tmp_path: Path) -> None:
    daemon = KeyedDaemon(binary, tmp_path, "--seconds", "0.5")
    with daemon, daemon.peer("anna") as anna:
        begin_long_solve(anna)
        begun = time.monotonic()
        reply = anna.receive(30.0)
        assert reply.fields["code"] == "time_budget", reply
        assert 0.3 < time.monotonic() - begun < 3.0
        assert anna.ask("close").type == "accepted"
        assert anna.ask("open", open_fields(memory_budget=8 << 30, time_budget=1e6)).type == "opened"
        anna.send("epoch", {"index": 0}, epoch_arrays(points=box(LARGE).points))
        begun = time.monotonic()
        reply = anna.receive(30.0)
        assert reply.fields["code"] == "time_budget", reply
        assert "longer than the 0.5 s" in reply.fields["message"]
        assert 0.4 < time.monotonic() - begun < 4.0
        assert anna.ask("epoch", {"index": 0}, epoch_arrays()).type == "lattice"


def test_a_solver_that_does_not_obey_ends_when_its_seconds_are_over(binary: Path, tmp_path: Path) -> None:
    daemon = KeyedDaemon(binary, tmp_path, "--seconds", "0.5")
    with daemon, daemon.peer("anna") as anna:
        kill(solver_of(daemon, anna), signal.SIGSTOP)
        told = frame()
        anna.send("solve", told.fields, told.arrays)
        reply = anna.receive(15.0)
        assert reply.fields["code"] == "time_budget"
        assert until(lambda: not daemon.solvers())
        prepare(anna)


def fine_sheet() -> dict[str, Any]:
    """A box whose upper face has 100 000 points: a frame of it has more than 2 MB."""
    surface = box()
    n = 317
    x, y = np.meshgrid(np.linspace(0.0, 4.0, n), np.linspace(0.0, 4.0, n), indexing="ij")
    top = np.column_stack([x.ravel(), y.ravel(), np.full(n * n, 2.0)])
    points = np.vstack([surface.points, top])
    return epoch_arrays(points=points)


def test_replies_that_nobody_reads_do_not_pile_up(binary: Path, tmp_path: Path) -> None:
    daemon = KeyedDaemon(binary, tmp_path, "--max-unread-bytes", str(8 * MIB), "--messages-per-second", "100000")
    with daemon, daemon.peer("anna", waiting=2) as anna, daemon.peer("bert") as bert:
        assert anna.ask("open", open_fields()).type == "opened"
        assert anna.ask("epoch", {"index": 0}, fine_sheet()).type == "lattice"
        reply = solve(anna)
        size = sum(array.nbytes for array in reply.arrays.values())
        assert size > 2 * MIB
        before = largest = daemon.memory()
        told = frame()
        for _ in range(400):
            anna.send("solve", told.fields, told.arrays)
            time.sleep(0.01)
            largest = max(largest, daemon.memory())
        assert largest - before < 8 * MIB + 6 * size
        assert until(lambda: not daemon.solvers()), "it was not closed"
        assert "it does not read what it is sent" in daemon.log.read_text()
        assert bert.ask("ping").type == "pong"
