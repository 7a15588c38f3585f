"""A lesson as a site: its pages, its index in a browser, and folders that it leaves alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from lappet.core.problem import RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.drawing.skin_read import SkinCache
from lappet.export.lesson_procedure import LessonScene
from lappet.lessons.chapter_picture import SIZE, chapter_picture
from lappet.lessons.plan_file import read_plan
from lappet.lessons.write_lesson_plan import write_lesson_plan
from lesson_browser import opened

ATLAS = Path(__file__).resolve().parents[2] / "examples" / "lesson" / "atlas.toml"


def test_the_atlas_has_every_example() -> None:
    plan = read_plan(ATLAS)
    found = {each.procedure.resolve().parent.name for each in plan.chapters if each.procedure}
    examples = {path.parent.name for path in ATLAS.parent.parent.glob("*/*.usda")}
    assert found == examples
    assert len(plan.chapters) == 12


def test_a_picture_of_a_chapter_shows_skin_and_the_open_wound(plan_folder: Path) -> None:
    source = SkinCache(plan_folder / "cache.usdc")
    shown = LessonScene.of(source, source.frames)
    whole, open_ = (chapter_picture(shown, time).astype(int) for time in (1.0, 7.0))
    assert whole.shape == (SIZE[1], SIZE[0], 3)
    middle = np.s_[130:170, 200:280]
    assert whole[middle][..., 0].mean() > whole[middle][..., 2].mean() + 30
    assert (np.abs(whole - open_).max(axis=2) > 30)[middle].mean() > 0.1


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_a_site_has_a_page_for_each_chapter_and_an_index_without_a_fault(plan_folder: Path) -> None:
    site = plan_folder / "site"
    write_lesson_plan(plan_folder / "lesson.toml", site)
    assert sorted(each.name for each in site.iterdir()) == ["01_the_slit.html", "02_once_more.html", "index.html"]
    write_lesson_plan(plan_folder / "lesson.toml", site)  # in place of the first
    links = "Array.from(document.querySelectorAll('a'), (each) => each.getAttribute('href'))"
    drawn = "Array.from(document.images, (each) => each.naturalWidth)"
    first = "li:first-child a"
    done = opened(
        site / "index.html",
        *(
            ("evaluate", links),
            ("evaluate", drawn),
            ("axe", None),
            ("click", first),
            ("ready", None),
            ("text", "h1"),
        ),
    )
    assert done.results[0] == ["01_the_slit.html", "02_once_more.html"]
    assert done.results[1] == [SIZE[0]] * 2
    assert done.results[2] == []
    assert done.results[-1] == "The slit"
    assert [each for each in done.requests if not each.startswith(("file:", "blob:", "data:"))] == []


def test_a_folder_that_holds_something_else_is_left_alone(plan_folder: Path, tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "letter.txt").write_text("dear", encoding="utf-8")
    (tmp_path / "file").write_text("dear", encoding="utf-8")
    for name in ("mine", "file"):
        with pytest.raises(RefusedError) as refused:
            write_lesson_plan(plan_folder / "lesson.toml", tmp_path / name)
        assert [each.code for each in refused.value.problems] == [ProblemCode.LESSON_SITE]
    assert (tmp_path / "mine" / "letter.txt").read_text(encoding="utf-8") == "dear"
