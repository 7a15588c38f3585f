"""Which frame of the scene a panel shows."""

from __future__ import annotations

from typing import Any

import bpy

from ..model.event_kinds import CUT_KINDS, HOLD_KINDS, SEWN_KINDS
from ..model.event_list import event_end, event_time


def panel_frame(scene: bpy.types.Scene, panel: Any) -> int:
    """The frame that a panel shows, as its events say it.

    Where tissue is highest is known when all is solved: until a plate is written, "raised" is the middle of the pull.
    """
    if panel.step == "FRAME":
        return round(float(panel.time))
    events = [each for each in scene.lappet.events if each.enabled]
    first, last = int(scene.frame_start), int(scene.frame_end)
    cuts = [event_time(each) for each in events if each.kind in CUT_KINDS]
    holds = [each for each in events if each.kind in HOLD_KINDS]
    sewn = [each for each in events if each.kind in SEWN_KINDS]
    begin = min((event_time(each) for each in holds), default=float(last))
    end = max((event_end(each) for each in holds), default=float(last))
    closing = min((event_time(each) for each in sewn if event_time(each) > begin), default=end)
    placed = min(closing - 1.0, end, float(last))
    frames = {
        "plan": float(first),
        "cut": max((each for each in cuts if each <= begin), default=max(cuts, default=first)),
        "raised": 0.5 * (begin + placed),
        "placed": placed,
        "sutured": max((event_end(each) for each in sewn), default=last),
        "result": last,
    }
    return min(max(round(frames[panel.step]), first), last)
