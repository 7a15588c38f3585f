"""Which frames are solved, stale, failed or missing."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby
from typing import Literal

from .controller import Controller, frame_at, manifests

State = Literal["solved", "stale", "failed", "missing"]


@dataclass(frozen=True)
class FrameRun:
    """Frames first to last, both included, that are all in one state."""

    state: State
    first: int
    last: int


def frame_states(controller: Controller) -> dict[int, State]:
    """The state of every frame of the procedure, by time; made anew only when something changed."""
    revision, states = controller.states
    if revision != controller.revision:
        states = {time: _state(controller, time) for time in _times(controller)}
        controller.states = (controller.revision, states)
    return states  # type: ignore[return-value]


def frame_runs_of(controller: Controller) -> tuple[FrameRun, ...]:
    """The same as stretches of equal state, in order."""
    runs = []
    for state, group in groupby(frame_states(controller).items(), key=lambda item: item[1]):
        times = [time for time, _ in group]
        runs.append(FrameRun(state, times[0], times[-1]))
    return tuple(runs)


def count_states(controller: Controller) -> dict[State, int]:
    """How many frames are in each state."""
    counts: dict[State, int] = {"solved": 0, "stale": 0, "failed": 0, "missing": 0}
    for state in frame_states(controller).values():
        counts[state] += 1
    return counts


def is_current(controller: Controller, time: float) -> bool:
    """Whether the newest manifest's frame at a time is what the procedure asks for, as far as it is known by now."""
    return controller.manifest is not None or time < controller.changed_from


def _times(controller: Controller) -> range:
    if controller.procedure is not None:
        return controller.procedure.frames()
    manifest = controller.newest()
    return (
        range(0)
        if manifest is None or not manifest.frames
        else range(manifest.frames[0].time, manifest.frames[-1].time + 1)
    )


def _state(controller: Controller, time: int) -> State:
    newest = controller.newest()
    frame = None if newest is None or not is_current(controller, time) else frame_at(newest, time)
    if frame is not None:
        if controller.holds(frame.key):
            return "solved"
        if frame.key in manifests.failures:
            return "failed"
    for manifest in [*([controller.manifest] if controller.manifest else []), *controller.past]:
        old = frame_at(manifest, time)
        if old is not None and controller.holds(old.key):
            return "stale"
    return "missing"
