"""`lappet film`: a solved procedure as a film for class."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click

from lappet.commands.extras import extra
from lappet.commands.parameters import FILE, Size
from lappet.commands.reading_options import reading_options
from lappet.commands.refusals import sentences
from lappet.foreign.limits import ReadLimits

_STYLES = ("ink", "schematic", "halftone", "wash", "painted")
_LANGUAGES = ("en", "de", "fr", "es", "zh")
_MARKS = ("grid", "squares", "dots")
_VIEWS = ("oblique", "top", "low")


@click.command()
@click.argument("cache", type=FILE)
@click.option(
    "-o", "--output", "film", type=FILE, required=True, help="The film (.mp4, .webm, .gif, .webp, or .png: numbered)."
)
@click.option("--style", type=click.Choice(_STYLES), default="schematic", show_default=True, help="How it is drawn.")
@click.option("--skin-tone", "tone", type=click.IntRange(1, 10), help="Tone of the skin on the Monk scale, 1 to 10.")
@click.option(
    "--size", type=Size(), default="1920x1080", show_default=True, help="Pixels, even, 240 or more; 3840x2160 for 4K."
)
@click.option("--fps", type=float, default=8.0, show_default=True, help="Solved frames per second, 0.1 to 60.")
@click.option("--pause", type=float, default=2.0, show_default=True, help="Seconds on each step, up to 60.")
@click.option("--view", type=click.Choice(_VIEWS), default="oblique", show_default=True, help="Where the camera is.")
@click.option("--language", type=click.Choice(_LANGUAGES), default="en", show_default=True)
@click.option("--captions", "own", type=FILE, help="A TOML file with captions and labels in other words.")
@click.option("--font", type=FILE, help="A font file (.ttf, .otf, .ttc).  [default: Source Sans Pro]")
@click.option("--title", default="", help="The film's title.  [default: the cache's name]")
@click.option("--marks", type=click.Choice(_MARKS), help="What is printed on the skin and deforms with it.")
@click.option("--card", type=float, default=0.0, show_default=True, help="Seconds of a title card, up to 60.")
@click.option("--orbit", type=float, default=0.0, show_default=True, help="Degrees by which the camera turns, to 120.")
@click.option("--dark", is_flag=True, help="A dark ground.")
@click.option("--transparent", is_flag=True, help="Leave the ground out (.webm, .webp, .png).")
@click.option("--sheet", type=FILE, help="Also a contact sheet of the steps (.png, .tif).")
@reading_options
@click.pass_context
def film(context: click.Context, /, cache: Path, film: Path, limits: ReadLimits, **options: Any) -> None:
    """Draw a film: every solved frame as a line drawing with its caption, held at each step, which is a chapter."""
    with sentences(context):
        draw_with_progress(cache, film, options, limits)
        click.echo(film)


def draw_with_progress(cache: Path, film: Path, options: Mapping[str, Any], limits: ReadLimits) -> None:
    """Draw a film, with a bar in the terminal.

    Parameters
    ----------
    cache
        The skin cache.
    film
        The file.
    options
        Fields of `lappet.plates.draw_film.FilmOptions`.
    limits
        What reading may take.

    Raises
    ------
    RefusedError
        If the film cannot be drawn, or packages for it are missing; nothing is written then.
    OSError
        If a file cannot be written.
    """
    from rich.console import Console
    from rich.progress import Progress

    with extra("A film", "film,plates"):
        import imageio_ffmpeg  # noqa: F401 - missing, it would be missed after all has been drawn

        from lappet.plates.draw_film import FilmOptions, draw_film

    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as progress:
        task = progress.add_task("Drawing", total=None)
        draw_film(
            *(cache, film, FilmOptions(**options), limits),
            lambda done, of: progress.update(task, completed=done, total=of),
        )
