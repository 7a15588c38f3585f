"""A command with all that it starts: ended together, so that no Blender and no FFmpeg draws on for nobody."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Sequence
from contextlib import suppress

_WINDOWS = os.name == "nt"


def start_tree(command: Sequence[str]) -> subprocess.Popen[str]:
    """Start a command whose output is read line by line; its processes are a group of their own."""
    return subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        encoding="utf-8",
        errors="replace",
        start_new_session=True,
        creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
    )


def end_tree(process: subprocess.Popen[str], at_once: bool = False) -> None:
    """Ask a command and what it has started to end. at_once: nothing of it can refuse."""
    if _WINDOWS:
        if process.poll() is None:  # only of a process that lives are the children known
            call = ("taskkill", "/T", "/F", "/PID", str(process.pid))
            subprocess.run(call, capture_output=True, check=False)
        return
    with suppress(ProcessLookupError):  # all of it has ended
        os.killpg(process.pid, signal.SIGKILL if at_once else signal.SIGTERM)
