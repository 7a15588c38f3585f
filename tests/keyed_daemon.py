"""A daemon with keys for several users, and a raw peer that is one of them."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Self

import zmq

from lappet.daemon.wire import Message
from raw_peer import Raw

ROLES = {"anna": "author", "bert": "author", "fred": "follower", "root": "admin"}


class KeyedDaemon:
    """Starts `lappet-solverd --keys` with a folder of keys of its own, and ends it."""

    def __init__(self, binary: Path, folder: Path, *arguments: str, roles: dict[str, str] | None = None) -> None:
        self.binary = binary
        self.keys = folder / "keys"
        self.arguments = arguments
        self.listen = "tcp://127.0.0.1:*"
        self.launcher: list[str] = []  # what starts the command
        self.log = folder / "log.txt"
        self.server_public, self.server_secret = (key.decode() for key in zmq.curve_keypair())
        self.pairs: dict[str, tuple[str, str]] = {}
        self.users = self.keys / "users"
        self.users.mkdir(parents=True)
        self.keys.chmod(0o700)
        self.write_server_key(self.server_public)
        for name, role in (ROLES if roles is None else roles).items():
            self.allow(name, role)
        self.address = ""
        self.process: subprocess.Popen[str] | None = None

    def allow(self, name: str, role: str, **quotas: float) -> None:
        """Write a user's file; their key stays what it was."""
        if name not in self.pairs:
            public, secret = zmq.curve_keypair()
            self.pairs[name] = (public.decode(), secret.decode())
        lines = [f"public = {self.pairs[name][0]}", f"role = {role}", *(f"{key} = {x}" for key, x in quotas.items())]
        write(self.users / f"{name}.pub", "\n".join(lines) + "\n", 0o644)

    def write_server_key(self, public: str) -> None:
        write(self.keys / "server.key", f"public = {public}\nsecret = {self.server_secret}\n", 0o600)

    def revoke(self, name: str) -> None:
        (self.users / f"{name}.pub").unlink()

    def command(self) -> list[str]:
        options = ["--listen", self.listen, "--keys", str(self.keys), *self.arguments]
        return [*self.launcher, str(self.binary), *options]

    def __enter__(self) -> Self:
        with self.log.open("w") as log:
            self.process = subprocess.Popen(
                self.command(), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=log, text=True
            )
        assert self.process.stdout is not None
        word, _, self.address = self.process.stdout.readline().strip().partition(" ")
        assert word == "listening", self.log.read_text()
        return self

    def __exit__(self, *_: object) -> None:
        assert self.process is not None
        assert self.process.stdout is not None
        lived = self.alive()
        with contextlib.suppress(ProcessLookupError):
            self.process.send_signal(signal.SIGCONT)
            self.process.terminate()
        self.process.wait(10.0)
        self.process.stdout.close()
        assert lived, f"the daemon did not live through the test: {self.log.read_text()}"

    @property
    def pid(self) -> int:
        assert self.process is not None
        return self.process.pid

    def alive(self) -> bool:
        return self.process is not None and self.process.poll() is None

    def host_and_port(self) -> tuple[str, int]:
        host, _, port = self.address.removeprefix("tcp://").rpartition(":")
        return host, int(port)

    def memory(self) -> int:
        """What the daemon's own process takes, bytes."""
        return memory_of(self.pid)

    def solvers(self) -> list[int]:
        """The processes that it started and that run."""
        return [pid for pid in children_of(self.pid) if state_of(pid) != "Z"]

    @contextlib.contextmanager
    def peer(self, name: str, *, greet: bool = True, **options: Any) -> Iterator[KeyedPeer]:
        peer = KeyedPeer(self, self.pairs[name], greet=greet, **options)
        with contextlib.closing(peer):
            yield peer


class KeyedPeer(Raw):
    """A DEALER with a user's key that says whatever it is told."""

    def __init__(
        self,
        daemon: KeyedDaemon,
        pair: tuple[str, str],
        *,
        greet: bool = True,
        routing_id: bytes = b"",
        server_key: str | None = None,
        waiting: int = 0,
    ) -> None:
        self.context = zmq.Context()
        self.socket = self.context.socket(zmq.DEALER)
        self.socket.setsockopt(zmq.LINGER, 0)
        self.socket.curve_serverkey = (server_key or daemon.server_public).encode()
        self.socket.curve_publickey, self.socket.curve_secretkey = (key.encode() for key in pair)
        if routing_id:
            self.socket.setsockopt(zmq.IDENTITY, routing_id)
        if waiting:  # so many messages, and little more in the system, wait here to be read
            self.socket.setsockopt(zmq.RCVHWM, waiting)
            self.socket.setsockopt(zmq.RCVBUF, 65536)
        self.socket.setsockopt(zmq.IPV6, "[" in daemon.address)
        self.socket.connect(daemon.address)
        self.ids = iter(range(1, 1_000_000))
        if greet:
            assert self.hello().type == "welcome"

    def hello(self) -> Message:
        return self.ask("hello", {"client": "raw"})

    def code(self, kind: str, fields: dict[str, Any] | None = None, arrays: dict[str, Any] | None = None) -> str:
        """The code of the error that answers a message, or the type of another answer."""
        reply = self.ask(kind, fields, arrays)
        return str(reply.fields["code"]) if reply.type == "error" else reply.type

    def is_heard(self, seconds: float) -> bool:
        """Whether a hello is answered within that time."""
        self.send("hello", {"client": "raw"})
        return bool(self.socket.poll(int(1000 * seconds)))


def write(path: Path, text: str, mode: int) -> None:
    path.write_text(text)
    path.chmod(mode)


def memory_of(pid: int) -> int:
    line = next(line for line in Path(f"/proc/{pid}/status").read_text().splitlines() if line.startswith("VmRSS:"))
    return 1024 * int(line.split()[1])


def state_of(pid: int) -> str:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return "Z"  # it is gone


def children_of(pid: int) -> list[int]:
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            with contextlib.suppress(OSError):
                if int((entry / "stat").read_text().rpartition(")")[2].split()[1]) == pid:
                    found.append(int(entry.name))
    return found


def until(holds: Callable[[], bool], seconds: float = 5.0) -> bool:
    """Whether it holds within that time."""
    end = time.monotonic() + seconds
    while not holds():
        if time.monotonic() > end:
            return False
        time.sleep(0.02)
    return True


def kill(pid: int, how: signal.Signals) -> None:
    os.kill(pid, how)
