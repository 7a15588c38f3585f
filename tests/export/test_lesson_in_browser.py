"""A lesson in Chromium, from disk and without a network: it opens, shows every frame, obeys and says what is wrong."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from lappet.drawing.skin_read import SkinCache
from lappet.export.export_request import ExportRequest
from lappet.export.formats import export
from lesson_browser import opened

pytestmark = [pytest.mark.slow, pytest.mark.timeout(600)]
READY = ("ready", None)
STEPS = ["Planned incisions", "Incised", "Raised with hooks", "Closed with sutures"]


def test_it_opens_without_a_word_in_the_console_and_asks_for_nothing(lesson_file: Path) -> None:
    done = opened(lesson_file, READY, ("text", "h1"), ("count", "#steps li"), ("text", "#caption .seen"))
    assert done.results[1:] == ["Slit <b> & suture", len(STEPS), STEPS[0]]
    assert done.console == []
    assert [each for each in done.requests if not each.startswith(("file:", "blob:"))] == []


def test_every_frame_stands_where_the_cache_has_it(lesson_file: Path, skin_cache: Path, tmp_path: Path) -> None:
    kept = tmp_path / "positions.json"
    script = "lappetLesson.frames().map((_, k) => { lappetLesson.seek(k); return lappetLesson.positions(k); })"
    done = opened(lesson_file, READY, ("into", (script, str(kept))))
    assert done.console == []
    cache = SkinCache(skin_cache)
    frames = json.loads(kept.read_text())
    assert len(frames) == len(cache.frames)
    for time, found in zip(cache.frames, frames, strict=True):
        off = np.reshape(found, (-1, 3)) - cache.positions(cache.epoch_at(time), time)
        assert np.linalg.norm(off, axis=1).max() < 0.05


def test_every_option_changes_the_picture(lesson_file: Path) -> None:
    looks = [("check", f"input[value={look}]") for look in ("painted", "tension", "grid")]
    views = [("click", f"[data-view={view}]") for view in ("top", "low", "behind", "oblique")]
    parts = [("uncheck", f"input[name={name}]") for name in ("hooks", "letters")]
    actions = [READY, ("evaluate", "lappetLesson.seek(5)"), ("check", "input[name=landmarks]"), ("changed", None)]
    for action in (*looks, *views):
        actions += [action, ("changed", None)]
    gone = "[...document.querySelectorAll('.label.corner')].every((each) => each.hidden)"
    actions += [parts[0], ("changed", None), ("evaluate", gone), parts[1], ("until", gone)]
    done = opened(lesson_file, *actions)
    changes = [value for (name, _), value in zip(actions, done.results, strict=True) if name == "changed"]
    assert done.console == []
    assert all(change > 0.002 for change in changes), changes
    assert done.results[-3] is False


def test_a_lesson_sees_nothing_of_what_was_opened_in_the_browser_before(lesson_file: Path) -> None:
    kept = ("evaluate", "localStorage.getItem('kept')")
    assert opened(lesson_file, READY, ("evaluate", "localStorage.setItem('kept', '1')"), kept).results[-1] == "1"
    with pytest.raises(AssertionError, match="unheard"):
        opened(lesson_file, READY, ("evaluate", "unheard()"))
    assert opened(lesson_file, READY, kept).results[-1] is None


def test_a_map_has_its_key(lesson_file: Path) -> None:
    done = opened(
        lesson_file,
        READY,
        ("visible", "#legend"),
        ("check", "input[value=tension]"),
        ("until", "!document.querySelector('#legend').hidden"),
        ("text", "#legend"),
        ("check", "input[value=strain]"),
        ("until", "document.querySelector('#legend p').textContent === 'Strain'"),
    )
    assert done.results[1] is False
    assert "Tension (kPa)" in done.results[4]
    assert "≥" in done.results[4]


def test_it_plays_to_the_end_and_rests_at_steps(lesson_file: Path) -> None:
    done = opened(
        lesson_file,
        READY,
        ("select", ("#speed", "2")),
        ("click", "#play"),
        ("until", "document.querySelector('#play').ariaLabel === 'Pause'"),
        ("until", "lappetLesson.time() === lappetLesson.length()"),
        ("until", "document.querySelector('#play').ariaLabel === 'Play'"),
        ("text", "#caption .seen"),
        ("attribute", ("#time", "aria-valuetext")),
    )
    assert done.console == []
    assert done.results[6:] == [STEPS[-1], f"{STEPS[-1]}, frame 12 of 12"]


def test_keys_move_through_time_and_turn_the_picture(lesson_file: Path) -> None:
    time = ("evaluate", "lappetLesson.time()")
    done = opened(
        lesson_file,
        *(READY, ("press", "PageDown"), time, ("press", "."), time, ("press", ","), time, ("press", "PageUp"), time),
        *(("focus", "#time"), ("press", "End"), time, ("press", "ArrowLeft"), time, ("press", "Home"), time),
        *(("focus", "canvas"), ("changed", None), ("press", "ArrowLeft"), ("changed", None)),
        *(("press", "+"), ("changed", None), ("drag", (300, 300, 90, 20)), ("changed", None)),
    )
    assert done.results[2:9:2] == [2, 3, 2, 0]
    assert [done.results[k] for k in (11, 13, 15)] == [11, 10, 0]
    changes = [done.results[k] for k in (19, 21, 23)]
    assert all(change > 0.01 for change in changes), changes


def test_its_words_change_with_the_language(lesson_file: Path) -> None:
    done = opened(
        lesson_file,
        READY,
        ("select", ("#language", "de")),
        ("until", "document.querySelector('#caption .seen').textContent === 'Geplante Schnitte'"),
        ("attribute", ("#play", "aria-label")),
        ("attribute", ("html", "lang")),
        ("select", ("#language", "zh")),
        ("attribute", ("#play", "aria-label")),
    )
    assert done.results[3:5] == ["Abspielen", "de"]
    assert done.results[6] == "播放"


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("device", ["", "iPhone 13"])
def test_no_fault_of_accessibility_is_found(lesson_file: Path, device: str, scheme: str) -> None:
    shown = [] if device == "" else [("axe", None), ("click", "#open-options")]
    done = opened(lesson_file, READY, *shown, ("axe", None), device=device, colorScheme=scheme)
    assert [each for each in done.results if isinstance(each, list)] == [[]] * (1 if device == "" else 2)


def test_a_screen_reader_finds_steps_time_and_what_is_shown(lesson_file: Path) -> None:
    tree = opened(lesson_file, READY, ("tree", None)).results[1]
    assert 'status: "Step 1 of 4: Planned incisions"' in tree or "Step 1 of 4: Planned incisions" in tree
    for line in ('slider "Time in the operation"', 'button "Play"', 'radio "Tension"', 'checkbox "Instruments"'):
        assert line in tree


def test_on_a_telephone_nothing_is_wider_than_the_screen(lesson_file: Path) -> None:
    wide = ("evaluate", "document.documentElement.scrollWidth - innerWidth")
    done = opened(
        lesson_file,
        *(READY, wide, ("visible", "#options"), ("click", "#open-options"), ("visible", "#options"), wide),
        device="iPhone 13",
    )
    assert done.results[1:3] == [0, False]
    assert done.results[4:] == [True, 0]
    assert done.console == []


def test_with_reduced_motion_frames_follow_each_other_without_moments_between(lesson_file: Path) -> None:
    between = "lappetLesson.seek(4.5), lappetLesson.shown().join()"
    whole = "lappetLesson.seek(4), lappetLesson.shown().join()"
    still = opened(lesson_file, READY, ("evaluate", between), ("evaluate", whole), reducedMotion="reduce").results
    moving = opened(lesson_file, READY, ("evaluate", between), ("evaluate", whole)).results
    assert still[1] == still[2]
    assert moving[1] != moving[2]


def test_it_prints_a_picture_of_every_step(lesson_file: Path, tmp_path: Path) -> None:
    pdf = tmp_path / "sheet.pdf"
    drawn = "Array.from(document.querySelectorAll('#sheet figcaption'), (each) => each.textContent)"
    done = opened(
        lesson_file,
        READY,
        ("evaluate", "window.dispatchEvent(new Event('beforeprint'))"),
        ("evaluate", drawn),
        ("evaluate", "Math.min(...Array.from(document.querySelectorAll('#sheet img'), (each) => each.src.length))"),
        ("pdf", str(pdf)),
    )
    assert [text.split("  ")[1] for text in done.results[2]] == STEPS
    assert done.results[3] > 10_000
    assert pdf.stat().st_size > 50_000
    assert done.console == []


def test_two_procedures_stand_side_by_side_at_the_same_step(skin_cache: Path, tmp_path: Path) -> None:
    target = tmp_path / "two.html"
    export(ExportRequest((skin_cache, skin_cache), target))
    done = opened(
        target,
        READY,
        ("evaluate", "lappetLesson.procedures"),
        ("count", ".titles h2"),
        ("evaluate", "lappetLesson.seek(4), [lappetLesson.shown(0).join(), lappetLesson.shown(1).join()]"),
        ("axe", None),
    )
    assert done.results[1:3] == [2, 2]
    assert done.results[3][0] == done.results[3][1]
    assert done.results[4] == []
    assert done.console == []


@pytest.mark.parametrize(
    ("share", "said"),
    [
        ("arrays", "This lesson is not complete"),
        ("json", "the file is not complete"),
        ("program", "the file is not complete"),
    ],
)
def test_a_file_that_was_cut_shows_a_sentence(lesson_file: Path, tmp_path: Path, share: str, said: str) -> None:
    page = lesson_file.read_text(encoding="utf-8")
    data, arrays = page.index('id="lesson"'), page.index('id="arrays"')
    ends = {"arrays": (arrays + len(page)) // 2, "json": (data + arrays) // 2, "program": data // 2}
    cut = tmp_path / "cut.html"
    cut.write_text(page[: ends[share]], encoding="utf-8")
    done = opened(cut, ("wait", 1500), ("text", "#notice"))
    assert said in done.results[1]


def test_damaged_data_show_a_sentence(lesson_file: Path, tmp_path: Path) -> None:
    page = lesson_file.read_text(encoding="utf-8")
    middle = (page.index('id="arrays"') + len(page)) // 2
    damaged = tmp_path / "damaged.html"
    damaged.write_text(page[:middle] + "AAAAAAAA" + page[middle + 8 :], encoding="utf-8")
    done = opened(damaged, ("until", "document.querySelector('#notice [role=alert]')"), ("text", "#notice"))
    assert "damaged" in done.results[1]
