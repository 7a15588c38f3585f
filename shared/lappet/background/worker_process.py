"""The worker as its owner sees it: a process that is sent requests and whose happenings a thread reads."""

from __future__ import annotations

import contextlib
import io
import os
import signal
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, cast

from lappet.background.frame_stream import read_frame, write_frame
from lappet.background.interpreter import find_python, worker_environment
from lappet.background.procedure_message import MessageError, pack, unpack
from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode

_STDERR_LINES = 40
_LAST_WORDS = 3
_PIPE_BYTES = 1 << 20  # a frame of 20 000 vertices; where the system lets us


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
        heard: Callable[[Any], None],
        ended: Callable[[WorkerProcess], None],
    ) -> None:
        python = find_python()
        command = [str(python), "-s", "-P", "-m", "lappet.background.worker"]
        if store is not None:
            command += ["--store", str(store)]
        self._heard, self._ended = heard, ended
        self._stderr: deque[str] = deque(maxlen=_STDERR_LINES)
        try:
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                bufsize=0,
                env=worker_environment(os.environ, path, solverd),
                start_new_session=True,  # Ctrl-C in the terminal is for its owner
                creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
                pipesize=_PIPE_BYTES if sys.platform == "linux" else -1,
            )
        except OSError as error:
            raise refused(ProblemCode.BACKGROUND_NOT_STARTED, python, error.strerror or error) from error
        self._stdin = cast(io.RawIOBase, self._process.stdin)
        self._words = threading.Thread(target=self._read_stderr, name="lappet-worker-words", daemon=True)
        self._reader = threading.Thread(target=self._read, name="lappet-worker-reader", daemon=True)
        self._words.start()
        self._reader.start()

    @property
    def pid(self) -> int:
        """The process id."""
        return self._process.pid

    def send(self, request: dict[str, Any]) -> None:
        """Send a request; where the process has ended, nothing happens: `ended` tells.

        Parameters
        ----------
        request
            The request.

        Raises
        ------
        MessageError
            If the request cannot be told in a message.
        """
        data = pack(request)
        with contextlib.suppress(OSError, ValueError):  # ValueError: the pipe is closed
            write_frame(self._stdin, data)

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
        with contextlib.suppress(OSError):
            self._stdin.close()
        try:
            self._process.wait(patience)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        if self._reader is not threading.current_thread():
            self._reader.join(patience)

    def _with_last_words(self, how: str) -> str:
        self._words.join(timeout=1.0)
        words = [line for line in list(self._stderr)[-_LAST_WORDS:] if line]
        return f"{how}.{' It said: ' + ' | '.join(words) if words else ''}"

    def _read(self) -> None:
        pipe = cast(io.RawIOBase, self._process.stdout)
        with contextlib.suppress(OSError, MessageError):
            while (data := read_frame(pipe)) is not None:
                self._heard(unpack(data))
        with contextlib.suppress(OSError):
            pipe.close()
        if self._process.poll() is None:  # it may have closed its pipe alone, or said what nobody understands
            with contextlib.suppress(OSError):
                self._stdin.close()
            try:
                self._process.wait(1.0)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
        self._ended(self)

    def _read_stderr(self) -> None:
        assert self._process.stderr is not None
        with self._process.stderr as pipe, io.TextIOWrapper(cast(Any, pipe), errors="replace") as lines:
            for line in lines:
                self._stderr.append(line.rstrip())
