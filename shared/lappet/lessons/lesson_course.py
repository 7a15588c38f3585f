"""What a browser is told of a lesson of several procedures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from lappet.export.lesson_arrays import LessonArrays
from lappet.export.lesson_file import lesson_head
from lappet.export.lesson_page import LessonBlock
from lappet.export.lesson_procedure import lesson_procedure
from lappet.lessons.lesson_places import LessonPlace
from lappet.lessons.lesson_plan import HotspotPlan, LessonPlan, QuestionPlan
from lappet.lessons.plan_check import offered
from lappet.lessons.plan_sources import ChapterSource


def lesson_course(plan: LessonPlan, sources: Sequence[ChapterSource]) -> tuple[dict[str, Any], list[LessonBlock]]:
    """Make the content of a lesson.

    Parameters
    ----------
    plan
        Its plan.
    sources
        The solved procedure of each chapter; those that several chapters share are written once.

    Returns
    -------
    tuple[dict[str, Any], list[LessonBlock]]
        The content for JSON, and the blocks of arrays that its parts name by their index.
    """
    parts: dict[int, int] = {}
    blocks: list[LessonBlock] = []
    procedures: list[list[dict[str, Any]]] = []
    chapters = []
    for source in sources:
        key = id(source.shown)
        if key not in parts:
            parts[key] = len(blocks)
            arrays = LessonArrays()
            procedures.append([lesson_procedure(source.shown, source.plan.title, source.scales, arrays)])
            blocks.append(LessonBlock(arrays.block(), arrays.size))
        chapters.append(_chapter(source, parts[key]))
    content = {
        **lesson_head(plan.title, plan.language),
        "mastery": plan.mastery,
        "parts": [{"procedures": each} for each in procedures],
        "chapters": chapters,
    }
    return content, blocks


def _chapter(source: ChapterSource, part: int) -> dict[str, Any]:
    plan = source.plan
    return {
        "title": plan.title,
        "text": plan.text,
        "part": part,
        "look": plan.look,
        "view": plan.view,
        "step": plan.step - 1,
        "hotspots": [_hotspot(each, source) for each in plan.hotspots],
        "questions": [_question(each, source) for each in plan.questions],
    }


def _hotspot(plan: HotspotPlan, source: ChapterSource) -> dict[str, Any]:
    return {"title": plan.title, "text": plan.text, "places": _found(source, plan.place).told()}


def _question(plan: QuestionPlan, source: ChapterSource) -> dict[str, Any]:
    step = source.plan.step if plan.step is None else plan.step
    told: dict[str, Any] = {
        "ask": plan.ask,
        "step": step - 1,
        "right": plan.right,
        "wrong": plan.wrong,
    }
    if plan.choices:
        return {**told, "choices": plan.choices, "answers": plan.answers, "several": plan.several}
    right = [str(_found(source, name)) for name in plan.places]
    every = offered(plan, source.places, step)
    every += [place for name in right if (place := _found(source, name)) not in every]
    candidates = [
        {"kind": each.kind, "name": each.name, "right": str(each) in right, "places": each.told()} for each in every
    ]
    return {**told, "within": plan.within, "candidates": candidates}


def _found(source: ChapterSource, name: str) -> LessonPlace:
    place = source.places.find(name)
    assert place is not None  # or the plan was refused
    return place
