"""What is drawn of a panel's annotations over a viewport, as lines and texts in its pixels; nothing of it draws."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..model.plate_names import shown_on
from ..tools.shown_surface import ShownSurface

Project = Callable[[NDArray[np.float64]], NDArray[np.float64]]
TextWidth = Callable[[str], float]
LINE = 1.2  # times the size of a text
_GONE = 1.5  # mm: an anchor may lie so far from the tissue that is shown
_STEP = 2.0  # mm between places of a line along the skin
_ARC, _HEAD, _GAP = 4.2, 2.0, 1.0  # mm on paper: an angle's arc, an arrow's head, between a leader and its text


@dataclass(frozen=True, eq=False)
class MarkText:
    """A text. place: the left end of its base line, pixels. width: of it. site: its first anchor, pixels."""

    note: str
    text: str
    place: NDArray[np.float64]
    width: float
    site: NDArray[np.float64]

    def holds(self, mouse: Sequence[float], size: float) -> bool:
        """Whether the mouse is on it."""
        away = np.asarray(mouse, np.float64)[:2] - self.place
        return bool(-4.0 <= away[0] <= self.width + 4.0 and -0.5 * size <= away[1] <= LINE * size)


@dataclass(eq=False)
class PreviewMarks:
    """lines: (k, 2) pixels each. frame: lower left and upper right corner of the panel, pixels, shape (2, 2)."""

    frame: NDArray[np.float64]
    size: float
    texts: list[MarkText] = field(default_factory=list)
    lines: list[NDArray[np.float64]] = field(default_factory=list)


@dataclass(frozen=True, eq=False)
class PreviewPage:
    """What a preview is drawn on: pixels for a millimeter of paper, the panel's frame, and how wide a text is."""

    scale: float
    frame: NDArray[np.float64]
    size: float
    width: TextWidth


def preview_marks(plate: Any, panel: str, surface: ShownSurface, project: Project, page: PreviewPage) -> PreviewMarks:
    """The marks of the annotations that stand on a panel and whose tissue is shown."""
    marks = PreviewMarks(page.frame, page.size)
    free: list[tuple[Any, NDArray[np.float64]]] = []
    for note in plate.annotations:
        if not shown_on(note, panel) or not len(note.anchors):
            continue
        rest = np.array([tuple(anchor.co) for anchor in note.anchors], np.float64)
        located = surface.rest.locate(rest)
        if np.linalg.norm(surface.rest.at(located) - rest, axis=1).max() > _GONE:
            continue  # its tissue is gone
        world = surface.carry(located)
        pixels = project(world)
        if not np.isfinite(pixels).all():
            continue
        _draw(note, rest, world, surface, project, page, marks)
        if note.kind in ("label", "pivot") and not note.placed and (note.kind == "label" or note.text):
            free.append((note, pixels[0]))
    _place(free, page, marks)
    return marks


def _draw(
    note: Any,
    rest: NDArray[np.float64],
    world: NDArray[np.float64],
    surface: ShownSurface,
    project: Project,
    page: PreviewPage,
    marks: PreviewMarks,
) -> None:
    pixels = project(world)
    if note.kind in ("length", "distance"):
        line = _along(rest, surface) if note.kind == "length" else world
        length = float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum()) * surface.mm
        marks.lines.append(project(line))
        _text(note, note.text or f"{length:.0f} mm", 0.5 * (pixels[0] + pixels[-1]), pixels[0], page, marks)
    elif note.kind == "angle" and len(world) == 3:
        ways = [world[k] - world[1] for k in (0, 2)]
        ways = [way / max(float(np.linalg.norm(way)), 1e-12) for way in ways]
        angle = float(np.degrees(np.arccos(np.clip(ways[0] @ ways[1], -1.0, 1.0))))
        ends = [_toward(pixels[1], pixels[k], _ARC * page.scale) for k in (0, 2)]
        middle = _toward(pixels[1], 0.5 * (ends[0] + ends[1]), _ARC * page.scale)
        marks.lines.append(np.array([ends[0], middle, ends[1]]))
        _text(note, note.text or f"{angle:.0f}°", middle, pixels[0], page, marks)
    elif note.kind == "arrow" and len(world) == 2:
        _arrow(pixels, page, marks)
        if note.text:
            _text(note, note.text, 0.5 * (pixels[0] + pixels[1]), pixels[0], page, marks)
    elif note.kind in ("pivot", "arrow"):
        for k in (-1.0, 1.0):
            across = page.scale * np.array([0.8, 0.8 * k])
            marks.lines.append(np.array([pixels[0] - across, pixels[0] + across]))
    if note.kind in ("label", "pivot") and note.placed and (note.kind == "label" or note.text):
        port = pixels[0] + page.scale * np.array([note.offset[0], -note.offset[1]])
        text = str(note.text or note.name)
        _label(note, text, pixels[0], port, note.offset[0] < 0.0, page, marks)


def _text(
    note: Any, text: str, at: NDArray[np.float64], site: NDArray[np.float64], page: PreviewPage, marks: PreviewMarks
) -> None:
    """A text about its middle: where the user put it, or a line above what it says something of."""
    width = page.width(text)
    middle = at + np.array([0.0, LINE * page.size])
    if note.placed:
        middle = site + page.scale * np.array([note.offset[0], -note.offset[1]])
    marks.texts.append(MarkText(note.name, text, middle - np.array([0.5 * width, 0.35 * page.size]), width, site))


def _label(
    note: Any,
    text: str,
    site: NDArray[np.float64],
    port: NDArray[np.float64],
    left: bool,
    page: PreviewPage,
    marks: PreviewMarks,
) -> None:
    """A label at the end of its leader."""
    width = page.width(text)
    gap = _GAP * page.scale
    x = port[0] - gap - width if left else port[0] + gap
    marks.lines.append(np.array([site, port]))
    marks.texts.append(MarkText(note.name, text, np.array([x, port[1] - 0.35 * page.size]), width, site))


def _place(free: list[tuple[Any, NDArray[np.float64]]], page: PreviewPage, marks: PreviewMarks) -> None:
    """Put labels at the sides of the frame, those of a side in the order of what they name.

    The page itself is set with the least total length of leaders, which may choose other places.
    """
    middle, rows = page.frame.mean(axis=0), 1.5 * page.size
    for left in (True, False):
        own = sorted((each for each in free if (each[1][0] < middle[0]) == left), key=lambda each: -each[1][1])
        top = float(page.frame[1, 1]) - rows
        for k, (note, site) in enumerate(own):
            room = float(page.frame[0, 1]) + rows * (len(own) - k)
            y = min(top, max(float(site[1]), room))
            top = y - rows
            text = str(note.text or note.name)
            inner = page.width(text) + _GAP * page.scale
            x = float(page.frame[0, 0]) + inner if left else float(page.frame[1, 0]) - inner
            _label(note, text, site, np.array([x, y]), left, page, marks)


def _arrow(pixels: NDArray[np.float64], page: PreviewPage, marks: PreviewMarks) -> None:
    way = pixels[1] - pixels[0]
    way = way / max(float(np.linalg.norm(way)), 1e-9)
    across, head = np.array([-way[1], way[0]]), _HEAD * page.scale
    tips = [pixels[1] - head * way + 0.5 * head * sign * across for sign in (1.0, -1.0)]
    marks.lines += [pixels, np.array([tips[0], pixels[1], tips[1]])]


def _toward(begin: NDArray[np.float64], end: NDArray[np.float64], length: float) -> NDArray[np.float64]:
    way = end - begin
    return begin + length * way / max(float(np.linalg.norm(way)), 1e-9)


def _along(rest: NDArray[np.float64], surface: ShownSurface) -> NDArray[np.float64]:
    """A line along the skin that is shown, through places at rest."""
    parts = [rest[:1]]
    for begin, end in pairwise(rest):
        count = max(int(np.ceil(float(np.linalg.norm(end - begin)) / _STEP)), 1)
        parts.append(begin + np.linspace(0.0, 1.0, count + 1)[1:, None] * (end - begin))
    return surface.carry(surface.rest.locate(np.vstack(parts)))
