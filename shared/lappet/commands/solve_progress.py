"""Show how a solve goes: a bar on a terminal, a line per frame elsewhere."""

from __future__ import annotations

import contextlib
import sys
import time
from types import TracebackType
from typing import TYPE_CHECKING, TextIO

from lappet.core.problem import Problem
from lappet.daemon.frame_solver import Iteration
from lappet.solve.solve_frames import FrameResult, SolveObserver

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID


class PlainProgress(SolveObserver):
    """Progress as a line per frame, on a stream that is no terminal.

    Parameters
    ----------
    stream
        The stream; standard error when None.
    """

    def __init__(self, stream: TextIO | None = None) -> None:
        self._stream = stream or sys.stderr
        self._frames = 0
        self._done = 0

    def __enter__(self) -> PlainProgress:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        pass

    def begin(self, frames: int) -> None:
        self._frames = frames

    def shared(self, session: int) -> None:
        self._say(shared_line(session))

    def frame(self, frame: FrameResult) -> None:
        self._done += 1
        self._say(f"{describe(frame)} ({self._done}/{self._frames})")

    def note(self, note: Problem) -> None:
        self._say(f"{note.severity}: {note}")

    def _say(self, line: str) -> None:
        with contextlib.suppress(OSError, ValueError):  # a full disk or a closed pipe is no reason to lose the solve
            print(line, file=self._stream, flush=True)


class BarProgress(SolveObserver):
    """Progress as a bar on a terminal, with the frame and the residual it stands at; used as a context.

    Parameters
    ----------
    bars
        The display to draw in; one of its own when None.
    """

    def __init__(self, bars: Progress | None = None) -> None:
        self._bar = bars or solve_bar()
        self._task: TaskID | None = None
        self._shown = 0.0

    def __enter__(self) -> BarProgress:
        self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        with contextlib.suppress(OSError):  # as of lines
            self._bar.stop()

    def begin(self, frames: int) -> None:
        self._task = self._bar.add_task("frames", total=frames, state="")

    def shared(self, session: int) -> None:
        with contextlib.suppress(OSError):
            self._bar.console.print(shared_line(session), markup=False, highlight=False)

    def iteration(self, iteration: Iteration) -> None:
        if time.monotonic() - self._shown < 0.1 or self._task is None:
            return
        self._shown = time.monotonic()
        state = f"frame {iteration.time:g}: iteration {iteration.newton}, residual {iteration.residual:.1e}"
        if iteration.gap > 0.0:
            state += f", gap {iteration.gap:.2g} mm"
        with contextlib.suppress(OSError):
            self._bar.update(self._task, state=state)

    def frame(self, frame: FrameResult) -> None:
        if self._task is None:
            return
        with contextlib.suppress(OSError):
            self._bar.update(self._task, advance=1, state=describe(frame))

    def note(self, note: Problem) -> None:
        with contextlib.suppress(OSError):
            self._bar.console.print(f"{note.severity}: {note}", markup=False, highlight=False)


def solve_bar() -> Progress:
    """Make a display of bars on standard error, none in it yet.

    Returns
    -------
    Progress
        The display; each bar has a text `state` at its end.
    """
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    return Progress(
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("{task.fields[state]}", markup=False),
        console=Console(stderr=True),
    )


def solve_progress(plain: bool = False) -> PlainProgress | BarProgress:
    """Choose how to show progress: a bar where standard error is a terminal, else lines.

    Parameters
    ----------
    plain
        Whether lines are wanted anyway.

    Returns
    -------
    PlainProgress | BarProgress
        The observer.
    """
    return PlainProgress() if plain or not sys.stderr.isatty() else BarProgress()


def shared_line(session: int) -> str:
    """Say that a session is shared, and how others follow it.

    Parameters
    ----------
    session
        Number of the session.

    Returns
    -------
    str
        The line.
    """
    return f"session {session} is shared: lappet follow PROCEDURE {session}"


def describe(frame: FrameResult) -> str:
    """Describe a frame in a line: where it came from and what it took.

    Parameters
    ----------
    frame
        The frame.

    Returns
    -------
    str
        The line.
    """
    if frame.looked_up:
        return f"frame {frame.constraints.time:g}: looked up"
    said = frame.solved.diagnostics
    return (
        f"frame {frame.constraints.time:g}: {said.newton} Newton, {said.pcg} PCG iterations, "
        f"{said.displacement_to_come:.1g} mm to come, {frame.wall_seconds:.1f} s"
    )
