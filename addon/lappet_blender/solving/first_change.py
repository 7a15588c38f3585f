"""From which time on two versions of a procedure may differ in their frames.

Only a manifest tells for certain; this is what is known at once, while that of the newer version is still being made.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace

from lappet.procedure import CUTS, MEASURES, Event, Procedure


def first_change(old: Procedure, new: Procedure) -> float:
    """The time code before which every frame stays as it is; inf where nothing that is solved differs.

    Names, the rate of frames and the end of the timeline change no frame. Landmarks and sections belong to every frame,
    and whatever is no event acts from the first one: -inf.
    """
    if old.start_time != new.start_time or old.bones != new.bones or old.materials_in_use() != new.materials_in_use():
        return -math.inf
    if old.tissue is not new.tissue and old.tissue != new.tissue:
        return -math.inf
    before, after = (Counter(replace(event, name="") for event in each.events) for each in (old, new))
    return min((_begins(event) for event in ((before - after) + (after - before))), default=math.inf)


def _begins(event: Event) -> float:
    if isinstance(event, MEASURES):
        return -math.inf
    return float(event.time if isinstance(event, CUTS) else event.start)
