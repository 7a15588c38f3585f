"""`lappet export CACHE.usdc -o lesson.html`: write a lesson."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.core.version import version
from lappet.drawing.quantity_scale import RAMP
from lappet.drawing.skin_source import FigureError
from lappet.export.export_request import ExportRequest
from lappet.export.exported_cache import chosen_frames, exported_cache
from lappet.export.lesson_arrays import LessonArrays
from lappet.export.lesson_page import lesson_page
from lappet.export.lesson_procedure import lesson_procedure
from lappet.export.lesson_skin import quantity_scales
from lappet.export.lesson_words import lesson_words
from lappet.export.viewer_program import viewer_program

FORMAT = 1


def write_lesson(request: ExportRequest) -> list[Path]:
    """Write a lesson of one procedure, or of two side by side; the file appears whole or not at all.

    Parameters
    ----------
    request
        The caches, the file and the options `language`, `title` and `frames`.

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
    frames = request.options.get("frames")
    sources = [exported_cache(path, request.limits) for path in request.caches]
    shown = [chosen_frames(source, None if frames is None else tuple(frames)) for source in sources]
    names = [path.name.split(".")[0].replace("_", " ") for path in request.caches]
    arrays = LessonArrays()
    try:
        scales = quantity_scales(list(zip(sources, shown, strict=True)))
        told = zip(sources, names, shown, strict=True)
        procedures = [lesson_procedure(source, name, times, scales, arrays) for source, name, times in told]
    except FigureError as error:
        raise refused(ProblemCode.EXPORT_CACHE, request.caches[0], reason=str(error)) from error
    content: dict[str, Any] = {
        "format": FORMAT,
        "version": version(),
        "title": request.options.get("title") or " · ".join(names),
        "language": request.options.get("language", "en"),
        "words": lesson_words(),
        "ramp": RAMP,
        "procedures": procedures,
        "size": arrays.size,
    }
    _write(lesson_page(content, arrays.block(), program), request.target)
    return [request.target]


def _write(page: str, path: Path) -> None:
    draft = path.with_name(f".{path.name}.part")
    try:
        draft.write_text(page, encoding="utf-8", newline="\n")
        draft.replace(path)
    finally:
        draft.unlink(missing_ok=True)
