"""Show how a report's solves go: two bars on a terminal, a line as each begins and as it ends elsewhere."""

from __future__ import annotations

import contextlib
import sys
from types import TracebackType
from typing import TYPE_CHECKING, TextIO

from lappet.commands.solve_progress import BarProgress, solve_bar
from lappet.core.problem import Problem
from lappet.reports.report_progress import ReportProgress
from lappet.solve.solve_frames import SolveObserver

if TYPE_CHECKING:
    from rich.progress import Progress


class PlainReportProgress(ReportProgress):
    """Progress as lines, on a stream that is no terminal.

    Parameters
    ----------
    stream
        The stream; standard error when None.
    """

    def __init__(self, stream: TextIO | None = None) -> None:
        self._stream = stream or sys.stderr
        self._solves = 0
        self._begun = 0

    def __enter__(self) -> PlainReportProgress:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        pass

    def begin(self, solves: int) -> None:
        self._solves = solves

    def solve(self, name: str) -> SolveObserver:
        self._begun += 1
        self.say(f"{name} ({self._begun} of {self._solves})")
        return SolveObserver()

    def say(self, line: str) -> None:
        with contextlib.suppress(OSError, ValueError):  # a full disk or a closed pipe is no reason to lose the report
            print(line, file=self._stream, flush=True)


class BarReportProgress(ReportProgress):
    """Progress as a bar of the solves and below it one of the frames of the present solve; used as a context."""

    def __init__(self) -> None:
        self._bar = solve_bar()
        self._task = self._bar.add_task("solves", total=None, state="")
        self._begun = 0
        self._present: _SolveProgress | None = None

    def __enter__(self) -> BarReportProgress:
        self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        with contextlib.suppress(OSError):  # as of lines
            if kind is None:
                self._finish()
            self._bar.stop()

    def begin(self, solves: int) -> None:
        self._bar.update(self._task, total=solves)

    def solve(self, name: str) -> SolveObserver:
        with contextlib.suppress(OSError):
            self._finish()
        self._begun += 1
        self._present = _SolveProgress(self._bar, name)
        return self._present

    def say(self, line: str) -> None:
        with contextlib.suppress(OSError):
            self._bar.console.print(line, markup=False, highlight=False)

    def _finish(self) -> None:
        """Count the present solve, of which a line tells, and take its frames away."""
        self._bar.update(self._task, completed=self._begun)
        if self._present is not None:
            self._present.remove()


class _SolveProgress(BarProgress):
    """The frames of one of several solves, there before it is known how many; the solve's own report has its notes."""

    def __init__(self, bars: Progress, title: str) -> None:
        super().__init__(bars)
        self._task = bars.add_task(title, total=None, state="")

    def begin(self, frames: int) -> None:
        if self._task is not None:
            self._bar.update(self._task, total=frames)

    def remove(self) -> None:
        """Take the bar out of the display."""
        if self._task is not None:
            self._bar.remove_task(self._task)
            self._task = None

    def note(self, note: Problem) -> None:
        pass


def report_progress() -> PlainReportProgress | BarReportProgress:
    """Choose how to show the progress of a report: bars where standard error is a terminal, else lines.

    Returns
    -------
    PlainReportProgress | BarReportProgress
        The observer.
    """
    return BarReportProgress() if sys.stderr.isatty() else PlainReportProgress()
