"""A job of the worker: what was asked, whether it is still wanted, and the newest target in live mode."""

from __future__ import annotations

import threading
from dataclasses import dataclass, field

from lappet.background.worker_requests import Ask, JobKind
from lappet.procedure import Pose


class CancelledError(Exception):
    """The job is not wanted any more."""


@dataclass(eq=False)
class Job:
    """A job and how far it is.

    Parameters
    ----------
    ask
        What was asked.
    running
        Whether it has begun.
    at
        The frame that it is at, once its manifest is known.
    """

    ask: Ask
    running: bool = False
    at: int | None = None
    _target: Pose | None = None
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
        """Whether the job is not wanted any more."""
        return self._cancelled

    def cancel(self) -> None:
        """End the job at its next step; from any thread."""
        with self._changed:
            self._cancelled = True
            self._changed.notify_all()

    def step(self) -> None:
        """Stop a job that was cancelled; called between steps.

        Raises
        ------
        CancelledError
            If it is cancelled.
        """
        if self._cancelled:
            raise CancelledError

    def aim(self, target: Pose) -> None:
        """Set the newest target; from any thread.

        Parameters
        ----------
        target
            The target.
        """
        with self._changed:
            self._target = target
            self._changed.notify_all()

    def next_target(self) -> Pose:
        """Wait for a target that has not been taken yet.

        Returns
        -------
        Pose
            The target.

        Raises
        ------
        CancelledError
            If the job is cancelled.
        """
        with self._changed:
            self._changed.wait_for(lambda: self._target is not None or self._cancelled)
            self.step()
            assert self._target is not None
            target, self._target = self._target, None
            return target
