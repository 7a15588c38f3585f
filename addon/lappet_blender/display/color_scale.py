"""The full value of the color scale, one for a whole procedure, so that its frames compare."""

from __future__ import annotations

from time import monotonic

import bpy

from lappet.background.manifest import Manifest
from lappet.daemon.solved_frame import SolvedFrame
from lappet.drawing.quantity_scale import frame_peak, full_value

from ..solving import frames

_BUDGET = 0.01  # seconds of the main thread that one call may read frames for, in a window
_peaks: dict[tuple[str, str], float] = {}


def peak_of(key: str, quantity: str, frame: SolvedFrame) -> float:
    """What a frame asks of the scale of a quantity, kept by the frame's key."""
    if (key, quantity) not in _peaks:
        if len(_peaks) > 50_000:
            _peaks.clear()
        values = frame.scalar(quantity)
        _peaks[key, quantity] = 0.0 if values is None else frame_peak(values)
    return _peaks[key, quantity]


def scan_frames(scene: bpy.types.Scene, manifest: Manifest, quantity: str, patient: bool) -> bool:
    """Read what solved frames of a manifest ask of the scale; False while some are left to a later call.

    patient: read all, however long it takes (renders, scripts).
    """
    begun = monotonic()
    for listed in manifest.frames:
        if (listed.key, quantity) in _peaks or frames.frame_state(scene, listed.time) != "solved":
            continue
        if not patient and monotonic() - begun > _BUDGET:
            return False
        shown = frames.shown_at(scene, listed.time)
        if shown is not None and shown.frame is not None and shown.manifest.key == manifest.key and not shown.stale:
            peak_of(listed.key, quantity, shown.frame)
    return True


def highest_of(manifests: list[Manifest], quantity: str) -> float:
    """The value at the top of the scale of some manifests: of all their frames that were read, rounded up."""
    return full_value(
        max((_peaks.get((f.key, quantity), 0.0) for manifest in manifests for f in manifest.frames), default=0.0)
    )
