"""Plans in the frame store, so that they are found again without compiling: after an undo, after a file is opened."""

from __future__ import annotations

from typing import Any

from lappet.background.plan import EpochShape, Plan, PlannedFrame, ShownFrame
from lappet.daemon.frame_solver import STATE_ARRAYS
from lappet.solve.store import FrameStore, StoredFrame

_FORMAT = 1
_SHAPE_ARRAYS = ("rest", "triangles", "origin", "grid", "depth", "face")


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
        if epoch.key not in store:
            arrays = {name: getattr(epoch, name) for name in _SHAPE_ARRAYS}
            if not store.put(epoch.key, StoredFrame({"kind": "epoch", "format": _FORMAT}, arrays)):
                return False
    header: dict[str, Any] = {
        "kind": "plan",
        "format": _FORMAT,
        "epochs": [[epoch.key, epoch.start_time] for epoch in plan.epochs],
        "frames": [[f.time, f.epoch, f.key, list(f.hooks), list(f.sutures)] for f in plan.frames],
        "hooks": list(plan.hooks),
        "sutures": list(plan.sutures),
        "landmarks": list(plan.landmarks),
        "landmarks_at": [list(each) for each in plan.landmarks_at],
        "notes": list(plan.notes),
    }
    return store.put(plan.key, StoredFrame(header))


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
    stored = store.get(key)
    if stored is None or stored.header.get("kind") != "plan" or stored.header.get("format") != _FORMAT:
        return None
    header = stored.header
    held = {} if shapes is None else shapes
    epochs = []
    for name, start in header["epochs"]:
        shape = held.get(name)
        if shape is None or shape.start_time != start:
            shape = _shape(store, name, start) if shape is None else _from(shape, start)
            if shape is None:
                return None
            held[name] = shape
        epochs.append(shape)
    return Plan(
        key=key,
        epochs=tuple(epochs),
        frames=tuple(
            PlannedFrame(time, epoch, frame, tuple(hooks), tuple(sutures))
            for time, epoch, frame, hooks, sutures in header["frames"]
        ),
        hooks=tuple(header["hooks"]),
        sutures=tuple(header["sutures"]),
        landmarks=tuple(header["landmarks"]),
        landmarks_at=tuple(tuple(each) for each in header["landmarks_at"]),
        notes=tuple(header["notes"]),
    )


def get_shown(store: FrameStore, frame_key: str) -> ShownFrame | None:
    """Look up what is shown of a solved frame.

    Parameters
    ----------
    store
        The store.
    frame_key
        Key of the frame.

    Returns
    -------
    ShownFrame | None
        The frame, or None where the store does not hold it.
    """
    stored = store.get(frame_key)
    if stored is None or "points" not in stored.arrays:
        return None
    return shown_frame(stored.header, stored.arrays)


def shown_frame(header: dict[str, Any], arrays: dict[str, Any]) -> ShownFrame:
    """Take what is shown of a frame.

    Parameters
    ----------
    header
        Fields of the message `frame`.
    arrays
        Its arrays by name.

    Returns
    -------
    ShownFrame
        The frame without its state.
    """
    rest = {name: array for name, array in arrays.items() if name != "points" and name not in STATE_ARRAYS}
    return ShownFrame(arrays["points"], dict(header), rest)


def _shape(store: FrameStore, key: str, start: float) -> EpochShape | None:
    stored = store.get(key)
    if stored is None or any(name not in stored.arrays for name in _SHAPE_ARRAYS):
        return None
    return EpochShape(key, float(start), **{name: stored.arrays[name] for name in _SHAPE_ARRAYS})


def _from(shape: EpochShape, start: float) -> EpochShape:
    """The same surface in an epoch that starts at another time."""
    return EpochShape(shape.key, float(start), **{name: getattr(shape, name) for name in _SHAPE_ARRAYS})
