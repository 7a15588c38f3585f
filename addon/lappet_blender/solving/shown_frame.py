"""What is shown at a frame: the solved one, an older manifest's, the last one before it, or the tissue at rest."""

from __future__ import annotations

import math
from dataclasses import dataclass

from lappet.background.manifest import EpochShape, ListedFrame, Manifest
from lappet.daemon.solved_frame import SolvedFrame

from .controller import Controller, frame_at, frame_cache
from .frame_states import is_current

AHEAD, BEHIND = 12, 4  # frames that are read before they are asked for


@dataclass(frozen=True, eq=False)
class Shown:
    """What is shown.

    time: that of the frame shown, whose hooks and sutures `manifest` names. frame: None = the epoch at rest. stale: the
    procedure has changed since, or this is an earlier frame in place of one that is not solved.
    """

    manifest: Manifest
    epoch: EpochShape
    time: int
    frame: SolvedFrame | None
    stale: bool


def find_shown(controller: Controller, time: float) -> Shown | None:
    """What to show at a time code; times outside the procedure show its first or last frame."""
    newest = controller.newest()
    if newest is None or not newest.frames:
        return None
    at = min(max(math.floor(time + 1e-6), newest.frames[0].time), newest.frames[-1].time)
    own = frame_at(newest, at)
    assert own is not None
    live = controller.live
    if live is not None and live.frame is not None and live.time == at:
        epoch = newest.epochs[own.epoch]
        if len(live.frame.points) == len(epoch.rest):
            return Shown(newest, epoch, at, live.frame, stale=False)
    shown = _own_frame(controller, newest, own) or _older(controller, at) or _before(controller, newest, at)
    return shown or Shown(newest, newest.epochs[own.epoch], at, None, stale=False)


def read_neighbors(controller: Controller, time: float) -> None:
    """Have the frames about a time read into memory, those ahead first, on a thread."""
    manifest = controller.newest()
    if manifest is None or not manifest.frames:
        return
    index = math.floor(time + 1e-6) - manifest.frames[0].time
    near = [*range(index + 1, index + AHEAD + 1), *range(index - 1, index - BEHIND - 1, -1)]
    keys = [manifest.frames[i].key for i in near if 0 <= i < len(manifest.frames)]
    keys = [key for key in keys if controller.holds(key) and key not in frame_cache]
    if keys:
        frame_cache.read_ahead(keys, controller.store)


def _own_frame(controller: Controller, manifest: Manifest, own: ListedFrame) -> Shown | None:
    return _loaded(controller, manifest, own, stale=False) if is_current(controller, own.time) else None


def _older(controller: Controller, at: int) -> Shown | None:
    for manifest in controller.past:
        frame = frame_at(manifest, at)
        shown = None if frame is None else _loaded(controller, manifest, frame, stale=True)
        if shown is not None:
            return shown
    return None


def _before(controller: Controller, manifest: Manifest, at: int) -> Shown | None:
    for frame in reversed(manifest.frames):
        if frame.time < at and controller.holds(frame.key):
            shown = _loaded(controller, manifest, frame, stale=True)
            if shown is not None:
                return shown
    return None


def _loaded(controller: Controller, manifest: Manifest, frame: ListedFrame, *, stale: bool) -> Shown | None:
    """The frame from memory or the store; one that has vanished from the store meanwhile counts as missing."""
    if not controller.holds(frame.key):
        return None
    loaded = frame_cache.get(frame.key, controller.store)
    if loaded is None:
        controller.known.discard(frame.key)
        controller.notify()
        return None
    return Shown(manifest, manifest.epochs[frame.epoch], frame.time, loaded, stale)
