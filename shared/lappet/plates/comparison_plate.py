"""A plate that shows operations beside each other: a row for each, planned and as it ends, with what was measured."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from string import ascii_uppercase

from lappet.drawing.skin_read import SkinCache
from lappet.plates.plate_font import PlateFont
from lappet.plates.plate_page import GUTTER, PlatePage, PlateRequest, plate_page
from lappet.plates.plate_steps import PlateStep, StepKind
from lappet.plates.plate_style import PlateStyle
from lappet.plates.plate_svg import plate_svg
from lappet.plates.plate_words import PlateWords

WIDTH = 174.0  # mm, of a page with two columns


@dataclass(frozen=True, eq=False)
class Operation:
    """An operation of the plate.

    Parameters
    ----------
    name
        What it is called.
    source
        Its solved frames.
    measured
        What its second caption says.
    """

    name: str
    source: SkinCache
    measured: str


@dataclass(frozen=True)
class ComparisonPlate:
    """The plate.

    Parameters
    ----------
    svg
        The document.
    size
        Width and height in mm.
    alt
        What it shows, for those who cannot see it.
    """

    svg: str
    size: tuple[float, float]
    alt: str


def comparison_plate(
    operations: Sequence[Operation], style: PlateStyle, words: PlateWords, font: PlateFont, dpi: float = 300.0
) -> ComparisonPlate:
    """Draw operations beside each other.

    Parameters
    ----------
    operations
        The operations, at most 13: every panel has a letter of its own.
    style
        How the plate looks.
    words
        What it says besides.
    font
        Its font.
    dpi
        Pixels per inch of shading.

    Returns
    -------
    ComparisonPlate
        The plate.

    Raises
    ------
    RefusedError
        As `lappet.plates.plate_page.plate_page`.
    """
    pages = [_lettered(_row(each, style, words, font), 2 * k) for k, each in enumerate(operations)]
    height = sum(page.size[1] + GUTTER for page in pages) - GUTTER
    rows, top = [], 0.0
    for page in pages:
        rows.append(_nested(plate_svg(page, style, font, dpi, background=False), top))
        top += page.size[1] + GUTTER
    alt = " ".join(page.alt for page in pages)
    safe = alt.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")
    head = (
        '<?xml version="1.0" encoding="UTF-8"?>\n<svg xmlns="http://www.w3.org/2000/svg" '
        'xmlns:xlink="http://www.w3.org/1999/xlink" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" '
        f'width="{WIDTH:g}mm" height="{height:.3f}mm" viewBox="0 0 {WIDTH:g} {height:.3f}" role="img" '
        f'aria-label="{safe}"><title>{safe}</title>'
        f'<rect width="{WIDTH:g}" height="{height:.3f}" fill="#ffffff"/>'
    )
    return ComparisonPlate(head + "".join(rows) + "</svg>", (WIDTH, height), alt)


def _row(operation: Operation, style: PlateStyle, words: PlateWords, font: PlateFont) -> PlatePage:
    """The two panels of an operation: the plan on the skin as it was, and the last frame."""
    frames = operation.source.frames
    steps = (PlateStep(frames[0], StepKind.PLAN), PlateStep(frames[-1], StepKind.RESULT))
    captions = {0: operation.name, 1: operation.measured}
    return plate_page(operation.source, PlateRequest(steps, captions, WIDTH, 2, labels=False), style, words, font)


def _lettered(page: PlatePage, first: int) -> PlatePage:
    """The page with its letters from another one on."""
    panels = [replace(each, letter=ascii_uppercase[(first + k) % 26]) for k, each in enumerate(page.panels)]
    return replace(page, panels=tuple(panels))


def _nested(svg: str, top: float) -> str:
    """A document in mm as a part of another, so far down."""
    begin = svg.index("<svg")
    end = svg.index(">", begin)
    width, height = re.findall(r'viewBox="0 0 (\S+) (\S+)"', svg[begin:end])[0]
    head = f'<svg x="0" y="{top:.3f}" width="{width}" height="{height}" viewBox="0 0 {width} {height}">'
    return head + svg[end + 1 :].strip()
