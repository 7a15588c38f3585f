"""A film holds at the steps, which are its chapters, and is as long as its pictures."""

from __future__ import annotations

import re
import subprocess
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from imageio_ffmpeg import get_ffmpeg_exe
from PIL import Image
from shapely import LineString, box

from lappet.core.problem_code import ProblemCode
from lappet.drawing.skin_read import SkinCache
from lappet.plates.boundary_labels import PlacedLabel
from lappet.plates.contact_sheet import check_sheet, write_contact_sheet
from lappet.plates.draw_film import WIDTH, FilmOptions, draw_film, film_caption, film_panel
from lappet.plates.draw_plate import PlateOptions
from lappet.plates.film_file import check_film, write_film
from lappet.plates.film_frames import chapters, film_frames
from lappet.plates.page_ground import DARK
from lappet.plates.plate_cache import chosen_steps
from lappet.plates.plate_font import PlateFont
from lappet.plates.plate_movie import film_options
from lappet.plates.plate_panel import LINE, PagePanel, PanelMaker
from lappet.plates.plate_request import PlateRequest, PlateRow
from lappet.plates.plate_scene import plate_scene
from lappet.plates.plate_steps import PlateStep, StepKind
from lappet.plates.plate_style import plate_style
from lappet.plates.plate_words import plate_words
from lappet.plates.told_labels import ToldLabels
from refusals import refuses

PLAN, CUT, END = (
    PlateStep(1.0, StepKind.PLAN),
    PlateStep(3.0, StepKind.INCISED),
    PlateStep(6.0, StepKind.RESULT),
)


def told_of(film: Path) -> tuple[float, list[str], str]:
    """The length in seconds, the chapters' titles, and the size, as FFmpeg reads them."""
    said = subprocess.run([get_ffmpeg_exe(), "-i", film], capture_output=True, text=True, check=False).stderr
    hours, minutes, seconds = re.search(r"Duration: (\d+):(\d+):([\d.]+)", said).groups()  # type: ignore[union-attr]
    body = said.partition("Chapters:")[2].partition("Stream")[0]
    size = re.search(r"Video: .*?, (\d+x\d+)", said)
    assert size is not None, said
    return 3600 * int(hours) + 60 * int(minutes) + float(seconds), re.findall(r"title\s*: (.*)", body), size.group(1)


def test_frames_between_steps_run_and_steps_are_held() -> None:
    frames = film_frames([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0], [PLAN, CUT, END], fps=4.0, pause=2.0)
    assert [(frame.step.time, frame.seconds) for frame in frames] == [
        *((1.0, 2.0), (2.0, 0.25), (3.0, 2.0)),
        *((4.0, 0.25), (5.0, 0.25), (6.0, 2.0)),
    ]
    assert [frame.caption for frame in frames] == [PLAN, CUT, CUT, END, END, END]


def test_while_a_camera_turns_a_step_is_held_by_as_many_pictures_as_are_shown_on_the_way() -> None:
    times = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    standing, turning = (film_frames(times, [PLAN, CUT, END], 4.0, 2.0, turning=each) for each in (False, True))
    assert {frame.seconds for frame in turning} == {0.25}
    assert [frame.step.time for frame in turning].count(3.0) == 8
    assert chapters(turning) == chapters(standing)


def test_a_contact_sheet_shows_each_picture_with_its_second(tmp_path: Path, font: PlateFont) -> None:
    shades, pictures = (30, 90, 150, 210), []
    for number, shade in enumerate(shades):
        picture = tmp_path / f"{number}.png"
        Image.new("RGB", (1280, 720), (shade, shade, shade)).save(picture)
        pictures.append((picture, 65.5 * number))
    write_contact_sheet(pictures, tmp_path / "sheet.png", font.path, DARK)
    with Image.open(tmp_path / "sheet.png") as sheet:
        grey = np.asarray(sheet.convert("L"), float)
    assert [np.isclose(grey, shade, atol=1.0).mean() > 0.1 for shade in shades] == [True] * 4  # a ninth of it each
    below = grey[24 + 360 + 2 : 24 + 360 + 32, 24:664]
    assert below.max() > 200.0  # the time is light on a dark ground
    with refuses(ProblemCode.PLATE_SUFFIX):
        check_sheet(tmp_path / "sheet.gif")


def test_a_picture_on_the_way_to_a_step_says_so(font: PlateFont) -> None:
    frames = film_frames([1.0, 2.0, 3.0], [PLAN, CUT], fps=4.0, pause=2.0)
    said = [film_caption(frame, plate_words("en"), font) for frame in frames]
    assert said == ["Planned incisions", "→ Incised", "Incised"]


def test_the_film_of_a_plate_looks_like_the_plate() -> None:
    plate = PlateOptions(style="ink", tone=8, language="fr", shown={"view": "top", "marks": "grid", "width": 85.0})
    film = film_options(plate)
    assert (film.style, film.tone, film.language, film.view, film.marks) == ("ink", 8, "fr", "top", "grid")


def test_chapters_follow_each_other_without_a_gap() -> None:
    frames = film_frames([1.0, 2.0, 3.0, 4.0, 5.0, 6.0], [PLAN, CUT, END], fps=4.0, pause=2.0)
    found = chapters(frames)
    assert [(begin, end, step) for begin, end, step in found] == [
        *((0.0, 2.0, PLAN), (2.0, 4.25, CUT), (4.25, 6.75, END)),
    ]


@pytest.mark.parametrize("suffix", [".mp4", ".webm"])
def test_a_film_is_as_long_as_its_pictures_and_has_its_chapters(tmp_path: Path, suffix: str) -> None:
    pictures = []
    for number, shade in enumerate((40, 120, 220)):
        picture = tmp_path / f"{number}.png"
        Image.new("RGB", (320, 240), (shade, 90, 60)).save(picture)
        pictures.append((picture, 0.5 + number))
    film = tmp_path / f"film{suffix}"
    write_film(pictures, [(0.0, 0.5, "Before; = after"), (0.5, 4.5, "Nachher")], "A film", film, (320, 240))
    length, titles, size = told_of(film)
    assert length == pytest.approx(4.5, abs=0.06)
    assert titles == ["Before; = after", "Nachher"]
    assert size == "320x240"
    assert [each.name for each in tmp_path.iterdir() if each.name.startswith(".")] == []


@pytest.mark.parametrize("suffix", [".gif", ".webp"])
def test_a_loop_shows_every_picture(tmp_path: Path, suffix: str) -> None:
    pictures = []
    for number, shade in enumerate((0, 128, 255)):
        picture = tmp_path / f"{number}.png"
        Image.new("RGB", (320, 240), (shade, shade, shade)).save(picture)
        pictures.append((picture, 0.5))
    film = tmp_path / f"film{suffix}"
    write_film(pictures, [], "A loop", film, (320, 240))
    with Image.open(film) as made:
        shades = set()
        for frame in range(made.n_frames):
            made.seek(frame)
            shades.add(round(made.convert("L").getpixel((160, 120)) / 64))  # type: ignore[operator]
        assert shades == {0, 2, 4}


@pytest.mark.slow
def test_the_film_of_an_operation_has_a_chapter_for_each_step(cache_file: Path, tmp_path: Path) -> None:
    film = tmp_path / "film.mp4"
    done: list[tuple[int, int]] = []
    options = FilmOptions(size=(480, 270), fps=12.0, pause=0.5, language="de", style="ink")
    draw_film(cache_file, film, options, progress=lambda at, of: done.append((at, of)))
    length, titles, size = told_of(film)
    assert size == "480x270"
    assert titles[0] == "Geplante Schnitte"
    assert len(titles) >= 4
    held = len(titles)
    assert done[-1][0] == done[-1][1]
    assert length == pytest.approx(0.5 * held + (done[-1][1] - held) / 12.0, abs=0.1)


def test_what_is_no_film_is_refused_before_anything_is_drawn(cache_file: Path, tmp_path: Path) -> None:
    with refuses(ProblemCode.FILM_SUFFIX):
        check_film(tmp_path / "film.avi", (1920, 1080))
    with refuses(ProblemCode.PLATE_FOLDER):
        check_film(tmp_path / "nowhere" / "film.mp4", (1920, 1080))
    for size in ((1921, 1080), (200, 120), (1080, 1920)):
        with refuses(ProblemCode.FILM_SIZE):
            check_film(tmp_path / "film.mp4", size)
    with refuses(ProblemCode.FILM_SPEED):
        draw_film(cache_file, tmp_path / "film.mp4", FilmOptions(fps=0.0))
    assert list(tmp_path.iterdir()) == []


def test_labels_of_a_film_neither_jump_nor_flicker(cache: SkinCache, font: PlateFont) -> None:
    """On the way from step to step names keep their places, their leaders slide, and what has gone does not return."""
    steps = chosen_steps(cache)
    frames = film_frames(cache.frames, steps, 8.0, 2.0)
    request = PlateRequest((PlateRow(cache, tuple(each.step for each in frames)),), {}, WIDTH, 1)
    size = (WIDTH, 78.0)
    scene = plate_scene(cache, [step.time for step in steps], "oblique", size)
    maker = PanelMaker(request, (scene,), plate_style("schematic"), plate_words("en"), font, size)
    told = ToldLabels()
    panels = [film_panel(maker, number, frame, told) for number, frame in enumerate(frames)]
    pairs = 0
    for (_, one), (second, other) in pairwise(zip(frames, panels, strict=True)):
        was = {label.text: label for label in one.labels}
        held = second.step == second.caption
        assert held or {label.text for label in other.labels} <= set(was)
        for label in other.labels:
            if label.text in was and not held:
                pairs += 1
                jumps = np.abs(label.port - was[label.text].port).max() > 1e-6
                assert not jumps or is_in_the_way(was[label.text], other, font), f"{label.text} at {second.step.time}"
    assert pairs >= 4  # it has labels on the way


def is_in_the_way(label: PlacedLabel, panel: PagePanel, font: PlateFont) -> bool:
    """Whether a label would stand over something that is drawn, were it where it was."""
    size = plate_style("schematic").label_size
    inner, half = label.port[0], 0.5 * LINE * size
    outer = inner + (-1.0 if label.left else 1.0) * (font.width(label.text, size) + 0.4 * LINE * size)
    text = box(min(inner, outer), label.port[1] - half, max(inner, outer), label.port[1] + half)
    drawn = [LineString(stroke.points) for stroke in panel.drawing.strokes]
    return any(each.intersects(text) for each in drawn)
