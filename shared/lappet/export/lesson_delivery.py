"""How a lesson reaches a class: as a page, or in a package for a learning platform to which it reports."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from lappet.core.durable import write_whole
from lappet.export.export_request import ExportRequest
from lappet.export.h5p_package import h5p_package
from lappet.export.lesson_arrays import LessonArrays
from lappet.export.lesson_file import lesson_head, shown_procedures
from lappet.export.lesson_page import LessonBlock, lesson_page
from lappet.export.scorm_package import scorm_package
from lappet.export.size_limit import check_size
from lappet.export.viewer_program import viewer_program

DELIVERIES = (".html", ".zip", ".h5p")


def delivered(content: dict[str, Any], blocks: Sequence[LessonBlock], suffix: str) -> bytes:
    """Make the file of a lesson.

    Parameters
    ----------
    content
        What the viewer knows of it.
    blocks
        Its arrays.
    suffix
        One of `DELIVERIES`: a page, a package of SCORM 1.2, or one of H5P.

    Returns
    -------
    bytes
        The file.

    Raises
    ------
    RefusedError
        If the viewer was not built.
    """
    program = viewer_program()
    title = content["title"]
    if suffix == ".zip":
        page = lesson_page({**content, "reports": "scorm"}, blocks, program)
        return scorm_package(page, title, content["mastery"])
    if suffix == ".h5p":
        return h5p_package(lesson_page({**content, "reports": "h5p"}, blocks, program), title, content["language"])
    return lesson_page(content, blocks, program).encode("utf-8")


def write_package(request: ExportRequest) -> list[Path]:
    """Write a lesson of one procedure, or of two side by side, as a package that reports the steps that were seen.

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
    viewer_program()
    arrays = LessonArrays()
    names, procedures = shown_procedures(request, arrays)
    title = request.options.get("title") or " · ".join(names)
    chapter: dict[str, Any] = {"title": title, "text": [], "part": 0, "look": "grid", "view": "oblique", "step": 0}
    content = {
        **lesson_head(title, request.options.get("language", "en")),
        "mastery": None,
        "parts": [{"procedures": procedures}],
        "chapters": [{**chapter, "hotspots": [], "questions": []}],
    }
    blocks = [LessonBlock(arrays.block(), arrays.size)]
    package = delivered(content, blocks, request.target.suffix.lower())
    check_size(request, len(package))
    write_whole(request.target, package)
    return [request.target]
