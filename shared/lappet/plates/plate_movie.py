"""The film of what a plate shows, drawn as the plate is."""

from __future__ import annotations

from pathlib import Path

from lappet.foreign.limits import DEFAULT_LIMITS, ReadLimits
from lappet.plates.draw_film import FilmOptions, draw_film
from lappet.plates.draw_plate import PlateOptions
from lappet.plates.film_file import check_film


def film_options(options: PlateOptions) -> FilmOptions:
    """Tell how a film looks that goes with a plate.

    Parameters
    ----------
    options
        How the plate was drawn.

    Returns
    -------
    FilmOptions
        The same style, tone, language, font, view and marks; all else as `lappet film` has it.
    """
    return FilmOptions(
        style=options.style,
        tone=options.tone,
        language=options.language,
        own=options.own,
        font=options.font,
        view=options.shown.get("view", FilmOptions.view),
        marks=options.shown.get("marks"),
        transparent=options.transparent,
    )


def check_movie(path: Path, options: PlateOptions) -> None:
    """Refuse a film that cannot be written, before the plate is drawn.

    Parameters
    ----------
    path
        The film.
    options
        How the plate is drawn.

    Raises
    ------
    RefusedError
        If its suffix is not known or has no transparency where the plate is transparent, or its folder is missing.
    """
    check_film(path, FilmOptions.size, options.transparent)


def draw_movie(cache: Path, path: Path, options: PlateOptions, limits: ReadLimits = DEFAULT_LIMITS) -> Path:
    """Draw the film that goes with a plate.

    Parameters
    ----------
    cache
        The skin cache.
    path
        The film.
    options
        How the plate was drawn.
    limits
        What reading may take.

    Returns
    -------
    Path
        The film.

    Raises
    ------
    RefusedError
        If the cache cannot be read, a value makes no sense for a film, or FFmpeg fails; nothing is written then.
    OSError
        If the file cannot be written.
    """
    return draw_film(cache, path, film_options(options), limits)
