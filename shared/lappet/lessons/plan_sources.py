"""The solved procedures of a plan: caches are opened, procedures are solved, and every chapter is checked."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from lappet.core.problem import Problem, ProblemsError, RefusedError, problem
from lappet.core.problem_code import ProblemCode
from lappet.drawing.skin_read import SkinCache
from lappet.drawing.skin_source import FigureError
from lappet.export.exported_cache import exported_cache
from lappet.export.lesson_procedure import LessonScene
from lappet.export.lesson_skin import quantity_scales
from lappet.foreign.limits import DEFAULT_LIMITS, ReadLimits
from lappet.lessons.lesson_places import LessonPlaces
from lappet.lessons.lesson_plan import ChapterPlan, LessonPlan
from lappet.lessons.plan_check import chapter_problems, named_place_problems
from lappet.output.solve_to_cache import solve_procedure
from lappet.program.settings import SolverSettings
from lappet.usd.procedure_file import ProcedureFile

# Solves a procedure with a spacing (None for its own) into a cache.
SolveChapter = Callable[[Path, Path, float | None], None]


@dataclass(frozen=True, eq=False)
class ChapterSource:
    """The solved procedure of a chapter.

    Parameters
    ----------
    plan
        The chapter.
    shown
        The procedure and its frames.
    places
        Its places.
    scales
        The color scales of its maps.
    """

    plan: ChapterPlan
    shown: LessonScene
    places: LessonPlaces
    scales: dict[str, dict[str, Any]]


def solve_chapter(procedure: Path, cache: Path, spacing: float | None) -> None:
    """Solve the procedure of a chapter; frames that the user's store knows are looked up.

    Parameters
    ----------
    procedure
        The procedure.
    cache
        The skin cache to write.
    spacing
        Spacing of the lattice in mm, None for the procedure's.

    Raises
    ------
    RefusedError
        If it cannot be solved to its end.
    """
    settings = SolverSettings() if spacing is None else SolverSettings(spacing=spacing)
    result = solve_procedure(procedure, cache, settings, error_estimate=False)
    if not result.complete:
        why = [result.reason] if result.reason else [problem(ProblemCode.LESSON_UNSOLVED, procedure, reason="stopped.")]
        raise RefusedError(why)


def chapter_sources(
    plan: LessonPlan,
    work: Path,
    limits: ReadLimits = DEFAULT_LIMITS,
    solve: SolveChapter = solve_chapter,
    say: Callable[[str], None] = lambda _: None,
) -> list[ChapterSource]:
    """Open, or solve, what the chapters show, and check the chapters against it; caches before anything is solved.

    Parameters
    ----------
    plan
        The plan.
    work
        Folder for what is solved; it must stay while the sources are used.
    limits
        What reading may take.
    solve
        Solves a procedure.
    say
        Is told what is being solved.

    Returns
    -------
    list[ChapterSource]
        A source for each chapter.

    Raises
    ------
    RefusedError
        If a cache cannot be read, a procedure cannot be solved, or a chapter does not fit: every reason.
    """
    found: dict[int, ChapterSource] = {}
    opened: dict[Any, LessonScene] = {}
    order = sorted(range(len(plan.chapters)), key=lambda k: plan.chapters[k].cache is None)
    problems: list[Problem] = []
    for chapter in plan.chapters:
        if chapter.procedure is not None:
            problems += _named_problems(chapter, limits)
    for number in order:
        chapter = plan.chapters[number]
        if problems and chapter.cache is None:
            break  # nothing is solved for a plan that is wrong
        try:
            key = (chapter.cache or chapter.procedure, chapter.spacing, chapter.frames)
            if key not in opened:
                opened[key] = _scene(chapter, number, work, limits, solve, say)
            found[number] = _checked(chapter, opened[key], problems)
        except ProblemsError as error:
            problems += [_at(chapter, each) for each in error.problems]
        except FigureError as error:
            problems.append(problem(ProblemCode.EXPORT_CACHE, chapter.where, reason=str(error)))
    if problems:
        raise RefusedError(problems)
    return [found[number] for number in range(len(plan.chapters))]


def _named_problems(chapter: ChapterPlan, limits: ReadLimits) -> list[Problem]:
    """What is wrong with a chapter by its procedure alone; what is wrong with the procedure, solving tells."""
    assert chapter.procedure is not None  # only chapters that are solved are asked
    try:
        with ProcedureFile(chapter.procedure, limits) as file:
            read = file.what_can_be()
    except RefusedError:
        return []
    if read.procedure is None or read.problems:
        return []
    return named_place_problems(chapter, read.procedure)


def _scene(
    chapter: ChapterPlan,
    number: int,
    work: Path,
    limits: ReadLimits,
    solve: SolveChapter,
    say: Callable[[str], None],
) -> LessonScene:
    path = chapter.cache
    if path is None:
        assert chapter.procedure is not None  # a chapter has one of the two
        path = work / f"chapter_{number + 1}.usdc"
        say(f"Solving {chapter.procedure}")
        solve(chapter.procedure, path, chapter.spacing)
        limits = replace(limits, allow_external=True)  # the cache is Lappet's own, over the procedure in its folder
    source = exported_cache(path, limits)
    return LessonScene.of(source, _frames(chapter, source))


def _frames(chapter: ChapterPlan, source: SkinCache) -> tuple[float, ...]:
    if chapter.frames is None:
        return source.frames
    first, last = source.frames[0], source.frames[-1]
    missing = [each for each in chapter.frames if each not in source.frames]
    if missing:
        code = ProblemCode.LESSON_FRAME
        raise RefusedError([problem(code, chapter.where, f"{each:g}", first=first, last=last) for each in missing])
    return tuple(sorted(set(chapter.frames)))


def _checked(chapter: ChapterPlan, shown: LessonScene, problems: list[Problem]) -> ChapterSource:
    scales = quantity_scales([(shown.source, shown.frames)])
    places = LessonPlaces(shown)
    problems += chapter_problems(chapter, shown, places, scales)
    return ChapterSource(chapter, shown, places, scales)


def _at(chapter: ChapterPlan, found: Problem) -> Problem:
    """A problem of a chapter's file, with the chapter before its place."""
    return found if found.prim.startswith(chapter.where) else replace(found, prim=f"{chapter.where}: {found.prim}")
