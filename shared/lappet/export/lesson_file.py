"""`lappet export CACHE.usdc -o lesson.html`: write a lesson."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from lappet.core.durable import write_whole
from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.core.version import version
from lappet.drawing.quantity_scale import RAMP
from lappet.drawing.skin_source import FigureError
from lappet.export.export_request import ExportRequest
from lappet.export.exported_cache import exported_cache, exported_frames
from lappet.export.lesson_arrays import LessonArrays
from lappet.export.lesson_page import LessonBlock, lesson_page
from lappet.export.lesson_procedure import LessonScene, lesson_procedure
from lappet.export.lesson_skin import quantity_scales
from lappet.export.lesson_words import lesson_words
from lappet.export.simplified_cache import simplified
from lappet.export.size_limit import check_size
from lappet.export.viewer_program import viewer_program

FORMAT = 1


def write_lesson(request: ExportRequest) -> list[Path]:
    """Write a lesson of one procedure, or of two side by side; the file appears whole or not at all.

    Parameters
    ----------
    request
        The caches, the file and the options `language`, `title`, `frames`, `simplify` and `max_size`.

    Returns
    -------
    list[Path]
        The file.

    Raises
    ------
    RefusedError
        If the viewer was not built or a cache cannot be shown.
    OSError
        If the file cannot be written.
    """
    program = viewer_program()
    arrays = LessonArrays()
    names, procedures = shown_procedures(request, arrays)
    content: dict[str, Any] = {
        **lesson_head(request.options.get("title") or " · ".join(names), request.options.get("language", "en")),
        "procedures": procedures,
    }
    block = LessonBlock(arrays.block(), arrays.size)
    page = lesson_page(content, [block], program).encode()
    check_size(request, len(page))
    write_whole(request.target, page)
    return [request.target]


def lesson_head(title: str, language: str) -> dict[str, Any]:
    """Make what every lesson's content begins with.

    Parameters
    ----------
    title
        The lesson's title.
    language
        Code of the language that it opens in.

    Returns
    -------
    dict[str, Any]
        The beginning, for JSON.
    """
    return {
        "format": FORMAT,
        "version": version(),
        "title": title,
        "language": language,
        "words": lesson_words(),
        "ramp": RAMP,
    }


def shown_procedures(request: ExportRequest, arrays: LessonArrays) -> tuple[list[str], list[dict[str, Any]]]:
    """Write the procedures of a request, which are shown side by side.

    Parameters
    ----------
    request
        The caches and the options `frames` and `simplify`.
    arrays
        Where their arrays go.

    Returns
    -------
    tuple[list[str], list[dict[str, Any]]]
        Their names, and what the viewer knows of them, for JSON.

    Raises
    ------
    RefusedError
        If a cache cannot be shown.
    """
    sources = [exported_cache(path, request.limits) for path in request.caches]
    shown = [exported_frames(source, request) for source in sources]
    sources = [simplified(source, times, request) for source, times in zip(sources, shown, strict=True)]
    names = [path.name.split(".")[0].replace("_", " ") for path in request.caches]
    try:
        scales = quantity_scales(list(zip(sources, shown, strict=True)))
        scenes = [LessonScene.of(source, times) for source, times in zip(sources, shown, strict=True)]
        told = zip(scenes, names, strict=True)
        return names, [lesson_procedure(scene, name, scales, arrays) for scene, name in told]
    except FigureError as error:
        raise refused(ProblemCode.EXPORT_CACHE, request.caches[0], reason=str(error)) from error
