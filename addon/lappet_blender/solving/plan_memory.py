"""Plans made in this session, by key, so that undo and redo find theirs at once, and what is known of their frames."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import replace

from lappet.background.assessment import Assessment
from lappet.background.plan import EpochShape, Plan
from lappet.core.problem import Problem
from lappet.solve.store import FrameStore

LIMIT = 64


class PlanMemory:
    """The plans and refusals used last, and why frames failed. Equal epochs are one object in all plans."""

    def __init__(self, limit: int = LIMIT) -> None:
        self.failures: dict[str, Problem] = {}  # by frame key: why it failed
        self.assessments: dict[str, Assessment] = {}  # by plan key: what is to be known of its frames
        self._limit = limit
        self._plans: OrderedDict[str, Plan] = OrderedDict()
        self._refused: OrderedDict[str, tuple[Problem, ...]] = OrderedDict()

    def keep(self, plan: Plan, key: str = "") -> Plan:
        """Keep a plan, under its key and under that it was asked for with; return it with epochs shared."""
        known = self._epochs()
        epochs: tuple[EpochShape, ...] = tuple(known.get((epoch.key, epoch.start_time), epoch) for epoch in plan.epochs)
        plan = replace(plan, epochs=epochs)
        for each in dict.fromkeys((plan.key, key or plan.key)):
            self._plans[each] = plan
            self._plans.move_to_end(each)
            self._refused.pop(each, None)
        while len(self._plans) > self._limit:
            self._plans.popitem(last=False)
        return plan

    def find(self, key: str, store: FrameStore) -> Plan | None:
        """The plan of a key, from memory or from the store."""
        plan = self._plans.get(key)
        if plan is not None:
            self._plans.move_to_end(key)
            return plan
        from lappet.background.plan_store import get_plan

        stored = get_plan(store, key, {name: epoch for (name, _), epoch in self._epochs().items()})
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
        """Drop the plan and the refusal of a key, so that it is asked for again."""
        self._plans.pop(key, None)
        self._refused.pop(key, None)

    def clear(self) -> None:
        """Drop everything."""
        self._plans.clear()
        self._refused.clear()
        self.failures.clear()
        self.assessments.clear()

    def _epochs(self) -> dict[tuple[str, float], EpochShape]:
        return {(epoch.key, epoch.start_time): epoch for each in self._plans.values() for epoch in each.epochs}
