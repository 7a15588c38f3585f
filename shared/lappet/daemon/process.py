"""The daemon's process: finds `lappet-solverd`, starts it where only the user reaches it, with one-time secrets."""

from __future__ import annotations

import contextlib
import hashlib
import os
import platform
import queue
import secrets
import shutil
import signal
import subprocess
import tempfile
import threading
from collections import deque
from functools import lru_cache
from pathlib import Path
from types import TracebackType
from typing import IO, Self

from lappet.core.printable import printable
from lappet.core.problem import RefusedError, file_problem
from lappet.core.problem_code import ProblemCode
from lappet.core.version import version
from lappet.daemon.frame_solver import SolverDiedError
from lappet.daemon.key_files import new_pair
from lappet.daemon.keys_folder import KeysFolder, Quotas, Role, User
from lappet.daemon.running_daemon import ClientKeys
from lappet.daemon.stale_sockets import PREFIX, SOCKET, remove_stale_folders, socket_places

BINARY = "lappet-solverd.exe" if os.name == "nt" else "lappet-solverd"
# On Windows: no window of its own, and Ctrl-C in the terminal is for us. Both flags are 0 elsewhere.
_OF_ITS_OWN = getattr(subprocess, "CREATE_NO_WINDOW", 0) | getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0)
_LONGEST_ADDRESS = 100  # bytes; a socket's path has 104 to 108 at most
_STDERR_LINES = 40
# On ARM: the kernels that OpenBLAS has for every such processor. Those that it would choose give other last digits on
# each kind, and those for SME (ARMv9) multiply matrices wrongly under qemu 7.2.
_ARM_BLAS = {"OPENBLAS_CORETYPE": "ARMV8"}
_HAS_BROKER = os.name == "posix"  # a daemon with keys has one
_UNBOUNDED = Quotas(memory_gib=65536.0, sessions=64, seconds=1e6)  # the settings of its client count, as without keys


class DaemonMissing(RefusedError):
    """There is no daemon to start, or what was named is not one."""


class DaemonDied(SolverDiedError):
    """The daemon ended, or fell silent, while it was needed; another one may be started."""


def find_daemon() -> Path:
    """Find the daemon's program: `LAPPET_SOLVERD`, the package's own, or that of a source checkout's build folder.

    Returns
    -------
    Path
        The program.

    Raises
    ------
    DaemonMissing
        If there is none; the message says where it was looked for.
    """
    named = os.environ.get("LAPPET_SOLVERD")
    if named:
        path = Path(named)
        if not _is_program(path):
            raise DaemonMissing.of(ProblemCode.DAEMON_NOT_A_PROGRAM, named, named)
        return path
    package = Path(__file__).resolve().parent.parent
    checkout = package.parent.parent
    places = [package / "bin" / BINARY]
    if (checkout / "solverd" / "CMakeLists.txt").is_file():
        places.append(checkout / "build" / "solverd" / BINARY)
    for path in places:
        if path.is_file():
            return _runnable(path)
    raise DaemonMissing.of(ProblemCode.DAEMON_MISSING, BINARY, " and ".join(map(str, places)))


@lru_cache(maxsize=4)
def _identity(binary: Path, modified: int) -> str:

    return f"{version()} {hashlib.blake2b(binary.read_bytes(), digest_size=16).hexdigest()}"


def daemon_identity(binary: Path | None = None) -> str:
    """Find what tells a daemon's program from another.

    Parameters
    ----------
    binary
        The program; found when None.

    Returns
    -------
    str
        Lappet's version and the program's digest.
    """
    binary = find_daemon() if binary is None else binary
    return _identity(binary, binary.stat().st_mtime_ns)


def daemon_environment(machine: str | None = None) -> dict[str, str]:
    """Gather the variables that a daemon is started with: this process's, and on ARM which kernels BLAS takes.

    Parameters
    ----------
    machine
        The processor as `platform.machine` names it; this one when None.

    Returns
    -------
    dict[str, str]
        What the environment says of `OPENBLAS_CORETYPE` stays.
    """
    arm = (machine or platform.machine()).lower() in ("aarch64", "arm64")
    return {**(_ARM_BLAS if arm else {}), **os.environ}


class SolverDaemon:
    """A daemon of our own: a context manager that starts it and ends it.

    It listens on a socket in a folder of mode 0700. Where no folder has a name short enough for a socket it listens on
    TCP, with a fresh pair of keys for itself and one for its client; on Windows on TCP, with its token alone. Once it
    is started, `address`, `token` and `keys` are what a client needs.

    Parameters
    ----------
    binary
        The program; found when None.
    listen
        Address on TCP to listen on with keys; None for the socket.
    arguments
        Further options of `lappet-solverd`; where they say `--address`, the daemon has its token alone.
    start_timeout
        Seconds until it must listen.
    """

    def __init__(
        self,
        binary: Path | str | None = None,
        *,
        listen: str | None = None,
        arguments: tuple[str, ...] = (),
        start_timeout: float = 20.0,
    ) -> None:
        self.address = ""
        self.token = secrets.token_hex(16)
        self.keys: ClientKeys | None = None
        self._binary = binary
        self._listen = listen
        self._arguments = arguments
        self._start_timeout = start_timeout
        self._process: subprocess.Popen[bytes] | None = None
        self._stderr: deque[str] = deque(maxlen=_STDERR_LINES)
        self._readers: list[threading.Thread] = []
        self._folder: str | None = None

    def start(self) -> Self:
        """Start the daemon and wait until it listens.

        Returns
        -------
        Self
            This daemon.

        Raises
        ------
        DaemonMissing
            If there is no program to start, or no folder can be made for its socket.
        DaemonDied
            If it ends before it listens; the message has its last words.
        """
        if self._process is not None:
            return self
        binary = Path(self._binary) if self._binary is not None else find_daemon()
        try:
            place = self._private_address()
        except OSError as error:  # a full disk
            self._remove_folder()
            raise DaemonMissing([file_problem(error)]) from error
        command = [str(binary), "--parent", str(os.getpid()), *place, *self._arguments]
        environment = {name: value for name, value in daemon_environment().items() if name != "LAPPET_TOKEN"}
        if self.keys is None:
            environment["LAPPET_TOKEN"] = self.token
        try:
            # A session of its own: Ctrl-C in the terminal is for us, and we cancel what the daemon does.
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                env=environment,
                start_new_session=True,
                creationflags=_OF_ITS_OWN,
            )
        except OSError as error:
            self._remove_folder()
            raise DaemonMissing.of(ProblemCode.DAEMON_NOT_STARTED, binary, error.strerror or error) from error
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

    def _private_address(self) -> list[str]:
        """Options for a place where nobody else comes in; none where the caller names one with `--address`."""
        if "--address" in self._arguments or (self._listen is None and not _HAS_BROKER):
            return []  # it listens on this computer and asks for the token
        remove_stale_folders()
        sockets, own = self._listen is None, ""
        for place in socket_places()[: None if sockets else 1]:
            self._remove_folder()
            own = self._folder = tempfile.mkdtemp(prefix=PREFIX, dir=place)  # mode 0700
            address = f"ipc://{own}/{SOCKET}"
            if sockets and len(os.fsencode(address)) < _LONGEST_ADDRESS:
                return ["--address", address]
        folder, pair = KeysFolder(Path(own) / "keys"), new_pair()
        self.keys = ClientKeys(folder.make_server("a daemon of one client").public, pair)
        folder.allow(User("owner", pair.public, Role.ADMIN, _UNBOUNDED))
        return ["--listen", self._listen or "tcp://127.0.0.1:0", "--keys", str(folder.path)]

    def _remove_folder(self) -> None:
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)
            self._folder = None

    def _listening(self, binary: Path, lines: queue.Queue[str | None]) -> str:
        try:
            line = lines.get(timeout=self._start_timeout)
        except queue.Empty:
            code, words = ProblemCode.DAEMON_SILENT_START, self._last_words()
            raise DaemonDied.of(code, binary, seconds=self._start_timeout, words=words) from None
        if line is None:
            raise DaemonDied.of(ProblemCode.DAEMON_DIED_AT_START, binary, self.death())
        word, _, address = line.partition(" ")
        if word != "listening" or not address.startswith(("tcp://", "ipc://")):
            raise DaemonMissing.of(ProblemCode.DAEMON_NOT_LAPPET, binary, line)
        return address

    @property
    def pid(self) -> int | None:
        """The process id, or None when it was not started."""
        return None if self._process is None else self._process.pid

    def alive(self) -> bool:
        """Tell whether the process runs.

        Returns
        -------
        bool
            Whether it does.
        """
        return self._process is not None and self._process.poll() is None

    def death(self) -> str:
        """Tell how the process ended and what it said last; also when it has not been started or still runs.

        Returns
        -------
        str
            A sentence.
        """
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
        """End the process: close its standard input, then ask, then force; nothing happens when it has ended.

        Parameters
        ----------
        patience
            Seconds that each step gets.
        """
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
        self._remove_folder()
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
            raise DaemonMissing.of(ProblemCode.DAEMON_NOT_EXECUTABLE, path, error.strerror or error) from error
    return path


def _read_stdout(pipe: IO[bytes], lines: queue.Queue[str | None]) -> None:
    for line in pipe:
        lines.put(line.decode(errors="replace").strip())
    lines.put(None)


def _read_stderr(pipe: IO[bytes], last: deque[str]) -> None:
    for line in pipe:
        last.append(printable(line.decode(errors="replace").rstrip()))
