"""What a drag makes of strips: shifted, stretched at an end, snapped. Frames in, frames out; no window."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass

from .strip import Part, Step, Strip

HOLD_AT_LEAST = 1.0  # frames: a hook that lets go when it grips pulls nothing
_PLACES = 4  # decimals of a frame that events keep


@dataclass(frozen=True)
class Span:
    """When a strip begins and has ended, in frames."""

    start: float
    end: float


def dragged(strips: Iterable[Strip], part: Part, shift: float) -> dict[str, Span]:
    """When strips begin and end after a drag by so many frames, by uid.

    BODY and STEP shift them whole. START and END move one end of those that have an end, no farther than the other: a
    hook and a retractor keep a frame, a suture may close at once.
    """
    spans = {}
    for strip in strips:
        start, end = strip.start, strip.end
        if part in (Part.BODY, Part.STEP) or not strip.has_end:
            moved = shift if part in (Part.BODY, Part.STEP) else 0.0
            start, end = start + moved, end + moved
        elif part is Part.START:
            start = min(start + shift, max(end - _shortest(strip), strip.start))
        else:
            end = max(end + shift, min(start + _shortest(strip), strip.end))
        spans[strip.uid] = Span(round(start, _PLACES), round(end, _PLACES))
    return spans


def grabbed_edges(strip: Strip, part: Part) -> tuple[float, ...]:
    """The frames of a strip that snap while a part of it is dragged."""
    if part is Part.START:
        return (strip.start,)
    if part is Part.END:
        return (strip.end,)
    return (strip.start, strip.end) if strip.end > strip.start else (strip.start,)


def snap_targets(
    strips: Iterable[Strip], moving: Collection[str], steps: Iterable[Step], others: Iterable[float]
) -> tuple[float, ...]:
    """The frames that a drag snaps to: the ends of strips that stay, the begins of steps, and others."""
    found = {round(frame, _PLACES) for frame in others}
    for strip in strips:
        if strip.uid not in moving:
            found |= {round(strip.start, _PLACES), round(strip.end, _PLACES)}
    return tuple(sorted(found | {round(step.start, _PLACES) for step in steps}))


def snapped(shift: float, edges: Sequence[float], targets: Sequence[float], reach: float) -> tuple[float, float | None]:
    """Snap a shift, and say to which frame: None where the first edge went to the next whole frame.

    edges: frames of what is dragged, before the drag. An edge within `reach` frames of a target goes there, the nearest
    pair first.
    """
    pairs = [(abs(target - edge - shift), target - edge, target) for edge in edges for target in targets]
    near = [pair for pair in pairs if pair[0] <= reach]
    if near:
        _, to, target = min(near)
        return round(to, _PLACES), target
    whole = round(edges[0] + shift) - edges[0] if edges else round(shift)
    return round(whole, _PLACES), None


def _shortest(strip: Strip) -> float:
    return HOLD_AT_LEAST if strip.kind in ("HOOK", "RETRACTOR") else 0.0
