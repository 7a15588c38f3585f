"""The plan of a lesson as values: chapters with text, hotspots and questions."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

LOOKS = ("painted", "grid", "tension", "strain", "stress")
VIEWS = ("oblique", "top", "low", "behind")
WITHIN = 6.0  # mm from a place at which a click counts, where the plan says nothing


@dataclass(frozen=True)
class HotspotPlan:
    """A numbered mark on the tissue, with a text.

    Parameters
    ----------
    where
        Where it stands in the plan, for problems.
    place
        The place that it marks, such as "corner a".
    title
        Its heading.
    text
        Its text.
    """

    where: str
    place: str
    title: str
    text: str


@dataclass(frozen=True)
class QuestionPlan:
    """A question, answered by choice or by a click on the tissue.

    Parameters
    ----------
    where
        Where it stands in the plan, for problems.
    ask
        The question.
    choices
        What one may choose; empty where the question is answered on the tissue.
    answers
        Indices of the right choices.
    several
        Whether several choices are ticked, all right ones and no other.
    places
        The right places on the tissue, each such as "suture stitch_1"; empty where the question has choices.
    candidates
        The places that are offered as a list; empty for all of the kinds of the right ones.
    within
        Distance from a right place in mm within which a click is right.
    right, wrong
        What is said of a right and of a wrong answer.
    step
        Number of the step that is shown when it is asked, from 1 on, or None.
    """

    where: str
    ask: str
    choices: tuple[str, ...]
    answers: tuple[int, ...]
    several: bool
    places: tuple[str, ...]
    candidates: tuple[str, ...]
    within: float
    right: str
    wrong: str
    step: int | None


@dataclass(frozen=True)
class ChapterPlan:
    """A procedure of the lesson, with what is said and asked about it.

    Parameters
    ----------
    where
        Where it stands in the plan, for problems.
    title
        Its title, of which there is only one in a lesson.
    cache
        The skin cache, or None where a procedure is solved.
    procedure
        The procedure to solve, or None where there is a cache.
    spacing
        Spacing of the lattice in mm with which it is solved, or None for the procedure's.
    text
        Paragraphs.
    frames
        Time codes of the frames that are shown, or None for all.
    look, view
        How the tissue looks and from where it is seen at first.
    step
        Number of the step that is shown at first, from 1 on.
    hotspots, questions
        What is marked and asked.
    """

    where: str
    title: str
    cache: Path | None
    procedure: Path | None
    spacing: float | None
    text: tuple[str, ...]
    frames: tuple[float, ...] | None
    look: str
    view: str
    step: int
    hotspots: tuple[HotspotPlan, ...]
    questions: tuple[QuestionPlan, ...]


@dataclass(frozen=True)
class LessonPlan:
    """A lesson of several procedures.

    Parameters
    ----------
    path
        The file of the plan.
    title
        The lesson's title.
    language
        Code of the language that it opens in.
    mastery
        Percentage of questions that must be answered rightly at the first try to pass, or None where nobody fails.
    chapters
        The chapters, at least one.
    """

    path: Path
    title: str
    language: str
    mastery: int | None
    chapters: tuple[ChapterPlan, ...]
