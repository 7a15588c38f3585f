"""What cannot be drawn is refused with its name before anything is written."""

from __future__ import annotations

from pathlib import Path

import pytest

from lappet.commands.cli import cli
from lappet.core.problem_code import ProblemCode
from lappet.drawing.skin_read import SkinCache
from lappet.plates.planned_panels import plate_panels
from lappet.plates.plate_cache import chosen_steps, open_cache
from lappet.plates.plate_files import check_format
from lappet.plates.plate_font import PlateFont
from lappet.plates.plate_page import plate_page
from lappet.plates.plate_request import PlateRequest, PlateRow
from lappet.plates.plate_style import plate_style
from lappet.plates.plate_words import LANGUAGES, plate_words
from lappet.procedure.plate import Plate, PlateAnnotation, PlatePanel
from refusals import refuses


def test_a_width_that_no_page_has_is_refused(cache: SkinCache, font: PlateFont) -> None:
    request = PlateRequest((PlateRow(cache, chosen_steps(cache)),), {}, width=12.0)
    with refuses(ProblemCode.PLATE_WIDTH) as problems:
        plate_page(request, plate_style("ink"), plate_words("en"), font)
    assert problems[0].value == "12.0"


def test_panels_too_narrow_for_their_labels_are_refused(cache: SkinCache, font: PlateFont) -> None:
    request = PlateRequest((PlateRow(cache, chosen_steps(cache)),), {}, width=60.0, columns=4)
    with refuses(ProblemCode.PLATE_LABEL_WIDE):
        plate_page(request, plate_style("ink"), plate_words("en"), font)


def test_a_font_without_a_character_is_refused(cache: SkinCache, font: PlateFont) -> None:
    with refuses(ProblemCode.PLATE_FONT_LACKS) as problems:
        plate_page(
            PlateRequest((PlateRow(cache, chosen_steps(cache)),), {}), plate_style("ink"), plate_words("zh"), font
        )
    assert problems[0].value in "".join(plate_words("zh").texts.values())


def test_a_file_that_is_no_font_is_refused(tmp_path: Path) -> None:
    (tmp_path / "font.ttf").write_text("no font")
    with refuses(ProblemCode.PLATE_FONT):
        PlateFont(tmp_path / "font.ttf")


def test_formats_and_folders_that_are_not_there_are_refused(tmp_path: Path) -> None:
    with refuses(ProblemCode.PLATE_SUFFIX):
        check_format(tmp_path / "plate.doc")
    with refuses(ProblemCode.PLATE_FOLDER):
        check_format(tmp_path / "nowhere" / "plate.svg")
    with refuses(ProblemCode.PLATE_CMYK):
        check_format(tmp_path / "plate.png", tmp_path / "print.icc")


def test_a_frame_that_is_not_in_the_cache_is_refused(cache: SkinCache) -> None:
    with refuses(ProblemCode.PLATE_CACHE) as problems:
        chosen_steps(cache, (9999.0,))
    assert str(problems[0]).endswith("choose one of those or solve more of the procedure.")  # and nothing besides
    assert problems[0].value == "9999.0"


def test_a_landmark_that_is_not_there_is_refused_with_those_that_are(cache: SkinCache, font: PlateFont) -> None:
    request = PlateRequest((PlateRow(cache, chosen_steps(cache)),), {}, landmarks=("nose",))
    with refuses(ProblemCode.PLATE_LANDMARK) as problems:
        plate_page(request, plate_style("ink"), plate_words("en"), font)
    assert "left apex" in problems[0].remedy


def test_a_file_that_is_no_cache_is_refused(cache_file: Path) -> None:
    with refuses(ProblemCode.PLATE_CACHE):
        open_cache(cache_file.with_name("procedure.usda"))


def test_captions_of_ones_own_take_the_place_of_the_catalogues(tmp_path: Path) -> None:
    own = tmp_path / "own.toml"
    own.write_text('"step.result" = "After six weeks"\n')
    assert plate_words("en", own)("step.result") == "After six weeks"
    own.write_text('"step.reslut" = "After six weeks"\n')
    with refuses(ProblemCode.PLATE_CAPTION_KEY):
        plate_words("en", own)
    own.write_text('"step.result" = "{weeks} weeks"\n')
    with refuses(ProblemCode.PLATE_CAPTIONS):
        plate_words("en", own)


def test_every_language_says_everything() -> None:
    keys = plate_words("en").texts.keys()
    for language in LANGUAGES:
        words = plate_words(language)
        assert words.texts.keys() == keys
        for key in keys:
            assert words(key, time="1", count=2, letter="A", caption="x")


@pytest.mark.parametrize("given", ["Skin excised", "7=x", "=x"])
def test_a_caption_without_its_panel_is_a_usage_error(given: str) -> None:
    from click.testing import CliRunner

    result = CliRunner().invoke(cli, ["plate", "cache.usdc", "-o", "x.svg", "--caption", given])
    assert result.exit_code == 2
    assert given in result.output


@pytest.mark.parametrize("look_from", [(0.0, 0.0, -1.0), (1.0, 0.0, -0.2), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)])
def test_a_camera_inside_the_tissue_is_refused(cache: SkinCache, look_from: tuple[float, float, float]) -> None:
    """From below the skin, along it, from nowhere, and along what is up in the picture."""
    panel = PlatePanel("below", "plan", look_from=look_from, look_up=(0.0, 1.0, 0.0))
    with refuses(ProblemCode.PLATE_CAMERA) as problems:
        plate_panels(cache, Plate("mine", panels=(panel,)), [])
    assert problems[0].prim == "below"
    above = PlatePanel("above", "plan", look_from=(0.3, -0.5, 1.0), look_up=(0.0, 1.0, 0.0))
    assert plate_panels(cache, Plate("mine", panels=(above,)), [])


@pytest.mark.parametrize("size", [6.9, 24.5, float("nan")])
def test_text_that_no_page_prints_is_refused(size: float) -> None:
    with refuses(ProblemCode.PLATE_TEXT):
        plate_style("ink", text=size)


def test_sixty_labels_in_one_panel_are_refused(cache: SkinCache, font: PlateFont) -> None:
    top = float(cache.rest(cache.epochs[0])[:, 2].max())
    notes = tuple(PlateAnnotation(f"n{k}", "label", ((0.2 * k - 6.0, 5.0, top),), f"{k}") for k in range(60))
    request = PlateRequest((PlateRow(cache, chosen_steps(cache)),), {}, annotations=notes)
    with refuses(ProblemCode.PLATE_LABELS) as problems:
        plate_page(request, plate_style("ink"), plate_words("en"), font)
    assert problems[0].prim == "A"
    assert int(problems[0].value) >= 60
