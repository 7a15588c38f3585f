"""The lesson of the examples is made from them as it stands."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from lappet.lessons.plan_file import read_plan
from lappet.lessons.write_lesson_plan import write_lesson_plan

PLAN = Path(__file__).resolve().parents[2] / "examples" / "lesson" / "lesson.toml"


def test_the_plan_of_the_example_is_right() -> None:
    plan = read_plan(PLAN)
    assert [each.title for each in plan.chapters] == ["Ellipse", "Limberg’s flap", "Z-plasty"]
    assert {bool(question.choices) for chapter in plan.chapters for question in chapter.questions} == {True, False}


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_the_lesson_of_the_example_is_solved_and_written(tmp_path: Path) -> None:
    target = write_lesson_plan(PLAN, tmp_path / "lesson.html")
    assert target.stat().st_size < 4e6
    content = json.loads(target.read_text(encoding="utf-8").split('id="lesson">')[1].split("</script>")[0])
    for chapter in content["chapters"]:
        steps = content["parts"][chapter["part"]]["procedures"][0]["steps"]
        assert len(steps) >= 4
        assert steps[-1]["kind"] == "sutured"
