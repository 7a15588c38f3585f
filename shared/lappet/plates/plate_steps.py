"""Which frames a plate of steps shows, and what each is: planned, cut, raised, carried into place, sutured, result."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from lappet.drawing.open_wound import open_area
from lappet.drawing.second_stage import CUTS as CUT_KINDS
from lappet.drawing.second_stage import PULLS, second_stage_from
from lappet.drawing.skin_source import SkinSource, StepEvent
from lappet.geometry.labeled_surface import FaceOrigin
from lappet.procedure.plate import PlatePanel

_MOST = 99.0  # percent of the skin's points that count: the tips of flaps settle a little when hooks let go
_LEFT_OPEN = 25.0  # mm²: a wound of which more gapes is not closed
_SAME = 1.5  # mm: two panels in which no skin moves farther are one (chosen: about a line of text on paper)


class StepKind(StrEnum):
    """What a panel shows; its caption is the catalogue's text for it."""

    PLAN = "plan"
    PLAN_EXCISION = "plan-excision"
    INCISED = "incised"
    EXCISED = "excised"
    UNDERMINED = "undermined"
    INCISED_UNDERMINED = "incised-undermined"
    EXCISED_UNDERMINED = "excised-undermined"
    RAISED = "raised"
    RETRACTED = "retracted"
    PLACED = "placed"
    APPROXIMATED = "approximated"
    SUTURED = "sutured"
    ON_PEDICLE = "on_pedicle"
    DIVIDED = "divided"
    THINNED = "thinned"
    RESULT = "result"
    FRAME = "frame"


CUTS = frozenset(
    {
        *(StepKind.INCISED, StepKind.EXCISED, StepKind.UNDERMINED),
        *(StepKind.INCISED_UNDERMINED, StepKind.EXCISED_UNDERMINED),
    }
)


@dataclass(frozen=True)
class PlateStep:
    """A panel's frame and what it shows.

    Parameters
    ----------
    time
        Time code of the frame.
    kind
        What it shows.
    panel
        What a plate of the procedure says of it, None where the program chose it.
    ghost
        Time code of the frame whose outlines are drawn through, or None.
    left_open
        Whether a part of the wound that is sutured stays open.
    """

    time: float
    kind: StepKind
    panel: PlatePanel | None = None
    ghost: float | None = None
    left_open: bool = False

    @property
    def key(self) -> str:
        """The key of its caption in the catalogue."""
        return f"step.{self.kind}-open" if self.left_open else f"step.{self.kind}"


def plate_steps(source: SkinSource, normal: NDArray[np.float64]) -> list[PlateStep]:
    """Choose the panels of a plate of steps.

    Parameters
    ----------
    source
        The solved procedure.
    normal
        Unit normal of the surgical field, shape (3,): where flaps are raised is judged along it.

    Returns
    -------
    list[PlateStep]
        At most nine in order of time; panels that look the same are one.
    """
    frames, events = source.frames, [e for e in source.events if e.kind != "Landmark"]
    cuts = [e for e in events if e.kind in CUT_KINDS]
    pulls = [e for e in events if e.kind in PULLS]
    sutures = [e for e in events if e.kind == "Suture"]
    held = min((e.start for e in (*pulls, *sutures)), default=frames[-1] + 1.0)
    first = [e for e in cuts if e.start <= held] or cuts
    steps = []
    if not first or frames[0] < min(e.start for e in first):
        excised_only = any(e.kind == "Excision" for e in cuts) and sum(e.kind == "Incision" for e in cuts) < 2
        planned = StepKind.PLAN_EXCISION if excised_only else StepKind.PLAN
        steps.append(PlateStep(frames[0], planned if cuts else StepKind.FRAME))
    if first:
        last = _at_or_after(frames, max(e.start for e in first))
        before = [f for f in frames if last <= f < held]
        steps.append(PlateStep(before[-1] if before else last, _cut_kind(first)))
    steps += _pulled(source, normal, pulls, sutures)
    steps += second_stage(frames, events)
    steps += [PlateStep(_at_or_after(frames, e.start), StepKind.THINNED) for e in events if e.kind == "Thin"]
    if sutures:
        sewn = _at_or_after(frames, max(e.end for e in sutures))
        steps.append(PlateStep(sewn, StepKind.SUTURED, left_open=open_area(source, sewn, normal) > _LEFT_OPEN))
    steps.append(PlateStep(frames[-1], StepKind.RESULT if events else StepKind.FRAME))
    return _distinct(source, steps)


def _at_or_after(frames: Sequence[float], time: float) -> float:
    return next((f for f in frames if f >= time - 1e-6), frames[-1])


def _cut_kind(cuts: Sequence[StepEvent]) -> StepKind:
    kinds = {e.kind for e in cuts}
    if "Excision" in kinds:
        return StepKind.EXCISED_UNDERMINED if "Undermine" in kinds else StepKind.EXCISED
    if "Incision" in kinds:
        return StepKind.INCISED_UNDERMINED if "Undermine" in kinds else StepKind.INCISED
    return StepKind.UNDERMINED


def _pulled(
    source: SkinSource, normal: NDArray[np.float64], pulls: Sequence[StepEvent], sutures: Sequence[StepEvent]
) -> list[PlateStep]:
    """Where hooked tissue is highest, and the last frame before hooks let go or all sutures hold."""
    if not pulls:
        return []
    begin, end = min(e.start for e in pulls), max(e.end for e in pulls)
    sewn = min((e.start for e in sutures if e.start > begin), default=source.frames[-1])
    span = [f for f in source.frames if begin <= f <= end and f < sewn]
    if not span:
        return []
    heights = []
    for time in span:
        hooks = source.hooks(time)
        heights.append(float((hooks.ends[hooks.active, 0] @ normal).max()) if hooks.active.any() else -np.inf)
    top = span[int(np.argmax(heights))]
    raised = StepKind.RAISED if any(e.kind == "Hook" for e in pulls) else StepKind.RETRACTED
    return [PlateStep(top, raised), *([PlateStep(span[-1], StepKind.PLACED)] if span[-1] > top else [])]


def second_stage(frames: Sequence[float], events: Sequence[StepEvent]) -> list[PlateStep]:
    """Choose the panels of a second stage, where a flap that was carried and sewn in is cut from its pedicle.

    Parameters
    ----------
    frames
        Time codes of the frames.
    events
        The events of the procedure.

    Returns
    -------
    list[PlateStep]
        The flap sewn in, and divided; none where no cut follows when all sutures begun before it are closed.
    """
    begin = second_stage_from(events)
    if begin == float("inf"):
        return []
    sutures = [e.start for e in events if e.kind == "Suture"]
    before = [f for f in frames if min(sutures) < f < begin]
    rejoined = min((start for start in sutures if start >= begin), default=frames[-1])
    last = _at_or_after(frames, max(e.start for e in events if e.kind in CUT_KINDS and e.start >= begin))
    after = [f for f in frames if last <= f < rejoined]
    steps = [PlateStep(before[-1], StepKind.ON_PEDICLE)] if before else []
    return [*steps, PlateStep(after[-1] if after else last, StepKind.DIVIDED)]


def _distinct(source: SkinSource, steps: Sequence[PlateStep]) -> list[PlateStep]:
    """Steps in order of time without those that look like the one before them."""
    kept: list[PlateStep] = []
    for step in sorted(steps, key=lambda each: each.time):
        # What is hatched in one of the two tells them apart.
        if kept and kept[-1].kind != StepKind.THINNED and _same(source, kept[-1].time, step.time):
            continue
        kept.append(step)
    return kept


def _same(source: SkinSource, one: float, other: float) -> bool:
    """Whether two frames show the same skin, and the same sutures act; hooks alone make no panel."""
    first, second = source.epoch_at(one), source.epoch_at(other)
    if first.name != second.name:
        return False
    if not np.array_equal(source.sutures(one).active, source.sutures(other).active):
        return False
    skin = np.unique(first.triangles[first.origin == FaceOrigin.SKIN])
    moved = source.positions(first, one)[skin] - source.positions(first, other)[skin]
    return not len(skin) or bool(np.percentile(np.linalg.norm(moved, axis=1), _MOST) < _SAME)
