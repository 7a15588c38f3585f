"""Draw a film of an operation for class: its solved frames as line drawings with captions, held at each step."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.foreign.limits import DEFAULT_LIMITS, ReadLimits
from lappet.plates.contact_sheet import check_sheet, write_contact_sheet
from lappet.plates.film_camera import MOST_TURN, camera_way
from lappet.plates.film_file import check_film, write_film
from lappet.plates.film_frames import FilmFrame, chapters, film_frames
from lappet.plates.page_ground import CLEAR, DARK, WHITE, PageGround
from lappet.plates.painting import Painted, paint
from lappet.plates.plate_cache import chosen_steps, open_cache
from lappet.plates.plate_files import write_plate
from lappet.plates.plate_font import PlateFont, plate_font
from lappet.plates.plate_page import PlatePage, checked_texts
from lappet.plates.plate_panel import LINE, PagePanel, PanelMaker
from lappet.plates.plate_request import PlateRequest, PlateRow
from lappet.plates.plate_scene import plate_scene
from lappet.plates.plate_steps import PlateStep
from lappet.plates.plate_style import Shading, plate_style
from lappet.plates.plate_svg import plate_svg
from lappet.plates.plate_words import PlateWords, plate_words
from lappet.plates.title_card import title_card
from lappet.plates.told_labels import ToldLabels

WIDTH = 150.0  # mm: a page of this width fills the picture, so that text is read from the last row
_ONWARDS = "\N{RIGHTWARDS ARROW}"  # before the caption of a step that is on its way


@dataclass(frozen=True)
class FilmOptions:
    """How a film is drawn.

    Parameters
    ----------
    style
        Name of the style.
    tone
        Tone of the skin on the Monk scale, 1 to 10; None for the style's own.
    language
        One of `lappet.plates.plate_words.LANGUAGES`.
    own
        A TOML file with texts in place of the catalogue's.
    font
        A font file; None for Source Sans Pro.
    size
        Width and height in pixels.
    fps
        Solved frames per second.
    pause
        Seconds for which each step is held.
    view
        One of `lappet.drawing.framing.VIEWS`.
    title
        The film's title; "" for the cache's name.
    card
        Seconds for which the title and the steps are shown before all else; 0: not at all.
    orbit
        Degrees by which the camera turns about the operation from the first picture to the last; 0: it stands.
    marks
        What is printed on the skin, one of `lappet.plates.printed_marks.MARKS`, or None.
    dark, transparent
        Whether the ground is dark, or left out.
    sheet
        The file of a contact sheet, or None.
    """

    style: str = "schematic"
    tone: int | None = None
    language: str = "en"
    own: Path | None = None
    font: Path | None = None
    size: tuple[int, int] = (1920, 1080)
    fps: float = 8.0
    pause: float = 2.0
    view: str = "oblique"
    title: str = ""
    card: float = 0.0
    orbit: float = 0.0
    marks: str | None = None
    dark: bool = False
    transparent: bool = False
    sheet: Path | None = None

    @property
    def ground(self) -> PageGround:
        """The ground of its pictures."""
        return CLEAR if self.transparent else DARK if self.dark else WHITE


def draw_film(
    cache: Path,
    path: Path,
    options: FilmOptions = FilmOptions(),
    limits: ReadLimits = DEFAULT_LIMITS,
    progress: Callable[[int, int], None] = lambda done, of: None,
) -> Path:
    """Draw a film.

    Parameters
    ----------
    cache
        The skin cache.
    path
        The file; its suffix says what it becomes.
    options
        How.
    limits
        What reading may take.
    progress
        Is told how many pictures of how many are drawn.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    RefusedError
        If a value makes no sense, the cache cannot be read, or FFmpeg fails; nothing is written then.
    OSError
        If a file cannot be written.
    """
    check_film(path, options.size, options.transparent)
    if options.sheet is not None:
        check_sheet(options.sheet)
    _check(path, options)
    words, font = plate_words(options.language, options.own), plate_font(options.font, options.language)
    style = plate_style(options.style, options.tone)
    below = 1.5 + LINE * style.caption_size  # mm of the caption
    source = open_cache(cache, limits)
    steps = chosen_steps(source)
    frames = film_frames(source.frames, steps, options.fps, options.pause, bool(options.orbit))
    request = PlateRequest(
        (PlateRow(source, tuple(each.step for each in frames)),),
        {},
        WIDTH,
        1,
        options.view,
        bars=True,
        marks=options.marks,
    )
    size = (WIDTH, WIDTH * options.size[1] / options.size[0] - below)
    scene = plate_scene(source, [step.time for step in steps], options.view, size)
    checked_texts(request, [caption(step, words) for step in steps], words, font)
    scenes = camera_way(scene, options.view, size, options.orbit, len(frames))
    makers = [PanelMaker(request, (each,), style, words, font, size) for each in scenes]
    title = options.title or cache.name.split(".")[0].replace("_", " ")
    with tempfile.TemporaryDirectory(prefix="lappet_film_") as folder:
        pictures = _opened(title, steps, words, makers[0], options, Path(folder))
        begin = sum(seconds for _, seconds in pictures)
        total = len(frames) * (2 if style.shading is Shading.PAINTING else 1)
        paintings = _painted(makers, frames, options, Path(folder), lambda done: progress(done, total))
        told = ToldLabels()
        for number, frame in enumerate(frames):
            picture = Path(folder) / f"{number:05d}.png"
            painting = paintings[number].read_bytes() if paintings else None
            _draw(makers[number], number, frame, told, options, picture, painting)
            pictures.append((picture, frame.seconds))
            progress(total - len(frames) + number + 1, total)
        if options.sheet is not None:
            write_contact_sheet(_held(frames, pictures), options.sheet, font.path, options.ground)
        parts = [(begin + start, begin + end, caption(step, words)) for start, end, step in chapters(frames)]
        parts = [(0.0, begin, title), *parts] if begin else parts
        write_film(pictures, parts, title, path, options.size, options.transparent)
    return path


def caption(step: PlateStep, words: PlateWords) -> str:
    """Say what a step shows.

    Parameters
    ----------
    step
        The step.
    words
        The catalogue.

    Returns
    -------
    str
        Its caption.
    """
    return words(step.key, time=f"{step.time:g}")


def film_caption(frame: FilmFrame, words: PlateWords, font: PlateFont) -> str:
    """Say what a picture of a film shows, or what it is on the way to.

    Parameters
    ----------
    frame
        The picture.
    words
        The catalogue.
    font
        The font.

    Returns
    -------
    str
        The caption of its step, on the way to it behind an arrow where the font has one.
    """
    said = caption(frame.caption, words)
    return said if frame.step == frame.caption or not font.has(_ONWARDS) else f"{_ONWARDS} {said}"


def film_panel(maker: PanelMaker, number: int, frame: FilmFrame, told: ToldLabels) -> PagePanel:
    """Make a picture's panel: where a film is held it names what is seen; on the way these names ride along.

    Parameters
    ----------
    maker
        Makes panels.
    number
        The picture's number.
    frame
        The picture.
    told
        The labels of the picture before it.

    Returns
    -------
    PagePanel
        The panel.
    """
    held = frame.step == frame.caption
    told.riding = not held
    told.keys = set() if held else told.keys
    middle = np.array([0.5 * WIDTH, 0.5 * maker.size[1]])
    (panel, *_) = maker.panels(number, (film_caption(frame, maker.words, maker.font),), middle, told)
    return replace(panel, letter="")  # it is alone


def _draw(
    maker: PanelMaker,
    number: int,
    frame: FilmFrame,
    told: ToldLabels,
    options: FilmOptions,
    path: Path,
    painting: bytes | None,
) -> None:
    """Draw a picture."""
    panel = film_panel(maker, number, frame, told)
    said = film_caption(frame, maker.words, maker.font)
    page = PlatePage(_page_size(options), maker.size, (panel,), said)
    dpi = 25.4 * options.size[0] / WIDTH
    paintings = {} if painting is None else {0: painting}
    svg = plate_svg(page, maker.style, maker.font, dpi, options.ground, paintings, carries_font=False)
    write_plate(svg, page.size, said, maker.font, path, dpi, transparent=options.transparent)


def _held(frames: Sequence[FilmFrame], pictures: Sequence[tuple[Path, float]]) -> list[tuple[Path, float]]:
    """The first picture of each step, and when it is shown; `pictures` are those of the frames after a title card."""
    found: dict[PlateStep, tuple[Path, float]] = {}
    now = sum(seconds for _, seconds in pictures[: len(pictures) - len(frames)])
    for frame, (picture, seconds) in zip(frames, pictures[len(pictures) - len(frames) :], strict=True):
        if frame.step == frame.caption:
            found.setdefault(frame.step, (picture, now))
        now += seconds
    return list(found.values())


def _painted(
    makers: Sequence[PanelMaker],
    frames: Sequence[FilmFrame],
    options: FilmOptions,
    folder: Path,
    done: Callable[[int], None],
) -> list[Path]:
    """Paint the pictures of a film, where its style is painted."""
    if makers[0].style.shading is not Shading.PAINTING:
        return []
    wanted = [
        Painted(maker.scenes[0], each.step.time, maker.size, maker.request.shows_hooks(each.step))
        for maker, each in zip(makers, frames, strict=True)
    ]
    count = iter(range(1, len(frames) + 1))
    return paint(wanted, options.tone, 25.4 * options.size[0] / WIDTH, folder, lambda line: done(next(count)))


def _page_size(options: FilmOptions) -> tuple[float, float]:
    """Width and height of a picture in mm."""
    return WIDTH, WIDTH * options.size[1] / options.size[0]


def _check(path: Path, options: FilmOptions) -> None:
    """Refuse times and turns that no film has."""
    if not (0.1 <= options.fps <= 60.0 and 0.0 < options.pause <= 60.0):
        raise refused(ProblemCode.FILM_SPEED, path, f"{options.fps:g} and {options.pause:g}")
    if not 0.0 <= options.card <= 60.0:
        raise refused(ProblemCode.FILM_CARD, path, f"{options.card:g}")
    if not abs(options.orbit) <= MOST_TURN or (options.orbit and options.view == "top"):
        raise refused(ProblemCode.FILM_CAMERA, path, f"{options.orbit:g}", most=f"{MOST_TURN:g}")
    if options.dark and options.transparent:
        raise refused(ProblemCode.FILM_GROUND, path)


def _opened(
    title: str, steps: Sequence[PlateStep], words: PlateWords, maker: PanelMaker, options: FilmOptions, folder: Path
) -> list[tuple[Path, float]]:
    """The title card and how long it is shown, where there is one."""
    if not options.card:
        return []
    size, font, picture = _page_size(options), maker.font, folder / "title.png"
    font.check([title])
    said = [caption(step, words) for step in steps]
    svg = title_card(title, said, size, maker.style, font, options.ground)
    write_plate(svg, size, title, font, picture, 25.4 * options.size[0] / WIDTH, transparent=options.transparent)
    return [(picture, options.card)]
