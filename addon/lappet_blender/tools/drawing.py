"""Drawing a line point by point or free-hand, as a plain state machine: presses, moves and releases in, points out.

It knows neither Blender nor the skin: places come as rest points (mm) that were picked, None where the mouse is off
the skin, and as pixels of the region.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .stroke_fit import fit_stroke, with_ends

Point = tuple[float, float, float]
DRAG_PIXELS = 8.0
_SAME = 1e-3  # mm: nearer points are one


@dataclass(frozen=True)
class DrawnLine:
    """A finished line. points: control points at rest, mm. basis: of `BASES`."""

    points: tuple[Point, ...]
    basis: str
    closed: bool


class LineDrawing:
    """A line that is being drawn.

    smooth: a curve runs through the clicked points; a free-hand stroke makes the whole line smooth. must_close: the
    line is an outline. tolerance: mm, how far the curve may leave a free-hand stroke.
    """

    def __init__(self, smooth: bool = False, must_close: bool = False, tolerance: float = 0.4) -> None:
        self.closed = False
        self._smooth = smooth
        self._must_close = must_close
        self._tolerance = tolerance
        self._acts: list[list[Point]] = []  # each click and each stroke, so that one step back takes one away
        self._strokes: list[bool] = []
        self._stroke: list[Point] = []
        self._pressed: Point | None = None
        self._pressed_at = (0.0, 0.0)
        self._dragging = False
        self.hover: Point | None = None

    @property
    def points(self) -> list[Point]:
        """The points so far, without the one under the mouse."""
        return [point for act in self._acts for point in act]

    @property
    def smooth(self) -> bool:
        """Whether a smooth curve runs through the points."""
        return self._smooth or any(self._strokes) or self._dragging

    @property
    def dragging(self) -> bool:
        """Whether a free-hand stroke is being drawn."""
        return self._dragging

    def press(self, rest: Point | None, mouse: Sequence[float]) -> bool:
        """The button goes down; whether that was on the skin."""
        self.hover = rest
        self._pressed, self._pressed_at, self._dragging = rest, (mouse[0], mouse[1]), False
        self._stroke = [] if rest is None else [rest]
        return rest is not None

    def move(self, rest: Point | None, mouse: Sequence[float]) -> None:
        """The mouse moves; with the button down and far enough this draws free-hand."""
        self.hover = rest
        if self._pressed is None:
            return
        away = np.hypot(mouse[0] - self._pressed_at[0], mouse[1] - self._pressed_at[1])
        self._dragging = self._dragging or bool(away > DRAG_PIXELS)
        if rest is not None and _apart(rest, self._stroke[-1]):
            self._stroke.append(rest)

    def release(self) -> None:
        """The button goes up: a click becomes a point, a drag a stroke."""
        if self._pressed is None:
            return
        added = [self._pressed]
        if self._dragging and len(self._stroke) > 1:
            added = [_point(p) for p in fit_stroke(self._stroke, self._tolerance)]
        points = self.points
        if points and not _apart(points[-1], added[0]):
            added = added[1:]
        if added:
            self._acts.append(added)
            self._strokes.append(self._dragging and len(added) > 1)
        self._pressed, self._dragging, self._stroke = None, False, []

    def back(self) -> bool:
        """Take the last click or stroke back; False where there is none."""
        self._pressed, self._dragging, self._stroke = None, False, []
        if not self._acts:
            return False
        self._acts.pop()
        self._strokes.pop()
        return True

    def close(self) -> bool:
        """Close the line; False for fewer than three points."""
        self.closed = len(self.points) >= 3
        return self.closed

    def preview(self) -> DrawnLine | None:
        """The line as it would be with the point under the mouse; None for no point at all."""
        points = [*self.points, *(self._stroke if self._dragging else [])]
        if not self._dragging and self.hover is not None and not self.closed:
            points.append(self.hover)
        return self._line(points, self.closed) if points else None

    def problem(self) -> str:
        """Why the line cannot be finished yet; empty where it can."""
        count, need = len(self.points), 3 if self._must_close or self.closed else 2
        if count >= need:
            return ""
        points = f"{count} point{'s' * (count != 1)}"
        return f"The line has {points}; click at least {need} on the skin."

    def finish(self) -> DrawnLine | None:
        """The line; None where `problem` has something to say."""
        self.release()
        if self.problem():
            return None
        return self._line(self.points, self.closed or self._must_close)

    def _line(self, points: list[Point], closed: bool) -> DrawnLine:
        distinct = [p for k, p in enumerate(points) if k == 0 or _apart(p, points[k - 1])]
        if closed and len(distinct) > 3 and not _apart(distinct[0], distinct[-1]):
            distinct = distinct[:-1]
        if not self.smooth or len(distinct) < 3:
            return DrawnLine(tuple(distinct), "LINEAR", closed)
        control = distinct if closed else [_point(p) for p in with_ends(distinct)]
        return DrawnLine(tuple(control), "CATMULL_ROM", closed)


def _apart(a: Sequence[float], b: Sequence[float]) -> bool:
    return sum((p - q) ** 2 for p, q in zip(a, b, strict=True)) > _SAME * _SAME


def _point(values: Sequence[float]) -> Point:
    x, y, z = (float(v) for v in values)
    return (x, y, z)
