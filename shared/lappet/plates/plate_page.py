"""A page of panels: where each lies, its caption, its labels; everything in mm on paper."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from string import ascii_uppercase

import numpy as np
from numpy.typing import NDArray
from shapely import LineString

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.drawing.skin_read import SkinCache
from lappet.plates.boundary_labels import PlacedLabel, place_labels
from lappet.plates.feature_lines import LineKind
from lappet.plates.filled_areas import AreaKind
from lappet.plates.measures import Measure, plan_measures
from lappet.plates.panel_drawing import AREA_LABELS, STROKE_LABELS, PanelDrawing, label_sites, panel_drawing
from lappet.plates.plate_font import PlateFont
from lappet.plates.plate_scene import PlateScene, plate_scene
from lappet.plates.plate_steps import PlateStep, StepKind
from lappet.plates.plate_style import POINT, PlateStyle
from lappet.plates.plate_words import PlateWords

LEAST_WIDTH = 40.0  # mm
WIDEST = 1000.0  # mm
CAPTION_SIZE = 8.0 * POINT
LABEL_SIZE = 7.0 * POINT  # the least that publishers print
LETTER_SIZE = 8.5 * POINT
LINE = 1.2  # times the size of a text
GUTTER = 4.0  # mm
_PANEL = 54.0  # mm: panels are not made narrower than about this, so that their labels have room
_ASPECT = 0.75
_KINDS = tuple(AreaKind)
_BARS = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)  # mm


@dataclass(frozen=True, eq=False)
class PagePanel:
    """A panel on the page.

    Parameters
    ----------
    letter
        Its letter, from A on.
    step
        What it shows.
    caption
        The lines of its caption.
    middle
        Its middle on the page in mm, shape (2,).
    drawing
        The drawing.
    labels
        Labels with leaders.
    measures
        Lengths and angles.
    bar
        Length of the scale bar in mm of tissue, 0 for none.
    """

    letter: str
    step: PlateStep
    caption: tuple[str, ...]
    middle: NDArray[np.float64]
    drawing: PanelDrawing
    labels: tuple[PlacedLabel, ...]
    measures: tuple[Measure, ...]
    bar: float


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
    scene
        What they show.
    alt
        What the page shows, for those who cannot see it.
    """

    size: tuple[float, float]
    panel: tuple[float, float]
    panels: tuple[PagePanel, ...]
    scene: PlateScene
    alt: str

    def texts(self) -> list[str]:
        """List all texts on the page.

        Returns
        -------
        list[str]
            The texts.
        """
        found = []
        for panel in self.panels:
            found += [panel.letter, *panel.caption, *(each.text for each in panel.labels)]
            found += [each.text for each in panel.measures] + [each.text for each in panel.drawing.letters]
            found += [f"{panel.bar:g} mm"] if panel.bar else []
        return found


@dataclass(frozen=True)
class PlateRequest:
    """What is to be on a plate.

    Parameters
    ----------
    steps
        The panels.
    captions
        By the index of a panel, a caption in place of the catalogue's.
    width
        Width of the page in mm.
    columns
        Panels in a row; None: as many as fit.
    view
        One of `lappet.drawing.framing.VIEWS`.
    labels, letters, arrows, measures
        Whether there are labels with leaders, letters at corners, arrows of movement, lengths and angles.
    instruments
        Whether hooks are drawn.
    """

    steps: tuple[PlateStep, ...]
    captions: Mapping[int, str]
    width: float = 174.0
    columns: int | None = None
    view: str = "oblique"
    labels: bool = True
    letters: bool = True
    arrows: bool = True
    measures: bool = True
    instruments: bool = True


def plate_page(
    source: SkinCache, request: PlateRequest, style: PlateStyle, words: PlateWords, font: PlateFont
) -> PlatePage:
    """Make a page.

    Parameters
    ----------
    source
        The solved procedure.
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
        If the width is out of range, a panel has too many labels, or the font lacks a character.
    """
    if not LEAST_WIDTH <= request.width <= WIDEST:
        raise refused(ProblemCode.PLATE_WIDTH, "", request.width, range=f"{LEAST_WIDTH:g} to {WIDEST:g}")
    captions = [
        request.captions.get(k) or words(f"step.{step.kind}", time=f"{step.time:g}")
        for k, step in enumerate(request.steps)
    ]
    font.check([*captions, *(words(key) for key in (*STROKE_LABELS.values(), *AREA_LABELS.values()))])
    columns, width = _columns(request)
    panel = (width, _ASPECT * width)
    scene = plate_scene(source, [step.time for step in request.steps], request.view, panel)
    indent = font.width("M", CAPTION_SIZE) + 1.5
    lines = [tuple(font.wrapped(each, CAPTION_SIZE, width - indent)) for each in captions]
    rows = [max(len(each) for each in lines[k : k + columns]) for k in range(0, len(lines), columns)]
    heights = [panel[1] + 1.5 + LINE * CAPTION_SIZE * count + GUTTER for count in rows]
    tops = np.concatenate([[0.0], np.cumsum(heights)])
    panels = []
    told: set[str] = set()
    for k in range(len(request.steps)):
        middle = np.array([(k % columns) * (width + GUTTER) + 0.5 * width, float(tops[k // columns]) + 0.5 * panel[1]])
        panels.append(_panel(scene, request, style, words, font, k, panel, lines[k], middle, told))
    alt = words("alt.plate", count=len(panels))
    alt += "".join(" " + words("alt.panel", letter=p.letter, caption=" ".join(p.caption)) for p in panels)
    return PlatePage((request.width, float(tops[-1]) - GUTTER), panel, tuple(panels), scene, alt)


def _columns(request: PlateRequest) -> tuple[int, float]:
    """Panels in a row and the width of one in mm."""
    count = len(request.steps)
    most = max(int((request.width + GUTTER) // (_PANEL + GUTTER)), 1)
    columns = request.columns or min(most, count, 2 if count == 4 else count)
    return columns, (request.width - (columns - 1) * GUTTER) / columns


def _panel(
    scene: PlateScene,
    request: PlateRequest,
    style: PlateStyle,
    words: PlateWords,
    font: PlateFont,
    index: int,
    size: tuple[float, float],
    caption: tuple[str, ...],
    middle: NDArray[np.float64],
    told: set[str],
) -> PagePanel:
    """One panel. told: keys of labels that a panel before it has; what is new is added."""
    step = request.steps[index]
    later = _later(scene, request.steps, index) if request.arrows else ()
    held = request.instruments and step.kind not in (StepKind.SUTURED, StepKind.RESULT)
    drawing = panel_drawing(scene, step.time, size, style, later, request.letters, held)
    letter = ascii_uppercase[index % 26]
    sites = label_sites(drawing) if request.labels else {}
    fresh = {key: site for key, site in sites.items() if key not in told}
    told.update(fresh)
    named = [(words(key), site) for key, site in fresh.items()]
    widths = [font.width(text, LABEL_SIZE) for text, _ in named]
    labels = place_labels(named, widths, size, LINE * LABEL_SIZE, _taken(drawing), letter)
    planned = step.kind in (StepKind.PLAN, StepKind.PLAN_EXCISION)
    measures: list[Measure] = []
    if planned and request.measures:
        letters = [each.at for each in drawing.letters]
        measures = plan_measures(scene.lines, scene.corners, drawing.projection, letters)
    bar = max((each for each in _BARS if each * drawing.projection.scale <= 0.3 * size[0]), default=0.0)
    return PagePanel(letter, step, caption, middle, drawing, tuple(labels), tuple(measures), bar if index == 0 else 0.0)


def _later(scene: PlateScene, steps: Sequence[PlateStep], index: int) -> list[float]:
    """The frames along which arrows run: from the panel of the cut to where the flaps come to lie."""
    cut = [k for k, step in enumerate(steps) if step.kind.value.split("-")[0] in ("incised", "excised", "undermined")]
    ends = [step.time for step in steps[index + 1 :] if step.kind in (StepKind.SUTURED, StepKind.PLACED)]
    if not cut or cut[-1] != index or not ends:
        return []
    return [time for time in scene.source.frames if steps[index].time < time <= ends[-1]]


def _taken(drawing: PanelDrawing) -> NDArray[np.float64]:
    """Places that labels should leave free: wounds, marks, threads and letters."""
    kinds = drawing.pixels.kind[::6, ::6]
    rows, columns = np.nonzero((kinds > _KINDS.index(AreaKind.SKIN)) & (kinds < _KINDS.index(AreaKind.EYE)))
    found = [np.stack([drawing.pixels.x[::6][columns], drawing.pixels.y[::6][rows]], axis=1)]
    keep_off = (LineKind.PLAN, LineKind.THREAD, LineKind.WOUND_EDGE, LineKind.INSTRUMENT, LineKind.UNDERMINED)
    own = [LineString(stroke.points).segmentize(1.0) for stroke in drawing.strokes if stroke.kind in keep_off]
    found += [np.array(line.coords) for line in own]
    found += [letter.at[None] for letter in drawing.letters]
    return np.vstack(found)
