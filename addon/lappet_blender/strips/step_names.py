"""The steps of an operation as its events tell them, for the markers that name them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import groupby

from .strip import Strip

_EPS = 1e-6


def proposed_steps(strips: Sequence[Strip], first: int, last: int) -> list[tuple[str, int]]:
    """The steps of events that take place, from the frame `first` to `last`: (key of the catalogue's text, frame).

    What is planned, then a step for each run of cuts, pulls and sutures in order of time, then the result. Steps that
    begin on the frame of an earlier one are left out.
    """
    ordered = sorted((s for s in strips if s.enabled), key=lambda s: (s.start, s.lane))
    if not ordered:
        return []
    excised = any(s.kind == "EXCISION" for s in ordered) and sum(s.kind == "INCISION" for s in ordered) < 2
    found = [("step.plan-excision" if excised else "step.plan", first)]
    for lane, run in groupby(ordered, key=lambda s: s.lane):
        members = list(run)
        found.append((f"step.{_kind(lane, {s.kind for s in members})}", math.floor(members[0].start + _EPS)))
    found.append(("step.result", math.ceil(max(s.end for s in ordered) - _EPS)))
    if found[1][1] <= first:
        del found[0]  # cut from the first frame on: no frame shows the plan alone
    kept = [found[0]]
    for key, frame in found[1:]:
        if kept[-1][1] < frame <= last:
            kept.append((key, frame))
    return kept


def _kind(lane: int, kinds: set[str]) -> str:
    """What a run of events of a lane does, as plates call it."""
    if lane == 1:
        return "raised" if "HOOK" in kinds else "retracted"
    if lane == 2:
        return "sutured"
    if "EXCISION" in kinds:
        return "excised-undermined" if "UNDERMINE" in kinds else "excised"
    if "INCISION" in kinds:
        return "incised-undermined" if "UNDERMINE" in kinds else "incised"
    return "undermined" if "UNDERMINE" in kinds else "thinned"
