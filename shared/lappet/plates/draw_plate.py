"""Draw the plate of a skin cache into files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lappet.foreign.limits import DEFAULT_LIMITS, ReadLimits
from lappet.plates.plate_cache import chosen_steps, compared_steps, open_cache
from lappet.plates.plate_files import check_format, write_plate
from lappet.plates.plate_font import PlateFont
from lappet.plates.plate_page import plate_page
from lappet.plates.plate_request import PlateRequest, PlateRow
from lappet.plates.plate_style import plate_style
from lappet.plates.plate_svg import plate_svg
from lappet.plates.plate_words import plate_words


@dataclass(frozen=True)
class PlateOptions:
    """How a plate is drawn and written.

    Parameters
    ----------
    style
        Name of the style.
    tone
        Tone of the skin on the Monk scale, 1 to 10; None for the style's own.
    frames
        Time codes of the panels; None for the operation's steps.
    captions
        By the index of a panel, a caption in place of the catalogue's.
    language
        One of `lappet.plates.plate_words.LANGUAGES`.
    own
        A TOML file with texts in place of the catalogue's.
    font
        A font file; None for Source Sans Pro.
    dpi
        Pixels per inch of what is no line.
    profile
        ICC profile of a printing process, for a TIFF in CMYK.
    transparent
        Whether the paper is left out.
    shown
        Width, columns, view and what is shown, as in `PlateRequest`.
    """

    style: str = "schematic"
    tone: int | None = None
    frames: tuple[float, ...] | None = None
    captions: Mapping[int, str] = field(default_factory=dict)
    language: str = "en"
    own: Path | None = None
    font: Path | None = None
    dpi: int = 300
    profile: Path | None = None
    transparent: bool = False
    shown: Mapping[str, Any] = field(default_factory=dict)


def draw_plate(
    caches: Sequence[Path],
    pictures: Sequence[Path],
    options: PlateOptions = PlateOptions(),
    limits: ReadLimits = DEFAULT_LIMITS,
) -> list[Path]:
    """Draw a plate.

    Parameters
    ----------
    caches
        The skin caches: of one its steps, of several what is planned and what comes of it, at one scale.
    pictures
        The files to write; their suffixes say what each becomes.
    options
        How.
    limits
        What reading may take.

    Returns
    -------
    list[Path]
        The files.

    Raises
    ------
    RefusedError
        If a value makes no sense or the cache cannot be read; nothing is written then.
    OSError
        If a file cannot be written.
    """
    for picture in pictures:
        check_format(picture, options.profile)
    words, font = plate_words(options.language, options.own), PlateFont(options.font)
    style = plate_style(options.style, options.tone)
    rows = tuple(_row(cache, len(caches) > 1, options, limits) for cache in caches)
    page = plate_page(PlateRequest(rows, options.captions, **options.shown), style, words, font)
    svg = plate_svg(page, style, font, options.dpi, not options.transparent)
    for picture in pictures:
        write_plate(svg, page.size, page.alt, font, picture, options.dpi, options.profile, options.transparent)
    return list(pictures)


def _row(cache: Path, compared: bool, options: PlateOptions, limits: ReadLimits) -> PlateRow:
    source = open_cache(cache, limits)
    if not compared:
        return PlateRow(source, chosen_steps(source, options.frames))
    steps = compared_steps(source) if options.frames is None else chosen_steps(source, options.frames)
    return PlateRow(source, steps, cache.name.split(".")[0].replace("_", " "))
