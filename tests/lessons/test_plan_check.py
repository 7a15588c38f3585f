"""A plan is compared with its caches before anything is written: places, steps, frames and maps must be there."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import numpy as np
import pytest

import synthetic_skin_cache as synthetic
from lappet.core.problem import Problem, RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.drawing.skin_read import SkinCache
from lappet.export.lesson_procedure import LessonScene
from lappet.lessons.lesson_places import LessonPlaces
from lappet.lessons.plan_template import plan_template
from lappet.lessons.write_lesson_plan import write_lesson_plan
from lappet.usd.stage import write_procedure
from lesson_plans import changed
from lesson_reader import ReadLesson
from small_procedure import small_procedure

Code = ProblemCode


@pytest.fixture(scope="module")
def places(plan_folder: Path) -> LessonPlaces:
    source = SkinCache(plan_folder / "cache.usdc")
    return LessonPlaces(LessonScene.of(source, source.frames))


def refusal(plan: Path, **options: object) -> list[Problem]:
    target = plan.with_name("refused.html")
    with pytest.raises(RefusedError) as refused:
        write_lesson_plan(plan, target, **options)  # type: ignore[arg-type]
    assert not target.exists()
    return list(refused.value.problems)


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ('"landmark left apex"', '"landmark top"', Code.LESSON_PLACE),
        ('"landmark right apex"', '"corner q"', Code.LESSON_PLACE),
        ("within = 5", 'candidates = ["landmark left apex"]', Code.LESSON_CANDIDATES),
        ("step = 4", "step = 5", Code.LESSON_STEP),
        ('look = "tension"', "frames = [1, 99]", Code.LESSON_FRAME),
    ],
)
def test_what_a_cache_does_not_have_is_refused(plan_folder: Path, old: str, new: str, code: ProblemCode) -> None:
    (found,) = refusal(changed(plan_folder, old, new))
    assert found.code == code
    assert found.prim.startswith("plan.toml, chapter ")
    assert found.remedy


def test_a_remedy_names_the_places_that_there_are(plan_folder: Path) -> None:
    (found,) = refusal(changed(plan_folder, '"landmark left apex"', '"landmark top"'))
    assert "landmark left apex, landmark right apex" in found.remedy


def test_nothing_is_solved_for_a_plan_that_is_wrong(plan_folder: Path) -> None:
    plan = changed(plan_folder, '"landmark left apex"', '"landmark top"')
    solved = '\n[[chapter]]\ntitle = "Solved"\nprocedure = "procedure.usda"\n'
    plan.write_text(plan.read_text() + solved)

    def solve(*_: object) -> None:
        raise AssertionError

    (found,) = refusal(plan, solve=solve)
    assert found.code == Code.LESSON_PLACE


def test_places_that_a_procedure_does_not_name_are_refused_before_it_is_solved(tmp_path: Path) -> None:
    write_procedure(small_procedure(), tmp_path / "procedure.usda")
    chapter = 'title = "One"\n[[chapter]]\ntitle = "One"\nprocedure = "procedure.usda"\n'
    marks = "".join(
        f'[[chapter.hotspot]]\nplace = "{place}"\ntitle = "T"\ntext = "t"\n'
        for place in ("hook nowhere", "suture stitch", "landmark top", "landmark corner", "corner a")
    )
    plan = tmp_path / "lesson.toml"
    plan.write_text(chapter + marks, encoding="utf-8")

    def solve(*_: object) -> None:
        raise AssertionError

    found = refusal(plan, solve=solve)
    assert {each.code for each in found} == {Code.LESSON_PLACE}
    assert {each.value for each in found} == {"hook nowhere", "landmark top"}
    assert "corner a" in found[0].remedy


def test_a_procedure_is_solved_with_its_spacing(plan_folder: Path, tmp_path: Path) -> None:
    asked = []
    coarse = synthetic.write_cache(tmp_path, step=8.0)

    def solve(procedure: Path, cache: Path, spacing: float | None) -> None:
        asked.append((procedure.name, spacing))
        (cache.parent / "procedure.usda").write_bytes((tmp_path / "procedure.usda").read_bytes())
        cache.write_bytes(coarse.read_bytes())

    plan = plan_folder / "solved.toml"
    plan.write_text('title = "One"\n[[chapter]]\ntitle = "One"\nprocedure = "procedure.usda"\nspacing = 2\n')
    target = write_lesson_plan(plan, plan.with_suffix(".html"), solve=solve)
    assert asked == [("procedure.usda", 2.0)]
    assert '"chapters":[{"title":"One"' in target.read_text(encoding="utf-8")


def test_a_suffix_that_is_not_known_is_refused(plan_folder: Path) -> None:
    with pytest.raises(RefusedError) as refused:
        write_lesson_plan(plan_folder / "lesson.toml", plan_folder / "lesson.pdf")
    assert [each.code for each in refused.value.problems] == [Code.LESSON_SUFFIX]


def test_places_are_where_the_cache_has_them(places: LessonPlaces, plan_folder: Path) -> None:
    source = SkinCache(plan_folder / "cache.usdc")
    landmark, suture = places.find("landmark right apex"), places.find("suture suture_2")
    assert landmark is not None
    assert suture is not None
    for index, time in enumerate(source.frames):
        np.testing.assert_allclose(landmark.at(index), source.named_landmarks(time)["right apex"], atol=2e-3)
    for index, time in enumerate(source.frames):
        ends = np.array([[synthetic.SUTURES[1], side, 0.0] for side in (-0.5, 0.5)])
        slit = time >= synthetic.INCISED
        truth = synthetic.deform(ends, time, slit).mean(axis=0)
        assert np.linalg.norm(suture.at(index) - truth) < 1.0  # the patch is drawn by triangles of 4 mm


def test_places_of_every_kind_have_their_names(places: LessonPlaces) -> None:
    kinds = [place.kind for place in places]
    assert {kind: kinds.count(kind) for kind in set(kinds)} == {"corner": 2, "landmark": 2, "suture": 4, "hook": 2}
    assert places.find("Corner  a") is places.find("corner a")
    assert places.find("corner z") is None


def test_a_template_is_a_lesson_as_it_stands(plan_folder: Path) -> None:
    plan = plan_folder / "template.toml"
    caches = [plan_folder / "cache.usdc"] * 2
    plan.write_text(plan_template(caches, plan), encoding="utf-8")
    assert [each["title"] for each in tomllib.loads(plan.read_text())["chapter"]] == ["Cache", "Cache 2"]
    written = write_lesson_plan(plan, plan_folder / "template.html")
    assert "Which step comes last?" in written.read_text()


def test_chapters_of_one_procedure_share_its_arrays(course_file: Path) -> None:
    page = course_file.read_text(encoding="utf-8")
    content = json.loads(page.split('id="lesson">')[1].split("</script>")[0])
    assert [each["part"] for each in content["chapters"]] == [0, 0]
    assert len(content["parts"]) == page.count('<script type="text/plain"') == 1
    (question,) = content["chapters"][1]["questions"]
    assert {each["name"]: each["right"] for each in question["candidates"]} == {"left apex": False, "right apex": True}


def test_the_lesson_of_one_procedure_stays_as_it_was(plan_folder: Path, tmp_path: Path) -> None:
    from lappet.export.export_request import ExportRequest
    from lappet.export.formats import export

    target = tmp_path / "one.html"
    export(ExportRequest((plan_folder / "cache.usdc",), target))
    content = ReadLesson.of(target).content
    assert "chapters" not in content
    assert len(content["procedures"]) == 1
