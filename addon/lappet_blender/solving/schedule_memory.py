"""Schedules that were made in this session, by key, so that undo and redo find theirs at once."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import replace

from lappet.background.schedule import EpochShape, Schedule
from lappet.core.problem import Problem
from lappet.solve.store import FrameStore

LIMIT = 64


class ScheduleMemory:
    """The schedules and refusals used last, and why frames failed. Equal epochs are one object in all schedules."""

    def __init__(self, limit: int = LIMIT) -> None:
        self.failures: dict[str, Problem] = {}  # by frame key: why it failed
        self._limit = limit
        self._schedules: OrderedDict[str, Schedule] = OrderedDict()
        self._refused: OrderedDict[str, tuple[Problem, ...]] = OrderedDict()

    def keep(self, schedule: Schedule, key: str = "") -> Schedule:
        """Keep a schedule, under its key and under that it was asked for with; return it with epochs shared."""
        known = self._epochs()
        epochs: tuple[EpochShape, ...] = tuple(
            known.get((epoch.key, epoch.start_time), epoch) for epoch in schedule.epochs
        )
        schedule = replace(schedule, epochs=epochs)
        for each in dict.fromkeys((schedule.key, key or schedule.key)):
            self._schedules[each] = schedule
            self._schedules.move_to_end(each)
            self._refused.pop(each, None)
        while len(self._schedules) > self._limit:
            self._schedules.popitem(last=False)
        return schedule

    def find(self, key: str, store: FrameStore) -> Schedule | None:
        """The schedule of a key, from memory or from the store."""
        schedule = self._schedules.get(key)
        if schedule is not None:
            self._schedules.move_to_end(key)
            return schedule
        from lappet.background.schedule_store import get_schedule

        stored = get_schedule(store, key, {name: epoch for (name, _), epoch in self._epochs().items()})
        return None if stored is None else self.keep(stored, key)

    def refuse(self, key: str, problems: tuple[Problem, ...]) -> None:
        """Remember why the procedure of a key is refused."""
        self._refused[key] = problems
        while len(self._refused) > self._limit:
            self._refused.popitem(last=False)

    def refused(self, key: str) -> tuple[Problem, ...] | None:
        """Why the procedure of a key is refused, or None."""
        return self._refused.get(key)

    def drop(self, key: str) -> None:
        """Drop the schedule and the refusal of a key, so that it is asked for again."""
        self._schedules.pop(key, None)
        self._refused.pop(key, None)

    def clear(self) -> None:
        """Drop everything."""
        self._schedules.clear()
        self._refused.clear()
        self.failures.clear()

    def _epochs(self) -> dict[tuple[str, float], EpochShape]:
        return {(epoch.key, epoch.start_time): epoch for each in self._schedules.values() for epoch in each.epochs}
