"""Which frames tell the story: before, incised, lifted, transposed, sutured, final."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.drawing.second_stage import second_stage_from
from lappet.drawing.skin_source import SkinSource, StepEvent

MOST_PANELS = 6
CUTTING = ("Incision", "Excision", "Undermine")
DONE = {"Incision": "Incised", "Excision": "Excised", "Undermine": "Undermined"}
HELD = ("Hook", "Retractor", "Suture")
_WORDS = {"Incision": "incision", "Excision": "excision", "Hook": "hook", "Retractor": "retractor"}
# What a frame is told by: the kind of the newest event.
_LATEST = {
    **{kind: word.lower() for kind, word in DONE.items()},
    "Hook": "hooked",
    "Retractor": "held",
    "Suture": "sutured",
    "Thin": "thinned",
}


@dataclass(frozen=True)
class Step:
    """A panel of the filmstrip.

    Parameters
    ----------
    frame
        Time code of the frame that it shows.
    caption
        What it says.
    detail
        A smaller second line.
    """

    frame: float
    caption: str
    detail: str = ""


def hook_height(source: SkinSource, normal: NDArray[np.float64]) -> Callable[[float], float]:
    """Make the measure of how far the tissue that hooks hold stands out at a frame.

    Parameters
    ----------
    source
        The solved procedure.
    normal
        Unit vector along which it is measured, shape (3,).

    Returns
    -------
    Callable[[float], float]
        The height in mm at a time code; minus infinity where no hook holds.
    """

    def height(time: float) -> float:
        hooks = source.hooks(time)
        return float((hooks.ends[hooks.active, 0] @ normal).mean()) if hooks.active.any() else -np.inf

    return height


def _numbered(events: Sequence[StepEvent]) -> str:
    """How many events of each kind, in words; the names of events are the author's own and not for readers."""
    parts = []
    for kind, word in _WORDS.items():
        count = sum(event.kind == kind for event in events)
        parts += [f"{count} {word}{'s' if count > 1 else ''}"] if count else []
    return ", ".join(parts)


def story_steps(
    events: Sequence[StepEvent],
    frames: Sequence[float],
    height: Callable[[float], float] | None = None,
    buried: int = 0,
) -> list[Step]:
    """Choose the steps of a procedure, each right after what its caption says, in order of time.

    Parameters
    ----------
    events
        The procedure's events.
    frames
        The time codes of the frames, ascending, at least one.
    height
        How far the hooked tissue stands above the skin at a time code, in any unit; decides which frame shows the flaps
        lifted.
    buried
        How many of the sutures lie in the depth.

    Returns
    -------
    list[Step]
        At most `MOST_PANELS` steps.
    """
    steps = [Step(frames[0], "Before", "planned incision" if any(e.kind == "Incision" for e in events) else "")]
    begin_held = min((e.start for e in events if e.kind in HELD), default=float("inf"))
    cuts = [e for e in events if e.kind in CUTTING]
    cuts = [e for e in cuts if e.start <= begin_held] or cuts
    if cuts:
        steps.append(_cut_step(cuts, frames, begin_held))
    sutures = [e for e in events if e.kind == "Suture"]
    pulls = [e for e in events if e.kind in ("Hook", "Retractor")]
    divided = second_stage_from(events)
    if pulls:
        steps += _pull_steps(pulls, cuts, sutures, frames, height)
    if divided < float("inf"):
        steps = [*steps[:3], *_second_stage(events, frames, divided)]
    elif sutures:
        begin_closing = min(e.start for e in sutures)
        closed = _at_or_after(frames, max(e.end for e in sutures))
        halfway = _at_or_after(frames, (begin_closing + closed) / 2)
        if len(steps) < MOST_PANELS - 2 and steps[-1].frame < halfway < closed:
            steps.append(Step(halfway, "Drawn together"))
        steps.append(Step(closed, "Sutured", _counted(sum(e.stitches for e in sutures), buried)))
    thinned = [e for e in events if e.kind == "Thin"]
    if thinned and len(steps) < MOST_PANELS - 1:
        steps.append(Step(_at_or_after(frames, max(e.end for e in thinned)), "Flap thinned"))
    if not events:
        steps += [Step(f, f"Frame {f:g}") for f in _spread(frames[1:-1], MOST_PANELS - 2)]
    told = any(step.caption == "Flap thinned" for step in steps)
    steps.append(Step(frames[-1], "Final result", "the flap thinned" if thinned and not told else ""))
    return _distinct(steps)


def _second_stage(events: Sequence[StepEvent], frames: Sequence[float], begin: float) -> list[Step]:
    """The steps that show a flap sewn in on its pedicle, and cut from it."""
    cut = _at_or_after(frames, max(e.start for e in events if e.kind in CUTTING and e.start >= begin))
    return [Step(_before(frames, begin), "Sewn in", "on its pedicle"), Step(cut, "Pedicle divided")]


def _at_or_after(frames: Sequence[float], time: float) -> float:
    return next((f for f in frames if f >= time - 1e-6), frames[-1])


def _before(frames: Sequence[float], time: float) -> float:
    return next((f for f in reversed(frames) if f < time - 1e-6), frames[0])


def _cut_step(cuts: Sequence[StepEvent], frames: Sequence[float], begin_held: float) -> Step:
    """The step that shows what was cut before anything holds the tissue."""
    kinds = [DONE[k] for k in CUTTING if any(e.kind == k for e in cuts)]
    if "Excised" in kinds and "Incised" in kinds:
        kinds.remove("Incised")  # what is excised was incised all around
    caption = " and ".join([kinds[0], *(k.lower() for k in kinds[1:])])
    detail = _numbered([e for e in cuts if e.kind != "Undermine"])
    if any(e.kind == "Undermine" for e in cuts):
        detail += ("; " if detail else "") + "dashed: undermined"
    last_cut = _at_or_after(frames, max(e.start for e in cuts))
    return Step(max(last_cut, _before(frames, begin_held)) if begin_held < float("inf") else last_cut, caption, detail)


def _pull_steps(
    pulls: Sequence[StepEvent],
    cuts: Sequence[StepEvent],
    sutures: Sequence[StepEvent],
    frames: Sequence[float],
    height: Callable[[float], float] | None,
) -> list[Step]:
    """The steps that show the tissue lifted, and where it is when hooks let go or sutures begin."""
    begin, end = min(e.start for e in pulls), max(e.end for e in pulls)
    last = _before(frames, min([end, *(e.start for e in sutures if e.start > begin)]))
    span = [f for f in frames if begin <= f <= last]
    if not span:
        return []
    top = max(span, key=height) if height else span[len(span) // 2]
    if top == last and len(span) > 2:
        top = span[len(span) // 2]
    elif len(span) <= 2 and height:  # the sutures begin with the hooks: the hooks' height tells
        top = max((f for f in frames if begin <= f < end), key=height, default=top)
    steps = [Step(top, "Lifted with hooks" if any(e.kind == "Hook" for e in pulls) else "Retracted", _numbered(pulls))]
    if last > top:
        # Around what is excised one incision runs; more of them cut a flap.
        flap = sum(e.kind == "Incision" for e in cuts) > 1 or all(e.kind != "Excision" for e in cuts)
        moved = "Laid in place" if flap else "Advanced"
        steps.append(Step(last, moved if sutures else "Held"))
    return steps


def _counted(sutures: int, buried: int) -> str:
    plural = "s" if sutures > 1 else ""
    if not buried:
        return f"{sutures} suture{plural}"
    if buried == sutures:
        return f"{sutures} buried suture{plural}"
    return "skin sutures over buried ones"  # no count: sutures closer than stitches can be are drawn as one


def _spread(frames: Sequence[float], count: int) -> list[float]:
    if len(frames) <= count:
        return list(frames)
    return [frames[round(k * (len(frames) - 1) / (count - 1))] for k in range(count)]


def _distinct(steps: list[Step]) -> list[Step]:
    """Steps in order of time, one a frame: of two on one frame the later told stays, but `Final result` yields."""
    by_frame: dict[float, Step] = {}
    for step in steps:
        if step.frame in by_frame and step.caption == "Final result":
            continue
        by_frame[step.frame] = step
    return [by_frame[f] for f in sorted(by_frame)][:MOST_PANELS]


def step_captions(events: Sequence[StepEvent], frames: Sequence[float]) -> list[Step]:
    """Caption frames that the user chose, by the newest event at each.

    Parameters
    ----------
    events
        The procedure's events.
    frames
        Time codes.

    Returns
    -------
    list[Step]
        A step for each.
    """
    steps = []
    for frame in frames:
        past = [e for e in events if e.start <= frame and e.kind != "Landmark"]
        steps.append(Step(frame, f"Frame {frame:g}", _LATEST.get(past[-1].kind, "") if past else ""))
    return steps
