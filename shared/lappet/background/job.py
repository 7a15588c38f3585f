"""A job of the worker: what was asked, whether it is still wanted, and the hook's newest target in live mode."""

from __future__ import annotations

import threading
from dataclasses import dataclass, field
from typing import Literal

from lappet.procedure import Point, Procedure
from lappet.program.settings import SolverSettings

Kind = Literal["plan", "solve", "live"]


class CancelledError(Exception):
    """The job is not wanted any more."""


@dataclass(eq=False)
class Job:
    """What was asked. until: last frame to solve. time, hook: of live mode. at: the frame it is at, once planned."""

    number: int
    kind: Kind
    procedure: Procedure
    settings: SolverSettings
    until: int | None = None
    time: int = 0
    hook: str = ""
    running: bool = False
    at: int | None = None
    _target: Point | None = None
    _cancelled: bool = False
    _changed: threading.Condition = field(default_factory=threading.Condition)

    @property
    def cancelled(self) -> bool:
        """Whether it is not wanted any more."""
        return self._cancelled

    def cancel(self) -> None:
        """Ends it at its next step; from any thread."""
        with self._changed:
            self._cancelled = True
            self._changed.notify_all()

    def step(self) -> None:
        """Raises CancelledError once it is cancelled; called between steps."""
        if self._cancelled:
            raise CancelledError

    def aim(self, target: Point) -> None:
        """Sets the newest target, mm; from any thread."""
        with self._changed:
            self._target = target
            self._changed.notify_all()

    def next_target(self) -> Point:
        """Waits for a target that has not been taken yet. Raises CancelledError."""
        with self._changed:
            self._changed.wait_for(lambda: self._target is not None or self._cancelled)
            self.step()
            assert self._target is not None
            target, self._target = self._target, None
            return target
