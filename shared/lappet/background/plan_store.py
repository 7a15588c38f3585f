"""Plans in the frame store, so that they are found again without compiling: after an undo, after a file is opened."""

from __future__ import annotations

from dataclasses import dataclass, replace

from lappet.background.plan import EpochShape, Plan
from lappet.solve.store import FrameStore


@dataclass(frozen=True, eq=False)
class StoredPlan:
    """A plan whose epochs lie under keys of their own, since many plans share them.

    Parameters
    ----------
    plan
        The plan without epochs.
    epochs
        Key and start time of each epoch.
    """

    plan: Plan
    epochs: tuple[tuple[str, float], ...]


def put_plan(store: FrameStore, plan: Plan) -> bool:
    """Keep a plan: the surfaces of its epochs that are not there yet, then the plan itself.

    Parameters
    ----------
    store
        The store.
    plan
        The plan.

    Returns
    -------
    bool
        Whether the disk took it (`FrameStore.trouble`).
    """
    for epoch in plan.epochs:
        if epoch.key not in store and not store.put(epoch.key, epoch):
            return False
    epochs = tuple((epoch.key, epoch.start_time) for epoch in plan.epochs)
    return store.put(plan.key, StoredPlan(replace(plan, epochs=()), epochs))


def get_plan(store: FrameStore, key: str, shapes: dict[str, EpochShape] | None = None) -> Plan | None:
    """Look up a plan.

    Parameters
    ----------
    store
        The store.
    key
        Key of the plan.
    shapes
        Surfaces that the caller holds, by key; they are not read again, and what is read is added.

    Returns
    -------
    Plan | None
        The plan, or None where it or one of its surfaces is not there (any more).
    """
    stored = store.get(key, StoredPlan)
    if stored is None:
        return None
    held = {} if shapes is None else shapes
    epochs = []
    for name, start in stored.epochs:
        shape = held.get(name) or store.get(name, EpochShape)
        if shape is None:
            return None
        held[name] = shape if shape.start_time == start else replace(shape, start_time=start)
        epochs.append(held[name])
    return replace(stored.plan, epochs=tuple(epochs))
