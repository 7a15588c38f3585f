"""The styles of plates: how lines, areas and text look. Colors are told apart without seeing red and green."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.plates.feature_lines import LineKind
from lappet.plates.filled_areas import AreaKind
from lappet.procedure.plate import PlanPen

# Monk Skin Tone Scale, tones 1 to 10 (Monk 2019; skintone.google), sRGB.
MONK = (
    *("#f6ede4", "#f3e7db", "#f7ead0", "#eadaba", "#d7bd96"),
    *("#a07e56", "#825c43", "#604134", "#3a312a", "#292420"),
)
POINT = 25.4 / 72.0  # mm
LEAST_TEXT, MOST_TEXT = 7.0, 24.0  # pt: what publishers print, what a panel has room for
_DARK = 400  # sum of red, green and blue of a skin on which black lines are hardly seen


class Shading(StrEnum):
    """What lies below the lines."""

    NONE = "none"
    FILLS = "fills"
    WASH = "wash"
    PAINTING = "painting"


@dataclass(frozen=True)
class Pen:
    """How a line is drawn.

    Parameters
    ----------
    width
        Its width in mm.
    color
        Its color, #rrggbb.
    dashes
        Lengths of dashes and gaps in mm; none for a whole line.
    """

    width: float
    color: str
    dashes: tuple[float, ...] = ()


@dataclass(frozen=True)
class PlateStyle:
    """How a plate looks.

    Parameters
    ----------
    name
        Its name.
    shading
        What lies below the lines.
    hatched
        Whether dark places are hatched.
    pens
        The pen for each kind of line.
    fills
        Color of each kind of area.
    accent
        Color of arrows.
    text
        Size of labels and measures in points; captions are a point larger, letters at corners one and a half.
    """

    name: str
    shading: Shading
    hatched: bool
    pens: dict[LineKind, Pen]
    fills: dict[AreaKind, str]
    accent: str
    text: float = LEAST_TEXT

    @property
    def dark(self) -> bool:
        """Whether black lines on its skin need a light border."""
        skin = self.fills[AreaKind.SKIN]
        return sum(int(skin[k : k + 2], 16) for k in (1, 3, 5)) < _DARK

    @property
    def label_size(self) -> float:
        """Size of labels and measures in mm."""
        return self.text * POINT

    @property
    def caption_size(self) -> float:
        """Size of captions in mm."""
        return (self.text + 1.0) * POINT

    @property
    def letter_size(self) -> float:
        """Size of letters at corners in mm."""
        return (self.text + 1.5) * POINT


_INK = "#111111"
_BLUE = "#1f4e9c"
_PALE_BLUE = "#8ea5cd"  # recedes behind arrows and wounds
_PENS = {
    LineKind.CONTOUR: Pen(0.25, _INK),
    LineKind.WOUND_EDGE: Pen(0.4, _INK),
    LineKind.WALL_FOOT: Pen(0.18, _INK),
    LineKind.PLAN: Pen(0.45, _BLUE),
    LineKind.UNDERMINED: Pen(0.25, _BLUE),
    LineKind.UNDERMINED_HATCH: Pen(0.18, _PALE_BLUE),
    LineKind.THINNED: Pen(0.3, _BLUE, (0.3, 0.6)),
    LineKind.THINNED_HATCH: Pen(0.18, _PALE_BLUE),
    LineKind.DISSECTION: Pen(0.6, _BLUE, (1.6, 0.8)),
    LineKind.THREAD: Pen(0.25, "#10204a"),
    LineKind.INSTRUMENT: Pen(0.7, "#5a6068"),
    LineKind.VESSEL: Pen(0.5, "#a5231c"),
    LineKind.HATCHING: Pen(0.18, _INK),
    LineKind.SKIN_LINE: Pen(0.18, "#8a8478"),
    LineKind.SECTION: Pen(0.3, "#8b1e1e", (2.4, 0.9, 0.5, 0.9)),
    LineKind.GHOST: Pen(0.25, "#5a6068", (1.2, 0.8)),
    # Vermillion, bluish green and reddish purple of Okabe and Ito's palette, and told apart by their dashes as well.
    LineKind.VARIANT: Pen(0.5, "#d55e00", (2.2, 0.9)),
    LineKind.VARIANT_2: Pen(0.5, "#009e73", (0.7, 0.8)),
    LineKind.VARIANT_3: Pen(0.5, "#cc79a7", (2.2, 0.8, 0.4, 0.8)),
    LineKind.MARK: Pen(0.18, "#9a86bd"),
    LineKind.MARK_DOT: Pen(0.75, "#7a5aa6"),
}
# The surgeon's marking pen: gentian violet.
_VIOLET = {
    kind: replace(_PENS[kind], color="#4b2a7d") for kind in (LineKind.PLAN, LineKind.UNDERMINED, LineKind.THINNED)
}
_HATCHES = (LineKind.UNDERMINED_HATCH, LineKind.THINNED_HATCH)
_VIOLET |= {kind: replace(_PENS[kind], color="#a58fbd") for kind in _HATCHES}
_ON_SKIN = (
    LineKind.PLAN,
    LineKind.UNDERMINED,
    LineKind.THINNED,
    *_HATCHES,
    LineKind.MARK,
    LineKind.MARK_DOT,
    LineKind.SKIN_LINE,
)
# What a painting shows itself.
PAINTED = frozenset(
    {LineKind.CONTOUR, LineKind.WOUND_EDGE, LineKind.WALL_FOOT, LineKind.THREAD, LineKind.INSTRUMENT, LineKind.VESSEL}
)
_BLACK = {kind: replace(pen, color=_INK) for kind, pen in _PENS.items()}
_BLACK[LineKind.MARK] = _BLACK[LineKind.SKIN_LINE] = Pen(0.18, "#8a8a8a")
_BLACK |= {kind: Pen(0.18, "#9a9a9a") for kind in _HATCHES}  # they recede behind the hatching of wounds
_EYES = {
    AreaKind.EYE: "#f7f6f3",
    AreaKind.IRIS: "#5b6b74",
    AreaKind.PUPIL: "#15181a",
    AreaKind.TEETH: "#f2eee2",
    AreaKind.HOLLOW: "#5a3a36",
}
_FILLS = {
    AreaKind.SKIN: MONK[2],
    AreaKind.FLAP_UNDERSIDE: "#e7b04f",
    AreaKind.BED: "#c2504a",
    AreaKind.WALL_SKIN: "#e79a84",
    AreaKind.WALL_FAT: "#f0c95c",
    AreaKind.WALL_FASCIA: "#ded6c6",
    AreaKind.WALL_MUSCLE: "#a33b37",
    AreaKind.WALL_CARTILAGE: "#c3d6df",
    AreaKind.WALL_DEEP: "#b98a76",
    AreaKind.BONE: "#efe6cd",
    **_EYES,
}
_GREY = {
    AreaKind.SKIN: "#ebebeb",
    AreaKind.FLAP_UNDERSIDE: "#c4c4c4",
    AreaKind.BED: "#8a8a8a",
    AreaKind.WALL_SKIN: "#dadada",
    AreaKind.WALL_FAT: "#efefef",
    AreaKind.WALL_FASCIA: "#f8f8f8",
    AreaKind.WALL_MUSCLE: "#a8a8a8",
    AreaKind.WALL_CARTILAGE: "#cdcdcd",
    AreaKind.WALL_DEEP: "#b8b8b8",
    AreaKind.BONE: "#f4f4f4",
    AreaKind.EYE: "#f6f6f6",
    AreaKind.IRIS: "#6b6b6b",
    AreaKind.PUPIL: "#181818",
    AreaKind.TEETH: "#efefef",
    AreaKind.HOLLOW: "#454545",
}
STYLES = {
    "ink": PlateStyle("ink", Shading.NONE, True, _BLACK, _GREY, _INK),
    "schematic": PlateStyle("schematic", Shading.FILLS, False, _PENS, _FILLS, _BLUE),
    "halftone": PlateStyle("halftone", Shading.WASH, False, _BLACK, _GREY, _INK),
    "wash": PlateStyle("wash", Shading.WASH, False, _PENS, _FILLS, _BLUE),
    "painted": PlateStyle("painted", Shading.PAINTING, False, {**_PENS, **_VIOLET}, _FILLS, _BLUE),
}


_LIGHT_LINES = 8  # from this tone on black lines are hardly seen
_PALE = "#f3e6da"


def _between(one: str, other: str, share: float) -> str:
    """A color on the way from one to another."""
    ends = [[int(color[k : k + 2], 16) for k in (1, 3, 5)] for color in (one, other)]
    return "#" + "".join(f"{round(a + share * (b - a)):02x}" for a, b in zip(*ends, strict=True))


# How planned cuts are drawn.
_PLAN_PENS: dict[PlanPen, tuple[float, tuple[float, ...]]] = {
    "dashed": (0.45, (1.5, 1.1)),
    "dotted": (0.5, (0.01, 1.0)),
    "marker": (0.95, ()),
}


def plate_style(name: str, tone: int | None = None, text: float = LEAST_TEXT, plan_pen: PlanPen = "") -> PlateStyle:
    """Choose a style.

    Parameters
    ----------
    name
        One of `STYLES`.
    tone
        Tone of the skin on the Monk scale, 1 to 10; None for the style's own.
    text
        Size of labels and measures in points.
    plan_pen
        How planned cuts are drawn.

    Returns
    -------
    PlateStyle
        The style. On dark skin plans are drawn in white, and on the darkest the edges of wounds are light too.

    Raises
    ------
    RefusedError
        If the text is smaller than publishers print, or larger than a panel has room for.
    """
    if not LEAST_TEXT <= text <= MOST_TEXT:
        raise refused(ProblemCode.PLATE_TEXT, "", f"{text:g}", least=f"{LEAST_TEXT:g}", most=f"{MOST_TEXT:g}")
    style = replace(STYLES[name], text=text)
    if plan_pen:
        width, dashes = _PLAN_PENS[plan_pen]
        plan = replace(style.pens[LineKind.PLAN], width=width, dashes=dashes)
        style = replace(style, pens={**style.pens, LineKind.PLAN: plan})
    if tone is None or style.fills is _GREY:
        return style
    fills = {**style.fills, AreaKind.SKIN: MONK[tone - 1]}
    if tone < 7:
        return replace(style, fills=fills)
    white = {kind: replace(style.pens[kind], color="#f4f6ff") for kind in _ON_SKIN}
    quiet = _between(MONK[tone - 1], "#f4f6ff", 0.35)
    white |= {kind: replace(style.pens[kind], color=quiet) for kind in _HATCHES}
    if tone >= _LIGHT_LINES:
        white |= {kind: replace(style.pens[kind], color=_PALE) for kind in (LineKind.WOUND_EDGE, LineKind.CONTOUR)}
    pens = {**style.pens, **white, LineKind.THREAD: replace(style.pens[LineKind.THREAD], color="#d7e3ff")}
    return replace(style, fills=fills, pens=pens)
