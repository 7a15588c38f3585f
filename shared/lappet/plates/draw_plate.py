"""Draw the plate of a skin cache into files."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from lappet.core.problem import Problem, refused
from lappet.core.problem_code import ProblemCode
from lappet.drawing.skin_read import SkinCache
from lappet.foreign.limits import DEFAULT_LIMITS, ReadLimits
from lappet.plates.journals import Journal, journal_of
from lappet.plates.page_ground import CLEAR, WHITE
from lappet.plates.painting import page_paintings
from lappet.plates.planned_panels import plate_panels
from lappet.plates.plate_cache import chosen_steps, compared_steps, open_cache, plate_of
from lappet.plates.plate_files import check_format, write_plate
from lappet.plates.plate_font import plate_font
from lappet.plates.plate_page import plate_page
from lappet.plates.plate_request import PlateRequest, PlateRow
from lappet.plates.plate_style import LEAST_TEXT, PlateStyle, plate_style
from lappet.plates.plate_svg import plate_svg
from lappet.plates.plate_templates import from_template
from lappet.plates.plate_words import LANGUAGES, plate_words
from lappet.procedure.plate import PlanPen, Plate
from lappet.usd.stage import read_procedure

_DPI = 300


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
        Pixels per inch of what is no line; None for the least that the journal takes, or 300.
    profile
        ICC profile of a printing process, for a TIFF in CMYK.
    transparent
        Whether the paper is left out.
    shown
        Width, columns, view and what is shown, as in `PlateRequest`.
    plate
        Name of a plate of the procedure, of which all is taken that `PlateOptions` does not say otherwise than by
        default; "" for none.
    template
        Name of a template that takes its place, "" for none.
    text
        Size of labels in points; None for the least that the journal prints, or 7.
    journal
        One of `lappet.procedure.plate.JOURNALS`, whose rules the plate keeps, or "".
    plan_pen
        How planned cuts are drawn, one of `lappet.procedure.plate.PLAN_PENS`.
    overlay
        Whether the outlines of all caches but the first are drawn over its panels.
    """

    style: str = "schematic"
    tone: int | None = None
    frames: tuple[float, ...] | None = None
    captions: Mapping[int, str] = field(default_factory=dict)
    language: str = "en"
    own: Path | None = None
    font: Path | None = None
    dpi: int | None = None
    profile: Path | None = None
    transparent: bool = False
    shown: Mapping[str, Any] = field(default_factory=dict)
    plate: str = ""
    template: str = ""
    text: float | None = None
    journal: str = ""
    plan_pen: PlanPen = ""
    overlay: bool = False


@dataclass(frozen=True)
class DrawnPlate:
    """A plate that has been drawn.

    Parameters
    ----------
    pictures
        Its files.
    options
        How it was drawn: what was wanted, with what a plate of the procedure says besides.
    notes
        What of it could not be drawn, and why.
    """

    pictures: tuple[Path, ...]
    options: PlateOptions
    notes: tuple[Problem, ...] = ()


def draw_plate(
    caches: Sequence[Path],
    pictures: Sequence[Path],
    options: PlateOptions = PlateOptions(),
    limits: ReadLimits = DEFAULT_LIMITS,
    progress: Callable[[str], None] = lambda line: None,
) -> DrawnPlate:
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
    progress
        Called with a line of text for every panel that is painted.

    Returns
    -------
    DrawnPlate
        The files, and what could not be drawn.

    Raises
    ------
    RefusedError
        If a value makes no sense, a cache cannot be read, or its procedure has no such plate; nothing is written then.
    OSError
        If a file cannot be written.
    """
    for picture in pictures:
        check_format(picture, options.profile)
    sources = [open_cache(cache, limits) for cache in caches]
    notes: list[Problem] = []
    kept = plate_of(sources[0], options.plate, notes) if options.plate else None
    if options.template:
        kept = from_template(read_procedure(caches[0], limits=limits), options.template)
    if kept is not None:
        options = of_plate(options, kept)
    words, font = plate_words(options.language, options.own), plate_font(options.font, options.language)
    options, style, journal = _kept_rules(options, tuple(pictures))
    dpi = options.dpi or _DPI
    rows = tuple(_row(source, len(caches) > 1, options, kept, notes) for source in sources)
    over = rows[1:] if options.overlay else ()
    request = PlateRequest(
        (replace(rows[0], title=""),) if over else rows,
        options.captions,
        **options.shown,
        annotations=kept.annotations if kept else (),
        overlaid=over,
    )
    page = plate_page(request, style, words, font)
    if journal is not None:
        journal.check_height(page.size)
    paintings = page_paintings(page, style, options.tone, dpi, progress)
    ground = CLEAR if options.transparent else WHITE
    as_svg = any(picture.suffix.lower() == ".svg" for picture in pictures)
    svg = plate_svg(page, style, font, dpi, ground, paintings, carries_font=as_svg)
    for picture in pictures:
        write_plate(svg, page.size, page.alt, font, picture, dpi, options.profile, options.transparent)
    notes += journal.notes(font.family, tuple(pictures)) if journal is not None else []
    notes += [note for panel in page.panels for note in panel.notes.notes]
    return DrawnPlate(tuple(pictures), options, tuple(notes))


def of_plate(options: PlateOptions, plate: Plate) -> PlateOptions:
    """Take from a plate of the procedure what options leave at their defaults.

    Parameters
    ----------
    options
        The options.
    plate
        The plate.

    Returns
    -------
    PlateOptions
        The options of the plate.

    Raises
    ------
    RefusedError
        If the plate is in a language that the catalogue does not have.
    """
    if plate.language not in LANGUAGES:
        raise refused(ProblemCode.PLATE_LANGUAGE, plate.name, plate.language, known=", ".join(LANGUAGES))
    default = PlateOptions()
    section = None
    if plate.section_at is not None and plate.section_normal is not None:
        section = (*plate.section_at, *plate.section_normal)
    journal = options.journal or plate.journal
    own = {
        "width": None if journal and plate.width == Plate.width else plate.width,
        "columns": plate.columns or None,
        "view": plate.view,
        "labels": plate.labels,
        "letters": plate.letters,
        "arrows": plate.arrows,
        "measures": plate.measures,
        "instruments": plate.instruments,
        "landmarks": plate.landmarks,
        "section": section,
        "mapped": plate.quantity or None,
        "marks": plate.marks or None,
        "marks_spacing": plate.marks_spacing,
        "skin_lines": plate.skin_lines,
        "hatched": plate.hatched,
    }
    return replace(
        options,
        style=plate.style if options.style == default.style else options.style,
        tone=(plate.tone or None) if options.tone is None else options.tone,
        language=plate.language if options.language == default.language else options.language,
        text=(plate.text or None) if options.text is None else options.text,
        journal=journal,
        plan_pen=options.plan_pen or plate.plan_pen,
        shown={**own, **options.shown},
    )


def _kept_rules(options: PlateOptions, pictures: tuple[Path, ...]) -> tuple[PlateOptions, PlateStyle, Journal | None]:
    """Options with what a journal asks where they say nothing, the style, and the journal."""
    if not options.journal:
        return options, plate_style(options.style, options.tone, options.text or LEAST_TEXT, options.plan_pen), None
    journal = journal_of(options.journal)
    style = plate_style(options.style, options.tone, options.text or journal.text[0], options.plan_pen)
    width = options.shown.get("width") or max(most for _, most, _ in journal.pages)
    dpi = options.dpi or journal.dpi(style)
    journal.check(width, style.text, dpi, style, pictures)
    shown = {**options.shown, "width": width, "small_letters": journal.small_letters}
    return replace(options, dpi=dpi, shown=shown), style, journal


def _row(
    source: SkinCache, compared: bool, options: PlateOptions, kept: Plate | None, notes: list[Problem]
) -> PlateRow:
    title = source.path.name.split(".")[0].replace("_", " ") if compared else ""
    if kept is not None and options.frames is None:
        return PlateRow(source, plate_panels(source, kept, notes), title)
    if compared and options.frames is None and not options.overlay:
        return PlateRow(source, compared_steps(source), title)
    return PlateRow(source, chosen_steps(source, options.frames), title)
