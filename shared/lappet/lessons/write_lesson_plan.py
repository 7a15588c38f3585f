"""`lappet lesson`: write a lesson of several procedures."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path

from lappet.core.durable import write_whole
from lappet.core.output_place import check_place
from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.export.lesson_delivery import DELIVERIES, delivered
from lappet.export.viewer_program import viewer_program
from lappet.foreign.limits import DEFAULT_LIMITS, ReadLimits
from lappet.lessons.lesson_course import lesson_course
from lappet.lessons.lesson_site import check_site, is_site, write_site
from lappet.lessons.plan_file import read_plan
from lappet.lessons.plan_sources import SolveChapter, chapter_sources, solve_chapter


def write_lesson_plan(
    plan: Path,
    target: Path,
    limits: ReadLimits = DEFAULT_LIMITS,
    solve: SolveChapter = solve_chapter,
    say: Callable[[str], None] = lambda _: None,
) -> Path:
    """Write the lesson of a plan; the file appears whole or not at all.

    Parameters
    ----------
    plan
        The plan, in TOML.
    target
        The file; its suffix says what it becomes: a page, a package of SCORM 1.2 or one of H5P. Without a suffix it
        is a folder with a page for each chapter.
    limits
        What reading may take.
    solve
        Solves the procedures of chapters that have no cache.
    say
        Is told what is being solved.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    RefusedError
        If the suffix is unknown, the place cannot be written, or the plan, a cache or a procedure is wrong: every
        reason.
    OSError
        If the file cannot be written.
    """
    suffix = target.suffix.lower()
    if not is_site(target) and suffix not in DELIVERIES:
        raise refused(ProblemCode.LESSON_SUFFIX, target, target.suffix, known=", ".join(DELIVERIES))
    if is_site(target):
        check_site(target)
    check_place(target)
    viewer_program()
    known = read_plan(plan)
    with tempfile.TemporaryDirectory(prefix="lappet-lesson-") as work:
        sources = chapter_sources(known, Path(work), limits, solve, say)
        if is_site(target):
            write_site(known, sources, target)
            return target
        content, blocks = lesson_course(known, sources)
        write_whole(target, delivered(content, blocks, suffix))
    return target
