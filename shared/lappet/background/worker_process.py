"""The worker as its owner sees it: a process that is sent requests and whose events a thread reads."""

from __future__ import annotations

import contextlib
import io
import os
import signal
import subprocess
import threading
from collections import deque
from collections.abc import Callable, Sequence
from pathlib import Path

from lappet.background.pipes import MAX_BYTES, WorkerPipes
from lappet.background.worker_events import WorkerEvent
from lappet.background.worker_requests import WorkerRequest
from lappet.core.array_codec import CodecError
from lappet.core.interpreter import child_environment, find_python
from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.core.value_codec import pack, unpack

_LINES = 40
_LAST_WORDS = 3


class WorkerProcess:
    """A running worker.

    Parameters
    ----------
    store
        Folder of the frames, or None for the user's.
    solverd
        The daemon's program, or None to find it.
    path
        Folders that the worker imports from.
    heard
        Called on the reading thread with each thing that happened.
    ended
        Called once, when the process has ended.
    """

    def __init__(
        self,
        store: Path | None,
        solverd: Path | None,
        path: Sequence[str],
        heard: Callable[[WorkerEvent], None],
        ended: Callable[[WorkerProcess], None],
    ) -> None:
        python = find_python()
        self._heard, self._ended = heard, ended
        self._said: deque[str] = deque(maxlen=_LINES)
        pipes = WorkerPipes()
        self._requests, self._events = pipes.requests, pipes.events
        command = [str(python), "-s", "-P", "-m", "lappet.background.worker", *pipes.handles]
        try:
            self._process = subprocess.Popen(
                command if store is None else [*command, str(store)],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                env=child_environment(os.environ, path, solverd),
                start_new_session=True,  # Ctrl-C in the terminal is for its owner
                creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
                **pipes.inherit,
            )
        except OSError as error:
            pipes.close()
            raise refused(ProblemCode.BACKGROUND_NOT_STARTED, python, error.strerror or error) from error
        pipes.close_theirs()
        self._words = threading.Thread(target=self._read_words, name="lappet-worker-words", daemon=True)
        self._reader = threading.Thread(target=self._read, name="lappet-worker-reader", daemon=True)
        self._words.start()
        self._reader.start()

    @property
    def pid(self) -> int:
        """The process id."""
        return self._process.pid

    def send(self, request: WorkerRequest) -> None:
        """Send a request; where the process has ended, nothing happens: `ended` tells.

        Parameters
        ----------
        request
            The request.

        Raises
        ------
        CodecError
            If the request cannot be told in a message.
        """
        data = pack(request)
        with contextlib.suppress(OSError):
            self._requests.send_bytes(data)

    def death(self) -> str:
        """Tell how the process ended and what it said last.

        Returns
        -------
        str
            A sentence.
        """
        status = self._process.wait()
        if status < 0:
            with contextlib.suppress(ValueError):
                how = f"it was ended by {signal.Signals(-status).name}"
                if -status == getattr(signal, "SIGKILL", None):
                    how += " (by hand, or because the machine's memory was spent)"
                return self._with_last_words(how)
        return self._with_last_words(f"it ended with status {status}")

    def stop(self, patience: float) -> None:
        """Close its standard input, upon which it ends; force it after a while.

        Parameters
        ----------
        patience
            Seconds that it gets.
        """
        self._requests.close()
        try:
            self._process.wait(patience)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        if self._reader is not threading.current_thread():
            self._reader.join(patience)

    def _with_last_words(self, how: str) -> str:
        self._words.join(timeout=1.0)
        words = [line for line in list(self._said)[-_LAST_WORDS:] if line]
        return f"{how}.{' It said: ' + ' | '.join(words) if words else ''}"

    def _read(self) -> None:
        with contextlib.suppress(OSError, EOFError, CodecError):
            while True:
                self._heard(unpack(self._events.recv_bytes(MAX_BYTES), WorkerEvent))
        self._events.close()
        try:  # it may have closed its pipe alone, or said what nobody understands
            self._process.wait(1.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._ended(self)

    def _read_words(self) -> None:
        assert self._process.stdout is not None
        with io.TextIOWrapper(self._process.stdout, errors="replace") as lines:
            for line in lines:
                self._said.append(line.rstrip())
