"""A plan says what a lesson holds; all that is wrong with it is said at once, before any work."""

from __future__ import annotations

from pathlib import Path

import pytest

from lappet.core.problem_code import ProblemCode
from lappet.lessons.plan_file import read_plan
from lesson_plans import changed, problems_of

Code = ProblemCode


def test_a_plan_is_read_as_it_is_written(plan_folder: Path) -> None:
    plan = read_plan(plan_folder / "lesson.toml")
    first, second = plan.chapters
    assert (plan.title, plan.language, plan.mastery) == ("Slits <b> & sutures", "en", 60)
    assert first.text == ("A slit is pulled open by hooks.", "It is sutured.")
    assert first.cache == plan_folder / "cache.usdc"
    assert first.questions[0].answers == (1,)
    assert second.questions[0].places == ("landmark right apex",)
    assert second.questions[0].within == 5.0
    assert (second.look, second.view, second.step) == ("tension", "top", 2)


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ("title =", "titel =", Code.LESSON_KEY),
        ("pass = 60", "pass = 160", Code.LESSON_VALUE),
        ('"Once more"', '"The slit"', Code.LESSON_TITLES),
        ('cache = "cache.usdc"', 'cache = "none.usdc"', Code.LESSON_NO_FILE),
        ('cache = "cache.usdc"', "", Code.LESSON_SOURCE),
        ("answer = 2", "", Code.LESSON_ANSWER),
        ("answer = 2", "answer = 4", Code.LESSON_NO_CHOICE),
        ("answer = 2", "answer = 0", Code.LESSON_NO_CHOICE),
        ("answer = 2", "answer = true", Code.LESSON_VALUE),
        ('place = "landmark right apex"', "place = []", Code.LESSON_ANSWER),
        ('place = "landmark right apex"', "", Code.LESSON_KIND),
        ('["hooks", "sutures", "glue"]', '["sutures", "sutures"]', Code.LESSON_CHOICES),
        ('look = "tension"', 'look = "blue"', Code.LESSON_VALUE),
        ("within = 5", "within = -1", Code.LESSON_VALUE),
        ("step = 4", 'step = "last"', Code.LESSON_VALUE),
        ('title = "The end"', "", Code.LESSON_MISSING),
        ('look = "tension"', "spacing = 2", Code.LESSON_SPACING),
    ],
)
def test_what_is_wrong_has_its_place_and_remedy(plan_folder: Path, old: str, new: str, code: ProblemCode) -> None:
    found = problems_of(changed(plan_folder, old, new))
    assert code in [each.code for each in found]
    assert all("plan.toml" in each.prim and each.remedy for each in found)


def test_every_reason_is_said_at_once(plan_folder: Path) -> None:
    text = (plan_folder / "lesson.toml").read_text().replace("answer = 2", "answr = 2").replace("step = 2", "step = 0")
    path = plan_folder / "plan.toml"
    path.write_text(text)
    assert {each.code for each in problems_of(path)} == {Code.LESSON_KEY, Code.LESSON_ANSWER, Code.LESSON_VALUE}


@pytest.mark.parametrize("text", ["title = ", "\x00", 'title = "Nothing"', "chapter = 3\ntitle = 'x'"])
def test_a_file_that_is_no_plan_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "plan.toml"
    path.write_text(text)
    assert problems_of(path)


def test_a_plan_that_is_not_there_is_refused(tmp_path: Path) -> None:
    (found,) = problems_of(tmp_path / "plan.toml")
    assert found.code == Code.LESSON_FILE
    assert "No such file" in found.message
