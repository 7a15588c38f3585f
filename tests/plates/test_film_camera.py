"""The camera of a film turns evenly about the operation, and a title card and a ground are as they are wanted."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from lappet.core.problem_code import ProblemCode
from lappet.drawing.skin_read import SkinCache
from lappet.plates.draw_film import FilmOptions, draw_film
from lappet.plates.film_camera import camera_way
from lappet.plates.page_ground import DARK
from lappet.plates.plate_scene import plate_scene
from refusals import refuses

SIZE = (150.0, 80.0)
SMALL = FilmOptions(size=(320, 240), fps=60.0, pause=0.2, style="schematic")


def test_the_camera_turns_by_its_angle_at_one_distance_and_the_operation_stays_in_the_picture(cache: SkinCache) -> None:
    scene = plate_scene(cache, cache.frames, "oblique", SIZE)
    way = camera_way(scene, "oblique", SIZE, 60.0, 25)
    normal = scene.field.normal
    flat = [each.view.axes[2] - (each.view.axes[2] @ normal) * normal for each in way]
    flat = [each / np.linalg.norm(each) for each in flat]
    turns = [np.degrees(np.arccos(np.clip(a @ b, -1.0, 1.0))) for a, b in pairwise(flat)]
    assert sum(turns) == pytest.approx(60.0, abs=1e-6)
    assert np.degrees(np.arccos(flat[0] @ flat[-1])) == pytest.approx(60.0, abs=1e-6)
    assert max(turns) < 2.0 * 60.0 / 24.0
    assert len({round(each.view.distance, 9) for each in way}) == 1
    for each in way:
        paper, _ = each.projection(SIZE).paper(scene.field.points)
        assert (np.abs(paper) < 0.5 * np.asarray(SIZE)).all()


def test_a_camera_that_stands_is_that_of_the_plate(cache: SkinCache) -> None:
    scene = plate_scene(cache, cache.frames, "oblique", SIZE)
    assert camera_way(scene, "oblique", SIZE, 0.0, 3) == [scene] * 3


@pytest.mark.slow
def test_a_title_card_comes_first_on_a_dark_ground(cache_file: Path, tmp_path: Path) -> None:
    options = FilmOptions(**{**vars(SMALL), "card": 1.0, "dark": True, "title": "A cut and its suture"})
    draw_film(cache_file, tmp_path / "f.png", options)
    pictures = sorted(tmp_path.glob("f_*.png"))
    with Image.open(pictures[0]) as card, Image.open(pictures[1]) as first:
        dark = tuple(int(DARK.paper[k : k + 2], 16) for k in (1, 3, 5))
        for picture in (card.convert("RGB"), first.convert("RGB")):
            assert picture.getpixel((2, picture.height - 2)) == dark
        shades = np.asarray(card.convert("L"))
        assert shades.max() > 200  # the title is light
        assert np.abs(np.asarray(card.convert("L"), float) - np.asarray(first.convert("L"), float)).mean() > 10.0


@pytest.mark.slow
def test_a_transparent_film_has_an_alpha_channel(cache_file: Path, tmp_path: Path) -> None:
    options = FilmOptions(**{**vars(SMALL), "transparent": True, "style": "ink"})
    draw_film(cache_file, tmp_path / "f.webp", options)
    with Image.open(tmp_path / "f.webp") as film:
        alpha = np.asarray(film.convert("RGBA"))[..., 3]
    assert alpha.min() == 0
    assert alpha.max() == 255


@pytest.mark.parametrize(
    ("name", "options", "code"),
    [
        ("f.mp4", {"transparent": True}, ProblemCode.FILM_ALPHA),
        ("f.webm", {"transparent": True, "dark": True}, ProblemCode.FILM_GROUND),
        ("f.mp4", {"orbit": 200.0}, ProblemCode.FILM_CAMERA),
        ("f.mp4", {"orbit": 20.0, "view": "top"}, ProblemCode.FILM_CAMERA),
        ("f.mp4", {"card": -1.0}, ProblemCode.FILM_CARD),
    ],
)
def test_what_no_film_has_is_refused_before_anything_is_drawn(
    cache_file: Path, tmp_path: Path, name: str, options: dict[str, object], code: ProblemCode
) -> None:
    with refuses(code):
        draw_film(cache_file, tmp_path / name, FilmOptions(**{**vars(SMALL), **options}))  # type: ignore[arg-type]
    assert list(tmp_path.iterdir()) == []
