"""A lesson of several procedures in Chromium without a network: chapters, hotspots, questions, what is kept of them."""

from __future__ import annotations

from pathlib import Path

import pytest

from lappet.drawing.skin_read import SkinCache
from lappet.export.lesson_procedure import LessonScene
from lappet.lessons.lesson_places import LessonPlaces
from lesson_browser import opened

pytestmark = [pytest.mark.slow, pytest.mark.timeout(600)]
READY = ("ready", None)
STANDING = ("evaluate", "lappetLesson.standing()")
SECOND = ("until", "lappetLesson.chapter() === 1 && lappetLesson.resting()")


def at(script: str) -> tuple[str, str]:
    return "evaluate", script


def test_it_opens_with_its_first_chapter_and_asks_for_nothing(course_file: Path) -> None:
    texts = at("[...document.querySelectorAll('#chapter .text')].map((each) => each.textContent)")
    done = opened(course_file, READY, ("text", "h1"), ("text", "#chapter-title"), texts, ("count", "#chapters li"))
    assert done.results[1:] == [
        "Slits <b> & sutures",
        "The slit",
        ["A slit is pulled open by hooks.", "It is sutured."],
        2,
    ]
    assert done.console == []
    assert [each for each in done.requests if not each.startswith(("file:", "blob:"))] == []


def test_a_chapter_opens_as_its_plan_says(course_file: Path) -> None:
    pressed = at("document.querySelector('[data-view=top]').ariaPressed")
    done = opened(
        course_file,
        *(READY, ("click", "#chapters li:nth-child(2) button"), SECOND, ("text", "#chapter-title"), pressed),
        *(("text", "#caption .seen"), ("text", "#legend p"), at("document.activeElement.id")),
    )
    assert done.results[3:] == ["Once more", "true", "Incised", "Tension (kPa)", "chapter-title"]
    assert done.console == []


def test_a_wrong_answer_is_explained_and_only_the_first_counts(course_file: Path) -> None:
    done = opened(
        course_file,
        *(
            READY,
            ("check", ".option:nth-child(1) input"),
            ("click", ".question .primary"),
            ("text", ".feedback"),
            STANDING,
        ),
        *(("check", ".option:nth-child(2) input"), ("click", ".question .primary"), ("text", ".feedback"), STANDING),
    )
    assert done.results[3] == "Not right. Look again."
    assert done.results[4]["a"] == ["0", "-"]
    assert done.results[7] == "Right. They hold."
    assert done.results[8]["a"] == ["2", "-"]
    assert done.results[8]["score"] == 0


def test_a_click_is_right_within_its_distance(course_file: Path, plan_folder: Path) -> None:
    source = SkinCache(plan_folder / "cache.usdc")
    apex = LessonPlaces(LessonScene.of(source, source.frames)).find("landmark right apex")
    assert apex is not None
    place = apex.points[2, 0]
    near, far = ([float(place[0]), float(place[1]) + away, float(place[2])] for away in (3.0, 12.0))
    asking = ("until", "!document.querySelector('#asking').hidden && lappetLesson.resting()")
    results = []
    for there in (near, far):
        done = opened(
            course_file,
            *(READY, ("click", "#chapters li:nth-child(2) button"), SECOND, ("click", "canvas"), STANDING),
            *(("click", ".point"), asking, ("clickPlace", there), ("text", ".feedback"), STANDING),
        )
        assert done.console == []
        assert done.results[4]["a"] == ["-", "-"]  # a click that nobody asked for answers nothing
        results.append((done.results[8], done.results[9]["a"]))
    assert results[0] == ("Right. There it is.", ["-", "1"])
    assert results[1] == ("Not right. It is on the right. You were 12 mm away.", ["-", "0"])


def test_a_question_on_the_tissue_is_answered_by_keys_alone(course_file: Path) -> None:
    names = at("[...document.querySelectorAll('.candidates button')].map((each) => each.textContent)")
    done = opened(
        course_file,
        *(READY, ("focus", "#chapters li:nth-child(2) button"), ("press", "Enter"), SECOND),
        *(("focus", ".question summary"), ("press", "Enter"), names, ("tree", None)),
        *(("press", "Tab"), ("press", "Tab"), ("press", "Enter"), ("text", ".feedback"), STANDING),
    )
    assert done.results[6] == ["1left apex, left", "2right apex, right"]
    assert 'button "Answer on the picture"' in done.results[7]
    assert 'heading "Where is its right end?"' in done.results[7]
    assert done.results[11] == "Right. There it is."
    assert done.results[12]["a"] == ["-", "1"]


def test_a_hotspot_opens_from_its_mark_and_from_the_list(course_file: Path) -> None:
    expanded = at("document.querySelector('.hotspots button').ariaExpanded")
    done = opened(
        course_file,
        *(READY, ("click", ".label.hotspot"), ("text", "#hotspot-card"), expanded),
        *(("press", "Tab"), ("focus", ".hotspots button"), ("press", "Enter"), ("visible", "#hotspot-card"), expanded),
    )
    assert "Here the slit ends." in done.results[2]
    assert done.results[3] == "true"
    assert done.results[7:] == [False, "false"]


def test_chapters_end_when_all_steps_are_seen_and_all_questions_answered(course_file: Path) -> None:
    steps = [("click", f"#steps li:nth-child({k}) button") for k in (2, 3, 4)]
    answer = [("check", ".option:nth-child(2) input"), ("click", ".question .primary")]
    again = [("click", f"#steps li:nth-child({k}) button") for k in (1, 3, 4)]
    done = opened(
        course_file,
        *(READY, *steps, ("text", ".end"), *answer, ("text", ".end.finished h3"), STANDING),
        *(("click", "#next-chapter"), SECOND, *again, ("click", ".question summary")),
        *(("click", ".candidates li:nth-child(1) button"), ("text", ".end"), STANDING),
    )
    assert "0 of 1 questions answered" in done.results[4]
    assert done.results[7] == "Chapter finished"
    assert done.results[8]["complete"] is False
    assert done.results[-2].split("\n") == [
        "Lesson finished",
        "",
        "1 of 2 questions right at the first try (50 %).",
        "",
        "Not passed: 60 % are needed.",
    ]
    assert (done.results[-1]["complete"], done.results[-1]["passed"], done.results[-1]["score"]) == (True, False, 50)


def test_its_words_change_with_the_language(course_file: Path) -> None:
    done = opened(
        course_file,
        *(READY, ("click", "#open-options"), ("select", ("#language", "de")), ("text", ".question .kind")),
        *(("text", ".end"), ("attribute", ("#chapters", "aria-label"))),
    )
    assert done.results[3].lower() == "frage 1"
    assert "0 von 1 Fragen beantwortet" in done.results[4]
    assert done.results[5] == "Kapitel"


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("device", ["", "iPhone 13"])
def test_no_fault_of_accessibility_is_found(course_file: Path, device: str, scheme: str) -> None:
    done = opened(
        course_file,
        *(READY, ("click", ".hotspots button"), ("axe", None)),
        *(("check", ".option:nth-child(1) input"), ("click", ".question .primary"), ("axe", None)),
        *(("click", "#chapters li:nth-child(2) button"), SECOND, ("click", ".question summary"), ("axe", None)),
        *(("click", ".point"), ("axe", None), ("evaluate", "document.documentElement.scrollWidth - innerWidth")),
        device=device,
        colorScheme=scheme,
    )
    assert [each for each in done.results if isinstance(each, list)] == [[]] * 4
    assert done.results[-1] == 0


def test_a_file_that_was_cut_shows_a_sentence(course_file: Path, tmp_path: Path) -> None:
    page = course_file.read_text(encoding="utf-8")
    cut = tmp_path / "cut.html"
    cut.write_text(page[: (page.index('id="arrays-0"') + len(page)) // 2], encoding="utf-8")
    done = opened(cut, ("until", "document.querySelector('#notice [role=alert]')"), ("text", "#notice"))
    assert "This lesson is not complete" in done.results[1]
