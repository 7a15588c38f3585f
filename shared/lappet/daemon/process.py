"""The daemon's process: finds `lappet-solverd`, starts it on loopback with a one-time token and always ends it."""

from __future__ import annotations

import contextlib
import hashlib
import os
import queue
import secrets
import signal
import subprocess
import threading
from collections import deque
from functools import lru_cache
from pathlib import Path
from types import TracebackType
from typing import IO, Self

from lappet.core.problem import RefusedError
from lappet.core.version import version
from lappet.daemon.frame_solver import SolverDiedError

BINARY = "lappet-solverd"
_STDERR_LINES = 40


class DaemonMissing(RefusedError):
    """There is no daemon to start, or what was named is not one."""


class DaemonDied(SolverDiedError):
    """The daemon ended, or fell silent, while it was needed; another one may be started."""


def find_daemon() -> Path:
    """The daemon's program: LAPPET_SOLVERD, the package's own, or that of a source checkout's build folder.

    Raises DaemonMissing, saying where it looked.
    """
    named = os.environ.get("LAPPET_SOLVERD")
    if named:
        path = Path(named)
        if not _is_program(path):
            raise DaemonMissing(
                f"LAPPET_SOLVERD names {named}, which is not a program; set it to the path of {BINARY}, or unset it."
            )
        return path
    package = Path(__file__).resolve().parent.parent
    checkout = package.parent.parent
    places = [package / "bin" / BINARY]
    if (checkout / "solverd" / "CMakeLists.txt").is_file():
        places.append(checkout / "build" / "solverd" / BINARY)
    for path in places:
        if path.is_file():
            return _runnable(path)
    raise DaemonMissing(
        f"The daemon {BINARY} is not installed; looked for {' and '.join(map(str, places))}. Run `make setup` in a "
        f"source checkout, install the wheel, or set LAPPET_SOLVERD to its path."
    )


@lru_cache(maxsize=4)
def _identity(binary: Path, modified: int) -> str:

    return f"{version()} {hashlib.blake2b(binary.read_bytes(), digest_size=16).hexdigest()}"


def daemon_identity(binary: Path | None = None) -> str:
    """What tells a daemon's program (found when None) from another: Lappet's version and the program's digest."""
    binary = find_daemon() if binary is None else binary
    return _identity(binary, binary.stat().st_mtime_ns)


class SolverDaemon:
    """A daemon of our own: a context manager that starts it and ends it.

    binary: the program (found when None). arguments: further options of `lappet-solverd`. start_timeout: seconds until
    it must listen. address, token: what a client needs, once started.
    """

    def __init__(
        self, binary: Path | str | None = None, *, arguments: tuple[str, ...] = (), start_timeout: float = 20.0
    ) -> None:
        self.address = ""
        self.token = secrets.token_hex(16)
        self._binary = binary
        self._arguments = arguments
        self._start_timeout = start_timeout
        self._process: subprocess.Popen[bytes] | None = None
        self._stderr: deque[str] = deque(maxlen=_STDERR_LINES)
        self._readers: list[threading.Thread] = []

    def start(self) -> Self:
        """Starts the daemon and waits until it listens. Raises DaemonMissing or DaemonDied with its last words."""
        if self._process is not None:
            return self
        binary = Path(self._binary) if self._binary is not None else find_daemon()
        command = [str(binary), "--parent", str(os.getpid()), *self._arguments]
        try:
            # A session of its own: Ctrl-C in the terminal is for us, and we cancel what the daemon does.
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                env={**os.environ, "LAPPET_TOKEN": self.token},
                start_new_session=True,
            )
        except OSError as error:
            raise DaemonMissing(
                f"The daemon {binary} cannot be started: {error.strerror or error}; reinstall Lappet."
            ) from error
        assert self._process.stdout is not None
        assert self._process.stderr is not None
        lines: queue.Queue[str | None] = queue.Queue()
        self._readers = [
            threading.Thread(target=_read_stdout, args=(self._process.stdout, lines), daemon=True),
            threading.Thread(target=_read_stderr, args=(self._process.stderr, self._stderr), daemon=True),
        ]
        for reader in self._readers:
            reader.start()
        try:
            self.address = self._listening(binary, lines)
        except BaseException:
            self.stop(patience=1.0)
            raise
        return self

    def _listening(self, binary: Path, lines: queue.Queue[str | None]) -> str:
        try:
            line = lines.get(timeout=self._start_timeout)
        except queue.Empty:
            raise DaemonDied(
                f"The daemon {binary} did not listen within {self._start_timeout:g} s.{self._last_words()}"
            ) from None
        if line is None:
            raise DaemonDied(f"The daemon {binary} did not start: {self.death()}")
        word, _, address = line.partition(" ")
        if word != "listening" or not address.startswith("tcp://"):
            raise DaemonMissing(f"{binary} is not a Lappet daemon: it says '{line:.80}' instead of its address.")
        return address

    @property
    def pid(self) -> int | None:
        """The process id, or None when it was not started."""
        return None if self._process is None else self._process.pid

    def alive(self) -> bool:
        """Whether the process runs."""
        return self._process is not None and self._process.poll() is None

    def death(self) -> str:
        """How it ended and what it said last, as a sentence; also when it has not been started or still runs."""
        if self._process is None:
            return "it was not started."
        try:
            status = self._process.wait(timeout=2.0)
        except subprocess.TimeoutExpired:
            return f"it still runs as process {self._process.pid}.{self._last_words()}"
        if status < 0:
            try:
                name = signal.Signals(-status).name
            except ValueError:
                name = f"signal {-status}"
            how = f"it was ended by {name}"
            if -status == signal.SIGKILL:
                how += " (by hand, or because the machine's memory was spent)"
        else:
            how = f"it ended with status {status}"
        for reader in self._readers:
            reader.join(timeout=1.0)
        return f"{how}.{self._last_words()}"

    def _last_words(self) -> str:
        words = [line for line in list(self._stderr)[-5:] if line]
        return f" It said: {' | '.join(words)}" if words else ""

    def stop(self, patience: float = 5.0) -> None:
        """Ends it: closes its standard input, then asks, then forces. Does nothing when it has ended."""
        process = self._process
        if process is None:
            return
        if process.stdin is not None:
            with contextlib.suppress(OSError):
                process.stdin.close()
        for end in (None, process.terminate, process.kill):
            if end is not None:
                end()
            try:
                process.wait(timeout=patience)
                break
            except subprocess.TimeoutExpired:
                continue
        for reader, pipe in zip(self._readers, (process.stdout, process.stderr), strict=False):
            reader.join(timeout=1.0)
            if pipe is not None and not reader.is_alive():  # a child of a program that is no daemon may hold it open
                pipe.close()

    def __enter__(self) -> Self:
        return self.start()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.stop()


def _is_program(path: Path) -> bool:
    return path.is_file() and os.access(path, os.X_OK)


def _runnable(path: Path) -> Path:
    """The path, once it may be executed: Blender unpacks an extension's wheels without the modes of their files."""
    if not _is_program(path):
        try:
            mode = path.stat().st_mode
            path.chmod(mode | (mode & 0o444) >> 2)  # who may read it may run it
        except OSError as error:
            raise DaemonMissing(
                f"The daemon {path} may not be executed and that cannot be changed ({error.strerror or error}); run "
                f"`chmod a+x` on it as its owner."
            ) from error
    return path


def _read_stdout(pipe: IO[bytes], lines: queue.Queue[str | None]) -> None:
    for line in pipe:
        lines.put(line.decode(errors="replace").strip())
    lines.put(None)


def _read_stderr(pipe: IO[bytes], last: deque[str]) -> None:
    for line in pipe:
        last.append(line.decode(errors="replace").rstrip())
