"""A page of panels: where each lies, with its caption; everything in mm on paper."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.drawing.quantity_scale import UNITS, frame_peak, full_value
from lappet.drawing.section_plane import SectionPlane
from lappet.plates.annotations import check_anchors
from lappet.plates.ghost_outline import VARIANTS
from lappet.plates.panel_drawing import AREA_LABELS, SECTION_LABELS, STROKE_LABELS
from lappet.plates.plate_font import PlateFont
from lappet.plates.plate_panel import LINE, PagePanel, PanelMaker
from lappet.plates.plate_request import PlateRequest, PlateRow
from lappet.plates.plate_scene import PlateScene, at_one_scale, plate_scene
from lappet.plates.plate_style import PlateStyle
from lappet.plates.plate_words import PlateWords
from lappet.plates.printed_marks import check_spacing
from lappet.plates.skin_anchors import SkinAnchors
from lappet.plates.told_labels import ToldLabels

LEAST_WIDTH = 40.0  # mm
WIDEST = 1000.0  # mm
MOST_PANELS = 26  # as many as there are letters
GUTTER = 4.0  # mm
_PANEL = 54.0  # mm: panels are not made narrower than about this, so that their labels have room
_MOST_NAMES = 12  # in a sentence
_ASPECT, _SECTION_ASPECT = 0.75, 0.45  # height of a panel over its width
_LABELS = (*STROKE_LABELS.values(), *AREA_LABELS.values(), *SECTION_LABELS.values())


@dataclass(frozen=True, eq=False)
class PlatePage:
    """A page.

    Parameters
    ----------
    size
        Width and height in mm.
    panel
        Width and height of a panel in mm.
    panels
        The panels, row by row.
    alt
        What the page shows, for those who cannot see it.
    key
        Texts of the color key: what is mapped, and the ends of its scale; empty for no map.
    full
        The value at the top.
    """

    size: tuple[float, float]
    panel: tuple[float, float]
    panels: tuple[PagePanel, ...]
    alt: str
    key: tuple[str, ...] = ()
    full: float = 1.0

    def texts(self) -> list[str]:
        """List all texts on the page.

        Returns
        -------
        list[str]
            The texts.
        """
        found = list(self.key)
        for panel in self.panels:
            found += [panel.letter, *panel.caption, *(each.text for each in panel.labels)]
            found += [each.text for each in panel.measures] + [each.text for each in panel.drawing.letters]
            found += [f"{panel.bar:g} mm"] if panel.bar else []
            found += [each.text for each in panel.notes.placed] + [each.text for each in panel.notes.measures]
        return found


def plate_page(request: PlateRequest, style: PlateStyle, words: PlateWords, font: PlateFont) -> PlatePage:
    """Make a page.

    Parameters
    ----------
    request
        What is to be on it.
    style
        How it looks.
    words
        What it says.
    font
        Its font.

    Returns
    -------
    PlatePage
        The page.

    Raises
    ------
    RefusedError
        If the width or the distance of marks is out of range, there are too many panels, a panel has too many labels,
        a landmark is not there, the section is no plane, the font lacks a character, or a cache lacks what is to be
        mapped.
    """
    if not LEAST_WIDTH <= request.width <= WIDEST:
        raise refused(ProblemCode.PLATE_WIDTH, "", request.width, range=f"{LEAST_WIDTH:g} to {WIDEST:g}")
    if len(request.overlaid) > len(VARIANTS):
        raise refused(ProblemCode.PLATE_OVERLAY, "", len(request.overlaid), most=len(VARIANTS))
    if len(request.panels) > MOST_PANELS:
        raise refused(ProblemCode.PLATE_FRAMES, "", len(request.panels), most=MOST_PANELS)
    check_spacing(request.marks_spacing)
    _check_section(request)
    captions = _captions(request, words)
    _check_landmarks(request)
    for row in request.rows:
        check_anchors(SkinAnchors(row.source), request.annotations)
    checked_texts(request, captions, words, font)
    full, top = _full_scale(request)
    columns, width = _columns(request)
    size = (width, _ASPECT * width)
    maker = PanelMaker(
        *(request, _scenes(request, size), style, words, font, size),
        tuple(_scene(row, request, size) for row in request.overlaid),
    )
    indent = font.width("M", style.caption_size) + 1.5
    lines = [tuple(font.wrapped(each, style.caption_size, width - indent)) for each in captions]
    counts = [max(len(each) for each in lines[k : k + columns]) for k in range(0, len(lines), columns)]
    # What is cut across is low: a row that shows nothing else is not as high.
    rows = [range(k, min(k + columns, len(lines))) for k in range(0, len(lines), columns)]
    low = replace(maker, size=(width, _SECTION_ASPECT * width))
    makers = [low if all(maker.is_section(k) for k in row) else maker for row in rows]
    heights = [
        each.size[1] + 1.5 + LINE * style.caption_size * count + GUTTER
        for each, count in zip(makers, counts, strict=True)
    ]
    tops = np.concatenate([[0.0], np.cumsum(heights)])
    panels: list[PagePanel] = []
    told = ToldLabels()
    for k, caption in enumerate(lines):
        own_maker = makers[k // columns]
        x = (k % columns) * (width + GUTTER) + 0.5 * width
        middle = np.array([x, float(tops[k // columns]) + 0.5 * own_maker.size[1]])
        panels += own_maker.panels(k, caption, middle, told)
    own = [panel for panel in panels if panel.line is None]
    alt = words("alt.plate", count=len(own))
    told_of = [(panel.letter, " ".join(panel.caption)) for panel in own if "".join(panel.caption)]
    alt += "".join(" " + (words("alt.panel", letter=a, caption=said) if a else f"{said}.") for a, said in told_of)
    key = (words(f"map.{request.mapped}"), "0", top) if request.mapped else ()
    return PlatePage((request.width, float(tops[-1]) - GUTTER), maker.size, tuple(panels), alt, key, full)


def checked_texts(request: PlateRequest, captions: Sequence[str], words: PlateWords, font: PlateFont) -> None:
    """Refuse texts that the font cannot write.

    Parameters
    ----------
    request
        What is to be on the plate.
    captions
        Its captions.
    words
        What it says.
    font
        Its font.

    Raises
    ------
    RefusedError
        If the font lacks a character.
    """
    notes = [each.text for each in request.annotations] + [row.title for row in request.overlaid]
    font.check([*captions, *request.landmarks, *notes, *(words(key) for key in _LABELS)])


def _check_section(request: PlateRequest) -> None:
    """Refuse a section that is no plane."""
    panels = [step.panel for row in request.rows for step in row.steps if step.panel is not None]
    for name, section in (("", request.section), *((panel.name, panel.section) for panel in panels)):
        if section is not None:
            try:
                SectionPlane.of(section)
            except ValueError as error:
                raise refused(ProblemCode.PLATE_SECTION, name, str(section)) from error


def _check_landmarks(request: PlateRequest) -> None:
    """Refuse landmarks that no procedure of the plate has at any of its panels."""
    known = {label for row in request.rows for label in row.source.named_landmarks(row.source.frames[0])}
    for label in request.landmarks:
        if label not in known:
            raise refused(ProblemCode.PLATE_LANDMARK, "", label, known=_listed(sorted(known)))


def _listed(names: Sequence[str]) -> str:
    """Names for a sentence, which is not for reading a hundred of them."""
    more = len(names) - _MOST_NAMES
    return ", ".join(names[:_MOST_NAMES]) + (f" and {more} more" if more > 0 else "") if names else "none"


def _captions(request: PlateRequest, words: PlateWords) -> list[str]:
    """The caption of each panel."""
    captions = []
    for index, (row, k) in enumerate(request.panels):
        step, title = request.rows[row].steps[k], request.rows[row].title
        said = words(step.key, time=f"{step.time:g}")
        written = request.captions.get(index) or (step.panel.caption if step.panel is not None else "")
        captions.append(written or (f"{title}: {said}" if title else said))
    return captions


def _scenes(request: PlateRequest, size: tuple[float, float]) -> tuple[PlateScene, ...]:
    """Each procedure before its camera; several at one scale."""
    return tuple(at_one_scale([_scene(row, request, size) for row in request.rows]))


def _scene(row: PlateRow, request: PlateRequest, size: tuple[float, float]) -> PlateScene:
    return plate_scene(row.source, [step.time for step in row.steps], request.view, size)


def _full_scale(request: PlateRequest) -> tuple[float, str]:
    """The value at the top of the scale of a map, and its text."""
    if request.mapped is None:
        return 1.0, ""
    found = [
        row.source.scalar(row.source.epoch_at(step.time), request.mapped, step.time)
        for row in request.rows
        for step in row.steps
    ]
    if any(each is None for each in found):
        raise refused(ProblemCode.PLATE_NO_MAP, "", request.mapped)
    full = full_value(max(frame_peak(each) for each in found if each is not None))
    return full, f"≥ {full:g}{UNITS[request.mapped]}"


def _columns(request: PlateRequest) -> tuple[int, float]:
    """Panels in a row and the width of one in mm; of several procedures each has a row."""
    counts = [sum(not row.is_inset(k) for k in range(len(row.steps))) for row in request.rows]
    most = max(int((request.width + GUTTER) // (_PANEL + GUTTER)), 1)
    own = _even(counts, most)
    columns = request.columns or own
    return columns, (request.width - (columns - 1) * GUTTER) / columns


def _even(counts: Sequence[int], most: int) -> int:
    """As many columns as fit; four panels of one procedure make a square."""
    if len(counts) > 1:
        return min(most, max(counts))
    return min(most, counts[0], 2 if counts[0] == 4 else counts[0])
