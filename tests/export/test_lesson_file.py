"""A lesson holds what its cache holds, in every language, and asks for nothing outside its file."""

from __future__ import annotations

import re
import string
from pathlib import Path

import numpy as np
import pytest

import synthetic_skin_cache as synthetic
from lappet.core.problem import RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.drawing.skin_fields import SKIN
from lappet.drawing.skin_read import SkinCache
from lappet.export import viewer_program
from lappet.export.export_request import ExportRequest
from lappet.export.formats import export
from lappet.export.lesson_words import lesson_words
from lesson_reader import ReadLesson, numbers


@pytest.fixture(scope="module")
def lesson(lesson_file: Path) -> ReadLesson:
    return ReadLesson.of(lesson_file)


@pytest.fixture(scope="module")
def cache(skin_cache: Path) -> SkinCache:
    return SkinCache(skin_cache)


def refusal(caches: tuple[Path, ...], target: Path, **options: object) -> ProblemCode:
    with pytest.raises(RefusedError) as refused:
        export(ExportRequest(caches, target, options))
    assert not target.exists()
    (problem,) = refused.value.problems
    return problem.code


def test_every_frame_is_within_five_hundredths_of_a_millimeter(lesson: ReadLesson, cache: SkinCache) -> None:
    assert lesson.content["procedures"][0]["times"] == list(cache.frames)
    for index, time in enumerate(cache.frames):
        off = np.linalg.norm(lesson.frame(index) - cache.positions(cache.epoch_at(time), time), axis=1)
        assert off.max() < 0.05


def test_drawn_triangles_are_those_of_the_cache_by_what_they_are(lesson: ReadLesson, cache: SkinCache) -> None:
    for epoch, told in zip(cache.epochs, lesson.content["procedures"][0]["epochs"], strict=True):
        vertex = numbers(lesson.block, told["vertex"]).astype(np.int64)
        triangles = vertex[numbers(lesson.block, told["triangles"]).astype(np.int64)].reshape(-1, 3)
        order = np.argsort(epoch.origin, kind="stable")
        np.testing.assert_array_equal(triangles, epoch.triangles[order])
        assert told["faces"] == [int((epoch.origin == label).sum()) for label in range(4)]


def test_the_grid_is_in_millimeters_on_the_skin(lesson: ReadLesson, cache: SkinCache) -> None:
    """The texture of the flat patch runs along it, so that the grid is its place but for where it begins."""
    told = lesson.content["procedures"][0]["epochs"][1]
    vertex = numbers(lesson.block, told["vertex"]).astype(np.int64)
    skin = vertex[: told["vertices"][SKIN]]
    grid = told["gridStep"] * numbers(lesson.block, told["grid"]).reshape(2, -1).T[: len(skin)] + told["gridLow"]
    rest, _, _ = synthetic.patch(4.0, True)
    away = grid - rest[skin, :2]
    assert np.ptp(away, axis=0).max() < 0.05


def test_a_map_shows_the_share_of_full_scale(lesson: ReadLesson, cache: SkinCache) -> None:
    procedure = lesson.content["procedures"][0]
    told = procedure["epochs"][1]
    skin = numbers(lesson.block, told["vertex"])[: told["vertices"][SKIN]].astype(np.int64)
    for name, unit in (("tension", "kPa"), ("strain", ""), ("stress", "kPa")):
        full = procedure["quantities"][name]["full"]
        assert procedure["quantities"][name]["unit"] == unit
        shares = numbers(lesson.block, told["quantities"][name]).reshape(len(told["frames"]), -1) / 255.0
        for row, frame in zip(shares, told["frames"], strict=True):
            time = procedure["times"][frame]
            values = cache.scalar(cache.epoch_at(time), name, time)
            assert values is not None
            np.testing.assert_allclose(row, np.clip(values[skin] / full, 0.0, 1.0), atol=0.5 / 255 + 1e-6)


def test_steps_are_those_of_a_plate_with_captions_in_every_language(lesson: ReadLesson) -> None:
    steps = lesson.content["procedures"][0]["steps"]
    assert [step["kind"] for step in steps] == ["plan", "incised", "raised", "sutured"]
    assert [step["frame"] for step in steps] == sorted({step["frame"] for step in steps})
    for words in lesson.content["words"].values():
        assert all(words[f"step.{step['kind']}"] for step in steps)


def test_threads_and_hooks_are_there_while_they_hold(lesson: ReadLesson, cache: SkinCache) -> None:
    strands = lesson.content["procedures"][0]["strands"]
    for index, time in enumerate(cache.frames):
        assert bool(strands["hooks"]["lines"][index]) == bool(cache.hooks(time).active.any())
        assert bool(strands["threads"]["lines"][index]) == bool(cache.sutures(time).active.any())


def test_landmarks_ride_on_the_skin(lesson: ReadLesson, cache: SkinCache) -> None:
    labels = {each["text"]: each for each in lesson.content["procedures"][0]["labels"] if each["kind"] == "landmark"}
    assert set(labels) == {"left apex", "right apex"}
    for index, time in enumerate(cache.frames):
        place = labels["right apex"]["places"][index]
        np.testing.assert_allclose(place, cache.named_landmarks(time)["right apex"], atol=1e-3)


def test_languages_say_the_same_things_with_the_same_values() -> None:
    every = lesson_words()
    fields = {
        key: {name for _, name, _, _ in string.Formatter().parse(text) if name} for key, text in every["en"].items()
    }
    for language, words in every.items():
        assert set(words) == set(every["en"]), language
        for key, text in words.items():
            assert {name for _, name, _, _ in string.Formatter().parse(text) if name} == fields[key], (language, key)


def test_the_page_asks_for_nothing_outside_its_file(lesson_file: Path) -> None:
    page = lesson_file.read_text(encoding="utf-8")
    assert "default-src 'none'" in page
    assert re.findall(r"<(?:link|img|iframe|object|embed)\b", page.split("<script>")[0]) == []
    assert not re.search(r"<script[^>]*\bsrc=", page)
    assert "<title>Slit &lt;b&gt; &amp; suture</title>" in page


def test_the_notice_of_the_library_is_in_the_page(lesson_file: Path) -> None:
    page = lesson_file.read_text(encoding="utf-8")
    assert "Three.js Authors" in page
    assert "SPDX-License-Identifier: MIT" in page


def test_the_same_cache_gives_the_same_lesson(skin_cache: Path, lesson_file: Path, tmp_path: Path) -> None:
    again = tmp_path / "again.html"
    export(ExportRequest((skin_cache,), again, {"title": "Slit <b> & suture"}))
    assert again.read_bytes() == lesson_file.read_bytes()


def test_chosen_frames_are_the_only_ones(skin_cache: Path, tmp_path: Path) -> None:
    target = tmp_path / "three.html"
    export(ExportRequest((skin_cache,), target, {"frames": [1.0, 12.0, 7.0], "language": "de"}))
    content = ReadLesson.of(target).content
    assert content["procedures"][0]["times"] == [1.0, 7.0, 12.0]
    assert content["language"] == "de"


def test_two_procedures_share_the_scales_of_their_maps(skin_cache: Path, tmp_path: Path) -> None:
    target = tmp_path / "two.html"
    other = tmp_path / "other"
    other.mkdir()
    export(ExportRequest((skin_cache, synthetic.write_cache(other, step=8.0)), target))
    first, second = ReadLesson.of(target).content["procedures"]
    assert first["quantities"] == second["quantities"]
    assert first["title"] == second["title"] == "cache"


def test_what_cannot_be_shown_is_refused_before_anything_is_written(skin_cache: Path, tmp_path: Path) -> None:
    target = tmp_path / "lesson.html"
    assert refusal((skin_cache,), target, frames=[1.0, 99.0]) == ProblemCode.EXPORT_FRAME
    assert refusal((skin_cache,) * 3, target) == ProblemCode.EXPORT_CACHES
    assert refusal((skin_cache,), tmp_path / "lesson.htm") == ProblemCode.EXPORT_SUFFIX
    assert refusal((skin_cache,), tmp_path / "none" / "lesson.html") == ProblemCode.EXPORT_FOLDER
    assert refusal((skin_cache,), target, paper="red") == ProblemCode.EXPORT_OPTION


def test_a_cache_without_its_procedure_is_refused(tmp_path: Path) -> None:
    cache = synthetic.write_cache(tmp_path, step=8.0)
    (tmp_path / "procedure.usda").unlink()
    assert refusal((cache,), tmp_path / "lesson.html") == ProblemCode.USD_COMPOSITION


def test_a_missing_viewer_is_refused_with_what_to_do(
    skin_cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(viewer_program, "NAME", "not_built.js")
    assert refusal((skin_cache,), tmp_path / "lesson.html") == ProblemCode.EXPORT_VIEWER


def test_forty_frames_of_twenty_thousand_vertices_take_less_than_5_mb(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, value in {"FRAMES": tuple(range(1, 41)), "INCISED": 6, "LIFTED": 24, "SUTURED": 34}.items():
        monkeypatch.setattr(synthetic, name, value)
    cache = SkinCache(synthetic.write_cache(tmp_path, step=0.9))
    assert (len(cache.frames), len(cache.rest(cache.epochs[1])) > 20_000) == (40, True)
    (lesson,) = export(ExportRequest((cache.path,), tmp_path / "lesson.html"))
    assert lesson.stat().st_size < 5e6
    read = ReadLesson.of(lesson)
    for index in (0, 20, 39):
        time = cache.frames[index]
        off = read.frame(index) - cache.positions(cache.epoch_at(time), time)
        assert np.linalg.norm(off, axis=1).max() < 0.05
