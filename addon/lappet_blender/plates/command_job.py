"""A file that an installed `lappet` writes: a thread that makes the skin cache and then runs the command.

It knows no Blender, so that a thread may run it.
"""

from __future__ import annotations

import shutil
import subprocess
import tempfile
import threading
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from time import monotonic
from typing import Literal

from lappet.core.problem import Problem, ProblemsError, file_problem, problem, refused
from lappet.core.problem_code import ProblemCode

from .process_tree import ProcessTree

JobState = Literal["cache", "drawing", "done", "failed", "cancelled"]
_LAST_LINES = 4
_TEMPORARY = ("TMPDIR", "TEMP", "TMP")  # variables that say where temporary files are written
_PATIENCE = 5.0  # seconds that a command has to end after it was asked to


def find_command(named: str) -> list[str]:
    """The command line to run: what the preferences name, or else the `lappet` on the search path.

    Raises RefusedError where there is none.
    """
    wanted = named.strip()
    found = shutil.which(wanted or "lappet")
    if found is None:
        raise refused(ProblemCode.LAPPET_COMMAND_NONE, "", wanted or "lappet")
    return [found]


@dataclass(eq=False)
class CommandJob:
    """A command under way. cache: writes the skin cache to a file. arguments: of the command, from the cache's file on.

    said: the command's last lines. problem: why it failed.
    """

    target: Path
    command: Sequence[str]
    cache: Callable[[Path], object]
    arguments: Callable[[Path], Sequence[str]]
    state: JobState = "cache"
    said: deque[str] = field(default_factory=lambda: deque(maxlen=_LAST_LINES))
    problem: Problem | None = None
    started: float = field(default_factory=monotonic)
    seconds: float = 0.0

    def start(self) -> None:
        """Begin; returns at once."""
        self._cancelled = threading.Event()
        self._lock = threading.Lock()
        self._tree: ProcessTree | None = None
        self._thread = threading.Thread(target=self._run, name=f"lappet {self.target.name}", daemon=True)
        self._thread.start()

    @property
    def running(self) -> bool:
        """Whether it has not ended yet."""
        return self.state in ("cache", "drawing")

    def cancel(self, wait: float = 0.0) -> None:
        """End it and what it has started; what it had begun to write stays as it leaves it.

        wait: seconds to wait for it.
        """
        self._cancelled.set()
        with self._lock:
            if self._tree is not None and self._tree.process.poll() is None:
                self._tree.end()
                stubborn = threading.Timer(_PATIENCE, self._end_at_once, [self._tree])
                stubborn.daemon = True
                stubborn.start()
        self._thread.join(wait)

    def _end_at_once(self, tree: ProcessTree) -> None:
        if self.running:
            tree.end(at_once=True)

    def join(self, timeout: float) -> None:
        """Wait for its end, at most `timeout` seconds."""
        self._thread.join(timeout)

    def _run(self) -> None:
        try:
            # On Windows a file that a process has just let go of may stay open for a moment.
            with tempfile.TemporaryDirectory(prefix="lappet_", ignore_cleanup_errors=True) as folder:
                cache = Path(folder) / f"{self.target.stem or 'operation'}.usdc"
                self.cache(cache)
                if not self._cancelled.is_set():
                    self._call([*self.command, *self.arguments(cache)], Path(folder))
        except ProblemsError as error:
            self.problem = error.problems[0]
        except OSError as error:
            self.problem = file_problem(error)
        except Exception as error:  # whatever it is, the panel says it
            self.problem = problem(ProblemCode.INTERNAL, "", f"{type(error).__name__}: {error}")
        self.seconds = monotonic() - self.started
        if self._cancelled.is_set():
            self.state, self.problem = "cancelled", None
        else:
            self.state = "done" if self.problem is None else "failed"

    def _call(self, command: Sequence[str], folder: Path) -> None:
        """Run the command; what it and its processes write for themselves goes with the folder."""
        self.state = "drawing"
        tree = ProcessTree(command, dict.fromkeys(_TEMPORARY, str(folder)))
        with self._lock:
            self._tree = tree
        if self._cancelled.is_set():  # between its start and now
            tree.end()
        with tree.process as process:
            assert process.stdout is not None
            for line in process.stdout:
                if line.strip():
                    self.said.append(line.strip())
            status = _ended(tree)
        if self._cancelled.is_set():
            tree.end(at_once=True)  # what has not ended with the command
        tree.close()
        if status:
            said = " ".join(self.said) or f"exit status {status}"
            self.problem = problem(ProblemCode.LAPPET_COMMAND_FAILED, self.target.name, said)


def _ended(tree: ProcessTree) -> int:
    """The exit status; a command that has closed its output but does not end is killed."""
    try:
        return tree.process.wait(_PATIENCE)
    except subprocess.TimeoutExpired:
        tree.end(at_once=True)
        tree.process.kill()
        return tree.process.wait()
