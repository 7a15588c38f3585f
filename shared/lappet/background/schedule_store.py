"""Schedules in the frame store: they are found again without compiling, after an undo or when a file is opened."""

from __future__ import annotations

from dataclasses import dataclass, replace

from lappet.background.schedule import EpochShape, Schedule
from lappet.solve.store import FrameStore


@dataclass(frozen=True, eq=False)
class StoredSchedule:
    """A schedule whose epochs lie under keys of their own, since many schedules share them.

    Parameters
    ----------
    schedule
        The schedule without epochs.
    epochs
        Key and start time of each epoch.
    """

    schedule: Schedule
    epochs: tuple[tuple[str, float], ...]


def put_schedule(store: FrameStore, schedule: Schedule) -> bool:
    """Keep a schedule: the surfaces of its epochs that are not there yet, then the schedule itself.

    Parameters
    ----------
    store
        The store.
    schedule
        The schedule.

    Returns
    -------
    bool
        Whether the disk took it (`FrameStore.trouble`).
    """
    for epoch in schedule.epochs:
        if epoch.key not in store and not store.put(epoch.key, epoch):
            return False
    epochs = tuple((epoch.key, epoch.start_time) for epoch in schedule.epochs)
    return store.put(schedule.key, StoredSchedule(replace(schedule, epochs=()), epochs))


def get_schedule(store: FrameStore, key: str, shapes: dict[str, EpochShape] | None = None) -> Schedule | None:
    """Look up a schedule.

    Parameters
    ----------
    store
        The store.
    key
        Key of the schedule.
    shapes
        Surfaces that the caller holds, by key; they are not read again, and what is read is added.

    Returns
    -------
    Schedule | None
        The schedule, or None where it or one of its surfaces is not there (any more).
    """
    stored = store.get(key, StoredSchedule)
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
    return replace(stored.schedule, epochs=tuple(epochs))
