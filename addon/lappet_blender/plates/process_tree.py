"""A command with all that it starts: ended together, so that no Blender and no FFmpeg draws on for nobody.

On POSIX they are a group of processes, on Windows a job.
"""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any

from .windows_job import WindowsJob


class ProcessTree:
    """A command under way, whose output is read line by line.

    environment: variables besides those of this process.
    """

    def __init__(self, command: Sequence[str], environment: Mapping[str, str]) -> None:
        self._job = WindowsJob() if os.name == "nt" else None
        start: Any = subprocess.Popen if self._job is None else self._job.start
        self.process: subprocess.Popen[str] = start(
            command,
            env={**os.environ, **environment},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            encoding="utf-8",
            errors="replace",
            start_new_session=True,
            creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
        )

    def end(self, at_once: bool = False) -> None:
        """Ask the command and what it has started to end. at_once: nothing of it can refuse; nor can it on Windows."""
        if self._job is not None:
            self._job.end()
            return
        with suppress(ProcessLookupError):  # all of it has ended
            os.killpg(self.process.pid, signal.SIGKILL if at_once else signal.SIGTERM)

    def close(self) -> None:
        """Let go of it; on Windows what the command has left behind ends."""
        if self._job is not None:
            self._job.close()
