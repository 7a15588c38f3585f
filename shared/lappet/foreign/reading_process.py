"""A file that a child process reads, as its parent sees it.

The module is light, so that the child starts before all else is loaded.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
from dataclasses import asdict
from pathlib import Path
from typing import Any, Self

from lappet.core.interpreter import child_environment, find_python
from lappet.core.problem import RefusedError, refused
from lappet.core.problem_code import ProblemCode
from lappet.foreign.limits import DEFAULT_LIMITS, ReadLimits

# One thread each: seconds of the clock and of the processor are then the same, and no stack is set aside for others.
_ENVIRONMENT = {
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
    "PXR_WORK_THREAD_LIMIT": "1",
    "MALLOC_ARENA_MAX": "2",
}
_LAST_BYTES = 200
_SEARCH_PATH = "PXR_AR_DEFAULT_SEARCH_PATH"  # folders in which USD would look besides


class ReadingProcess:
    """A child process that reads one file.

    Parameters
    ----------
    module
        Module of the child, whose last line calls `lappet.foreign.reading_child.serve`.
    reader
        Which of its readers reads the file.
    file
        The file.
    limits
        What reading may take.
    option
        What the reader is told besides.

    Raises
    ------
    RefusedError
        If the process cannot be started.
    """

    def __init__(
        self, module: str, reader: str, file: Path, limits: ReadLimits = DEFAULT_LIMITS, option: str = ""
    ) -> None:
        self._file, self._limits = file, limits
        python = find_python()
        command = [str(python), "-s", "-P", "-m", module, reader, json.dumps(asdict(limits)), option, str(file)]
        self._said, self._chatter = tempfile.TemporaryFile(), tempfile.TemporaryFile()  # noqa: SIM115
        try:
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=self._said,
                stderr=self._chatter,
                env=_environment(limits),
                start_new_session=True,  # Ctrl-C in the terminal is for this process, which ends the child
                creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
            )
        except OSError as error:
            self._close_files()
            raise refused(ProblemCode.READ_NOT_STARTED, file, error.strerror or error) from error
        self._late = threading.Event()
        self._timer = threading.Timer(limits.wall_seconds, self._end_late)
        self._timer.daemon = True
        self._timer.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def pid(self) -> int:
        """The process id."""
        return self._process.pid

    def close(self) -> None:
        """End the process, whatever it does."""
        self._timer.cancel()
        with contextlib.suppress(OSError):
            self._process.kill()
        self._process.wait()
        self._close_files()

    def result(self, kind: Any) -> Any:
        """Wait for what is read; ends the process. To be called once.

        Parameters
        ----------
        kind
            A dataclass that the value is.

        Returns
        -------
        Any
            The value; its arrays are read-only.

        Raises
        ------
        RefusedError
            If the file is not read, or takes more than it may.
        """
        from lappet.core.array_codec import CodecError  # not before the child runs
        from lappet.core.value_codec import unpack
        from lappet.foreign.reading_child import ReadRefusal

        try:
            value = unpack(self._answer(), kind | ReadRefusal)
        except CodecError as error:
            raise refused(ProblemCode.READ_DIED, self._file, error.problems[0].value, memory=self._gib()) from error
        finally:
            self.close()
        if isinstance(value, ReadRefusal):
            raise RefusedError(value.problems)
        return value

    def _answer(self) -> bytes:
        """Wait for what the process hands over."""
        status = self._process.wait()
        if status != 0:
            raise self._refusal(status)
        size = os.fstat(self._said.fileno()).st_size
        if size > self._limits.size:
            raise self._size_refusal()
        self._said.seek(0)
        return self._said.read(size)

    def _end_late(self) -> None:
        self._late.set()
        with contextlib.suppress(OSError):
            self._process.kill()

    def _refusal(self, status: int) -> RefusedError:
        """Why the process ended without a value."""
        from lappet.foreign.reading_child import Ending

        timed_out = [-getattr(signal, name) for name in ("SIGXCPU", "SIGALRM") if hasattr(signal, name)]
        if self._late.is_set() or status in timed_out:
            return refused(ProblemCode.READ_TIME, self._file, f"{self._limits.seconds} s")
        if status == Ending.MEMORY:
            return refused(ProblemCode.READ_MEMORY, self._file, self._gib())
        if status == Ending.SIZE:
            return self._size_refusal()
        how = f"signal {-status}" if status < 0 else f"status {status} ({self._last_words()})"
        return refused(ProblemCode.READ_DIED, self._file, how, memory=self._gib())

    def _last_words(self) -> str:
        """Return the end of the last line that the process printed: what Python says of an error."""
        size = os.fstat(self._chatter.fileno()).st_size
        self._chatter.seek(max(0, size - _LAST_BYTES))
        lines = self._chatter.read(_LAST_BYTES).decode(errors="replace").split("\n")
        return next((line.strip() for line in reversed(lines) if line.strip()), "it said nothing")

    def _close_files(self) -> None:
        self._said.close()
        self._chatter.close()

    def _size_refusal(self) -> RefusedError:
        return refused(ProblemCode.READ_RESULT_SIZE, self._file, f"{self._limits.size / 2**20:g} MiB")

    def _gib(self) -> str:
        return f"{self._limits.memory / 2**30:g} GiB"


def _environment(limits: ReadLimits) -> dict[str, str]:
    path = [each for each in sys.path if each and Path(each).is_absolute()]
    environment = {**child_environment(os.environ, path, None), **_ENVIRONMENT}
    if not limits.allow_external:
        environment.pop(_SEARCH_PATH, None)
    return environment
