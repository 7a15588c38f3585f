"""Check a chapter against its solved procedure: places, steps and maps that the plan names must be there."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.export.lesson_procedure import LessonScene
from lappet.lessons.lesson_places import LessonPlace, LessonPlaces
from lappet.lessons.lesson_plan import ChapterPlan, QuestionPlan
from lappet.procedure import Hook, Landmark, Procedure, Suture, SutureRun

_PLAIN = ("painted", "grid")
_LISTED = 30  # names in a remedy
_OFFERED = 8  # places in a list, where the plan has none


def chapter_problems(
    chapter: ChapterPlan, shown: LessonScene, places: LessonPlaces, scales: Mapping[str, Any]
) -> list[Problem]:
    """Find what of a chapter does not fit its procedure.

    Parameters
    ----------
    chapter
        The chapter.
    shown
        Its procedure.
    places
        The procedure's places.
    scales
        The maps that its cache holds.

    Returns
    -------
    list[Problem]
        The problems.
    """
    found = _step_problems(chapter.where, chapter.step, shown)
    if chapter.look not in (*_PLAIN, *scales):
        known = ", ".join([*_PLAIN, *scales])
        found.append(problem(ProblemCode.LESSON_LOOK, chapter.where, chapter.look, known=known))
    for hotspot in chapter.hotspots:
        found += _place_problems(hotspot.where, [hotspot.place], places)
    for question in chapter.questions:
        found += _question_problems(question, chapter.step, shown, places)
    return found


def named_place_problems(chapter: ChapterPlan, procedure: Procedure) -> list[Problem]:
    """Find places that a procedure cannot have, by the names of its events, before it is solved.

    Corners of cuts have their letters only once the skin is drawn; they are found later.

    Parameters
    ----------
    chapter
        The chapter.
    procedure
        Its procedure.

    Returns
    -------
    list[Problem]
        The problems.
    """
    known = [f"landmark {each.label}" for each in procedure.events if isinstance(each, Landmark)]
    known += [f"hook {each.name}" for each in procedure.events if isinstance(each, Hook)]
    known += [f"suture {each.name}" for each in procedure.events if isinstance(each, Suture)]
    runs = tuple(f"suture {each.name}/" for each in procedure.events if isinstance(each, SutureRun))
    wanted = [(each.where, each.place) for each in chapter.hotspots]
    wanted += [(each.where, name) for each in chapter.questions for name in (*each.places, *each.candidates)]
    found = []
    for where, name in dict.fromkeys(wanted):
        kind, _, rest = name.partition(" ")
        place = f"{kind.lower()} {rest.strip()}"
        if kind.lower() == "corner" or place in known or (runs and place.startswith(runs)):
            continue
        listed = _listed([*known, *(f"{each}1" for each in runs), "corner a …"])
        found.append(problem(ProblemCode.LESSON_PLACE, where, name, known=listed))
    return found


def offered(question: QuestionPlan, places: LessonPlaces, step: int) -> list[LessonPlace]:
    """List the places that a question offers.

    Parameters
    ----------
    question
        The question.
    places
        The procedure's places.
    step
        Number of the step at which it is asked.

    Returns
    -------
    list[LessonPlace]
        The candidates of the plan; else the right ones and, up to eight in all, others of their kinds that lie far
        from each other.
    """
    if question.candidates:
        return [place for name in question.candidates if (place := places.find(name))]
    right = [place for name in question.places if (place := places.find(name))]
    frame, kinds = places.frame(step), {place.kind for place in right}
    others = [place for place in places.at_step(step) if place.kind in kinds and place not in right]
    chosen = set(
        _apart([_there(each, frame) for each in right], [_there(each, frame) for each in others], question.within)
    )
    listed = [*right, *(place for k, place in enumerate(others) if k in chosen)]
    return sorted(listed, key=list(places).index)


def _there(place: LessonPlace, frame: int) -> NDArray[np.float64]:
    found = place.at(frame)
    assert found is not None  # only those that are there are offered
    return found


def _apart(right: list[NDArray[np.float64]], others: list[NDArray[np.float64]], within: float) -> list[int]:
    """Indices of the others that are offered: one by one the farthest from all that are, while it is far enough."""
    chosen: list[int] = []
    taken = list(right)
    while taken and others and len(taken) < max(_OFFERED, len(right)):
        far = [min(float(np.linalg.norm(other - each)) for each in taken) for other in others]
        best = int(np.argmax(far))
        if far[best] <= within:
            break
        chosen.append(best)
        taken.append(others[best])
    return chosen


def _question_problems(question: QuestionPlan, step: int, shown: LessonScene, places: LessonPlaces) -> list[Problem]:
    asked = step if question.step is None else question.step
    found = _step_problems(question.where, asked, shown)
    found += _place_problems(question.where, [*question.places, *question.candidates], places)
    if found or not question.places:
        return found
    there = {str(place) for place in places.at_step(asked)}
    kinds = {place.split(" ")[0] for place in question.places}
    for name in (*question.places, *question.candidates):
        place = places.find(name)
        if str(place) not in there:
            known = _listed(each for each in sorted(there) if each.split(" ")[0] in kinds)
            gone = ProblemCode.LESSON_PLACE_GONE
            found.append(problem(gone, question.where, name, step=asked, known=known))
    if question.candidates and not found:
        listed = {str(places.find(name)) for name in question.candidates}
        for name in question.places:
            if str(places.find(name)) not in listed:
                found.append(problem(ProblemCode.LESSON_CANDIDATES, question.where, name))
    return found


def _place_problems(where: str, names: Iterable[str], places: LessonPlaces) -> list[Problem]:
    known = _listed(str(place) for place in places)
    missing = dict.fromkeys(name for name in names if places.find(name) is None)
    return [problem(ProblemCode.LESSON_PLACE, where, name, known=known) for name in missing]


def _step_problems(where: str, step: int, shown: LessonScene) -> list[Problem]:
    count = len(shown.steps)
    if step <= max(1, count):
        return []
    known = ", ".join(f"{k} {each.kind}" for k, each in enumerate(shown.steps, 1))
    return [problem(ProblemCode.LESSON_STEP, where, step, known=known, count=count)]


def _listed(names: Iterable[str]) -> str:
    every = list(names)
    more = f" and {len(every) - _LISTED} more" if len(every) > _LISTED else ""
    return ", ".join(every[:_LISTED]) + more or "none"
