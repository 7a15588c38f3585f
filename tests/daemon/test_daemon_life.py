"""The real daemon and its client: cancelled, killed, hung, alone, and started where there is none."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import stat
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from box_scene import Started, box, long_solve, pull
from lappet.cutting.epoch import Epoch
from lappet.daemon.client import DaemonDied, DaemonMissing, SolveCancelled, SolverClient
from lappet.daemon.frame_solver import Iteration
from lappet.daemon.process import SolverDaemon, find_daemon
from lappet.program.settings import SolverSettings
from raw_peer import Raw

pytestmark = [pytest.mark.slow, pytest.mark.timeout(120)]


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
        client.open(SolverSettings(spacing=1.0, threads=1))
        client.set_epoch(Epoch(0, 1.0, box(), 1))
        assert client.solve(pull()).converged


def test_ctrl_c_cancels_the_solve_and_the_session_goes_on(daemon: SolverDaemon) -> None:
    with SolverClient(daemon=daemon) as client, long_solve(client) as frame:
        started = Started(lambda: os.kill(os.getpid(), signal.SIGINT))
        with pytest.raises(KeyboardInterrupt):
            client.solve(frame, started)
        assert time.monotonic() - started.at < 10.0
        assert client.ping() < 1.0
        client.open(SolverSettings(spacing=1.0, threads=1))
        client.set_epoch(Epoch(0, 1.0, box(), 1))
        assert client.solve(pull()).converged


def test_an_error_in_the_progress_callback_cancels_the_solve(daemon: SolverDaemon) -> None:
    def fail(_: Iteration) -> None:
        raise RuntimeError("the window is gone")

    with SolverClient(daemon=daemon) as client, long_solve(client) as frame:
        with pytest.raises(RuntimeError, match="the window is gone"):
            client.solve(frame, fail)
        assert client.ping() < 1.0


# --- the instruction set -----------------------------------------------------------------------------------------


def test_the_daemon_says_which_instruction_set_it_was_told_to_use(
    binary: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LAPPET_ISA", "scalar")
    with SolverDaemon(binary) as daemon, SolverClient(daemon=daemon) as client:
        assert client.welcome["isa"] == "scalar"


def test_a_daemon_does_not_start_with_an_instruction_set_that_nobody_knows(
    binary: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LAPPET_ISA", "mmx")
    with pytest.raises(DaemonDied, match='LAPPET_ISA is "mmx"'), SolverDaemon(binary):
        pass


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
        with pytest.raises(DaemonDied, match="whether it is running there"), SolverClient(address, "x", silence=0.5):
            pass
    with pytest.raises(DaemonMissing, match="is no address"), SolverClient("nowhere", "x"):
        pass


def test_the_daemon_ends_with_its_client_even_when_that_is_killed(binary: Path) -> None:
    program = (
        "import sys, time\n"
        "from lappet.daemon.client import SolverClient\n"
        "from lappet.daemon.process import SolverDaemon\n"
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
    monkeypatch.setattr("lappet.daemon.connection._HEARTBEAT_SECONDS", 0.2)
    monkeypatch.setattr("lappet.daemon.connection._PING_SECONDS", 0.1)
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
    "address",
    [
        "tcp://0.0.0.0:*",
        "tcp://*:*",
        "tcp://192.0.2.1:5000",
        "ipc:///tmp/lappet",
        "ipc://lappet",
        "ipc://@lappet",
        "tcp://127.0.0.1",
    ],
)
def test_it_listens_on_loopback_only(binary: Path, address: str) -> None:
    with pytest.raises(DaemonDied, match=r"only loopback is served"):
        SolverDaemon(binary, arguments=("--address", address)).start()


@pytest.mark.skipif(os.name != "posix", reason="sockets lie in no folder here")
def test_only_the_user_reaches_a_daemon_of_their_own(binary: Path) -> None:
    """Its socket lies in a folder that nobody else may enter, and both are gone afterwards."""
    with SolverDaemon(binary) as daemon:
        folder = Path(daemon.address.removeprefix("ipc://")).parent
        status = folder.stat()
        assert (stat.S_IMODE(status.st_mode), status.st_uid) == (0o700, os.geteuid())
        assert stat.S_ISSOCK((folder / "socket").stat().st_mode)
        if os.geteuid() == 0:  # then there is another user to try it as
            code = f"import os, socket; os.setuid(65534); socket.socket(socket.AF_UNIX).connect('{folder}/socket')"
            tried = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
            assert "PermissionError" in tried.stderr, tried
    assert not folder.exists()


@pytest.mark.skipif(os.name != "posix", reason="sockets lie in no folder here")
def test_a_daemon_whose_client_was_killed_takes_its_folder_away(binary: Path) -> None:
    code = (
        "from lappet.daemon.process import SolverDaemon; import os, signal; "
        f"daemon = SolverDaemon({str(binary)!r}).start(); print(daemon.address, flush=True); "
        "os.kill(os.getpid(), signal.SIGKILL)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=30, check=False)
    folder = Path(done.stdout.strip().removeprefix("ipc://")).parent
    assert folder.name.startswith("lappet-"), done
    end = time.monotonic() + 10.0
    while folder.exists() and time.monotonic() < end:
        time.sleep(0.05)
    assert not folder.exists()


@pytest.mark.skipif(os.name != "posix", reason="sockets lie in no folder here")
@pytest.mark.parametrize("mode", [0o750, 0o705, 0o777])
def test_a_socket_where_others_may_come_is_refused(binary: Path, tmp_path: Path, mode: int) -> None:
    folder = tmp_path / "open"
    folder.mkdir()
    folder.chmod(mode)
    with pytest.raises(DaemonDied, match=r"a folder of your own with mode 0700"):
        SolverDaemon(binary, arguments=("--address", f"ipc://{folder}/socket")).start()
    folder.chmod(0o700)
    with SolverDaemon(binary, arguments=("--address", f"ipc://{folder}/socket")) as daemon:
        assert daemon.alive()


def test_it_does_not_start_without_a_token(binary: Path) -> None:
    environment = {name: value for name, value in os.environ.items() if name != "LAPPET_TOKEN"}
    done = subprocess.run([binary], input="", capture_output=True, text=True, timeout=10, env=environment, check=False)
    assert done.returncode == 1
    assert "LAPPET_TOKEN is not set" in done.stderr
    assert subprocess.run([binary, "--nonsense"], capture_output=True, timeout=10, check=False).returncode == 2


# --- finding and starting it ---------------------------------------------------------------------------------------


def test_a_missing_daemon_is_named_with_the_repair(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("LAPPET_SOLVERD", str(tmp_path / "nothing"))
    with pytest.raises(DaemonMissing, match=r"LAPPET_SOLVERD names .*nothing.*unset it"):
        find_daemon()
    monkeypatch.delenv("LAPPET_SOLVERD")
    monkeypatch.setattr("lappet.daemon.process.BINARY", "no-such-daemon")
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
