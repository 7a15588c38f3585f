"""Read the plan of a lesson from TOML, and say all that is wrong with it at once."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

from lappet.core.problem import Problem, RefusedError, refused
from lappet.core.problem_code import ProblemCode
from lappet.lessons.lesson_plan import LOOKS, VIEWS, WITHIN, ChapterPlan, HotspotPlan, LessonPlan, QuestionPlan
from lappet.lessons.plan_table import PlanTable
from lappet.plates.plate_words import LANGUAGES

_MOST_STEPS = 99
_LARGEST = 4_000_000  # bytes of a plan


def read_plan(path: Path) -> LessonPlan:
    """Read a plan.

    Parameters
    ----------
    path
        The file; the caches and procedures in it are found from its folder.

    Returns
    -------
    LessonPlan
        The plan; whether its places are on the tissue is not known yet.

    Raises
    ------
    RefusedError
        If it cannot be read or is wrong: every reason.
    """
    try:
        if path.stat().st_size > _LARGEST:
            raise refused(ProblemCode.LESSON_FILE, path, f"it has more than {_LARGEST} bytes")
        values = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise refused(ProblemCode.LESSON_FILE, path, str(reason).rstrip(".")) from error
    problems: list[Problem] = []
    table = PlanTable(path.name, values, problems)
    title = table.text("title", needed=True)
    language = table.choice("language", LANGUAGES, "en")
    mastery = table.whole("pass", 1, 100)
    tables = table.tables("chapter")
    chapters = tuple(_chapter(each, path.parent) for each in tables)
    table.done()
    if not tables:
        table.told(ProblemCode.LESSON_EMPTY)
    if mastery is not None and not any(each.questions for each in chapters):
        table.told(ProblemCode.LESSON_PASS, mastery)
    _check_titles(tables, chapters)
    if problems:
        raise RefusedError(problems)
    return LessonPlan(path, title, language, mastery, chapters)


def _check_titles(tables: list[PlanTable], chapters: tuple[ChapterPlan, ...]) -> None:
    first: dict[str, int] = {}
    for number, (table, chapter) in enumerate(zip(tables, chapters, strict=True), 1):
        if chapter.title and chapter.title in first:
            table.told(ProblemCode.LESSON_TITLES, chapter.title, first=first[chapter.title])
        first.setdefault(chapter.title, number)


def _chapter(table: PlanTable, folder: Path) -> ChapterPlan:
    title = table.text("title", needed=True)
    cache, procedure = (_file(table, key, folder) for key in ("cache", "procedure"))
    if (table.has("cache")) == (table.has("procedure")):
        table.told(ProblemCode.LESSON_SOURCE, "both" if cache else "neither")
    spacing = table.number("spacing", 0.0)
    if spacing is not None and table.has("cache"):
        table.told(ProblemCode.LESSON_SPACING, f"{spacing:g}")
    chapter = ChapterPlan(
        where=table.where,
        title=title,
        cache=cache,
        procedure=procedure,
        spacing=spacing,
        text=_paragraphs(table),
        frames=table.numbers("frames"),
        look=table.choice("look", LOOKS, "painted"),
        view=table.choice("view", VIEWS, "oblique"),
        step=table.whole("step", 1, _MOST_STEPS) or 1,
        hotspots=tuple(_hotspot(each) for each in table.tables("hotspot")),
        questions=tuple(_question(each) for each in table.tables("question")),
    )
    table.done()
    return chapter


def _file(table: PlanTable, key: str, folder: Path) -> Path | None:
    given = table.text(key)
    if not given:
        return None
    path = folder / given
    if not path.is_file():
        table.told(ProblemCode.LESSON_NO_FILE, given, path=path.absolute())
    return path


def _paragraphs(table: PlanTable) -> tuple[str, ...]:
    whole = "\n\n".join(table.texts("text"))
    return tuple(" ".join(each.split()) for each in re.split(r"\n\s*\n", whole) if each.strip())


def _hotspot(table: PlanTable) -> HotspotPlan:
    place, title, text = table.text("place", needed=True), table.text("title", needed=True), table.text("text")
    table.done()
    return HotspotPlan(table.where, place, title, text)


def _question(table: PlanTable) -> QuestionPlan:
    ask = table.text("ask", needed=True)
    choices, (answers, several) = table.texts("choices"), table.whole_numbers("answer")
    places, candidates = table.texts("place"), table.texts("candidates")
    by_choice, on_model = table.has("choices"), table.has("place")
    within = table.number("within", 0.0, 100.0)
    question = QuestionPlan(
        where=table.where,
        ask=ask,
        choices=choices,
        answers=tuple(each - 1 for each in answers),
        several=several,
        places=places,
        candidates=candidates,
        within=WITHIN if within is None else within,
        right=table.text("right"),
        wrong=table.text("wrong"),
        step=table.whole("step", 1, _MOST_STEPS),
    )
    table.done()
    if by_choice == on_model:
        table.told(ProblemCode.LESSON_KIND, "both" if by_choice else "neither")
    elif by_choice:
        _check_choices(table, question)
    elif not places:
        table.told(ProblemCode.LESSON_ANSWER, ask)
    return question


def _check_choices(table: PlanTable, question: QuestionPlan) -> None:
    count = len(question.choices)
    if count < 2 or len(set(question.choices)) < count:
        table.told(ProblemCode.LESSON_CHOICES, count)
    if not question.answers:
        table.told(ProblemCode.LESSON_ANSWER, question.ask)
    for index in question.answers:
        if not 0 <= index < count:
            table.told(ProblemCode.LESSON_NO_CHOICE, index + 1, count=count)
