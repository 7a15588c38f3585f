"""A report's progress as the lines that it is told."""

from __future__ import annotations

from lappet.reports.report_progress import ReportProgress
from lappet.solve.solve_frames import SolveObserver


class Told(ReportProgress):
    """Keeps what it is told."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def begin(self, solves: int) -> None:
        self.lines.append(f"{solves} solves")

    def solve(self, name: str) -> SolveObserver:
        self.lines.append(name)
        return _ToldOfFrames(self.lines)

    def say(self, line: str) -> None:
        self.lines.append(line)


class _ToldOfFrames(SolveObserver):
    def __init__(self, lines: list[str]) -> None:
        self._lines = lines

    def begin(self, frames: int) -> None:
        self._lines.append(f"{frames} frames")
