"""A job of the worker: what was asked, whether it is still wanted, and the hook's newest target in live mode."""

from __future__ import annotations

import threading
from dataclasses import dataclass, field

from lappet.background.worker_requests import Ask, JobKind
from lappet.procedure import Point


class CancelledError(Exception):
    """The job is not wanted any more."""


@dataclass(eq=False)
class Job:
    """What was asked and how far it is. at: the frame it is at, once planned."""

    ask: Ask
    running: bool = False
    at: int | None = None
    _target: Point | None = None
    _cancelled: bool = False
    _changed: threading.Condition = field(default_factory=threading.Condition)

    @property
    def number(self) -> int:
        """What its owner calls it."""
        return self.ask.job

    @property
    def kind(self) -> JobKind:
        """What it is to give."""
        return self.ask.kind

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
