"""Where strips are drawn and which of them is under the mouse: rows and pixels, without a window."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from .strip import Part, Step, Strip

_GAP_PIXELS = 2.0  # between strips and between lanes
_EDGE = 6.0  # pixels on either side of an end that take hold of it, at most a third of the strip
_NAME_PIXELS = 7.0  # width of a letter of a name beside a cut, about
_MARK = 9.0  # width of a strip of an instant
_TALL, _LOW = 19.0, 5.0  # height of a row: where there is room, and at least
NAMED = 11.0  # height of a row from which on strips have names
_INSTANT = 1e-6  # frames that a strip of an instant asks for
HEADER = 17.0  # height of the row with the names of steps


@dataclass(frozen=True)
class StripView:
    """How frames and rows become pixels of a region.

    left: the frame at pixel 0. scale: pixels per frame. top, bottom: the pixels between which strips are drawn.
    points: pixels of the screen per pixel of the interface at its usual size. scrolled: pixels by which
    rows are moved up, where there are more than there is room for.
    """

    left: float
    scale: float
    top: float
    bottom: float
    points: float = 1.0
    scrolled: float = 0.0

    def x(self, frame: float) -> float:
        """The pixel of a frame."""
        return (frame - self.left) * self.scale

    def frame(self, x: float) -> float:
        """The frame of a pixel."""
        return self.left + x / self.scale


@dataclass(frozen=True)
class StripBox:
    """The rectangle of a strip in pixels. after: the pixel up to which the name beside a short strip may run."""

    strip: Strip
    x0: float
    x1: float
    y0: float
    y1: float
    after: float


@dataclass(frozen=True)
class StepBox:
    """The band of a step in pixels; its name is in the row from y0 to y1."""

    step: Step
    x0: float
    x1: float
    y0: float
    y1: float


@dataclass(frozen=True)
class StripPicture:
    """What is drawn, and what is hit. boxes: later ones lie on top."""

    boxes: tuple[StripBox, ...]
    steps: tuple[StepBox, ...]
    row_height: float
    bottom: float


@dataclass(frozen=True)
class Hit:
    """What is under the mouse: a part of a strip by its uid, or a step by its name and its marker's frame."""

    part: Part
    uid: str = ""
    step: Step | None = None


def strip_rows(strips: Sequence[Strip], reach: Mapping[str, float] | None = None) -> dict[str, int]:
    """The row of each strip by its uid, 0 at the top: lane by lane, in each the first row in which there is room.

    reach: the frame up to which a strip asks for room, where that is later than its end (a name beside it).
    """
    rows: dict[str, int] = {}
    first = 0
    for lane in sorted({strip.lane for strip in strips}):
        free: list[float] = []  # the frame from which each row of the lane is free
        for strip in sorted((s for s in strips if s.lane == lane), key=lambda s: (s.start, s.end, s.name)):
            until = max(strip.start + _INSTANT, strip.end, (reach or {}).get(strip.uid, strip.end))
            row = next((k for k, taken in enumerate(free) if taken <= strip.start), len(free))
            free[row : row + 1] = [until]
            rows[strip.uid] = first + row
        first += len(free)
    return rows


def strip_picture(strips: Sequence[Strip], steps: Sequence[Step], view: StripView) -> StripPicture:
    """Lay strips out in a view: rows as tall as there is room for, names of steps above them."""
    header = HEADER * view.points if steps else 0.0
    room = view.top - header - view.bottom
    rows, height = _rows_in(strips, view, room)
    count = max(rows.values(), default=-1) + 1
    top = view.top - header + min(view.scrolled, max(0.0, count * height - room))
    gap = min(_GAP_PIXELS * view.points, 0.2 * height)
    boxes = []
    for strip in sorted(strips, key=lambda each: (each.selected, each.active)):
        y1 = top - rows[strip.uid] * height
        x0, x1 = view.x(strip.start), _end(strip, view)
        boxes.append(StripBox(strip, x0, x1, y1 - height + gap, y1, _right(strip, view)))
    bands = tuple(StepBox(step, view.x(step.start), view.x(step.end), view.top - header, view.top) for step in steps)
    return StripPicture(tuple(boxes), bands, height, top - count * height)


def _rows_in(strips: Sequence[Strip], view: StripView, room: float) -> tuple[dict[str, int], float]:
    """The rows and their height in pixels: with room for names, without where rows would be too low for them."""
    for right, least in ((_right, NAMED), (_end, _LOW)):
        rows = strip_rows(strips, {s.uid: view.frame(right(s, view)) for s in strips})
        each = room / (max(rows.values(), default=0) + 1)
        if each >= least * view.points:
            break
    return rows, min(max(each, _LOW * view.points), _TALL * view.points)


def hit(picture: StripPicture, x: float, y: float, points: float = 1.0) -> Hit | None:
    """What is at a pixel, None for nothing: the strip on top, near its ends these; else the name of a step."""
    for box in reversed(picture.boxes):
        edge = min(_EDGE * points, (box.x1 - box.x0) / 3.0) if box.strip.has_end else 0.0
        outside = 0.5 * edge
        if not (box.y0 <= y <= box.y1 and box.x0 - outside <= x <= box.x1 + outside):
            continue
        if edge and x <= box.x0 + edge:
            return Hit(Part.START, box.strip.uid)
        if edge and x >= box.x1 - edge:
            return Hit(Part.END, box.strip.uid)
        return Hit(Part.BODY, box.strip.uid)
    for band in picture.steps:
        if band.y0 <= y <= band.y1 and band.x0 <= x < band.x1:
            return Hit(Part.STEP, step=band.step)
    return None


def _end(strip: Strip, view: StripView) -> float:
    """The pixel at which a strip ends; that of an instant is as wide as a mark."""
    return max(view.x(strip.end), view.x(strip.start) + _MARK * view.points)


def _right(strip: Strip, view: StripView) -> float:
    """The pixel up to which a strip and the name beside it run; the name of a long one is in it."""
    x0, x1 = view.x(strip.start), _end(strip, view)
    name = (len(strip.name) * _NAME_PIXELS + 6.0) * view.points
    return x1 if x1 - x0 >= name else x1 + name
