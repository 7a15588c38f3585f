"""A painted plate: what Blender paints lies where the lines are, and what it shows is not drawn a second time."""

from __future__ import annotations

import io
import sys
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from scipy.ndimage import binary_erosion, zoom

from lappet.core.problem_code import ProblemCode
from lappet.drawing.skin_read import SkinCache
from lappet.output.render import PYTHON_VARIABLE
from lappet.plates.filled_areas import AreaKind
from lappet.plates.painting import page_paintings, samples_at
from lappet.plates.plate_cache import chosen_steps
from lappet.plates.plate_font import PlateFont
from lappet.plates.plate_page import PlatePage, plate_page
from lappet.plates.plate_panel import PagePanel
from lappet.plates.plate_request import PlateRequest, PlateRow
from lappet.plates.plate_steps import PlateStep, StepKind
from lappet.plates.plate_style import plate_style
from lappet.plates.plate_svg import plate_svg
from lappet.plates.plate_words import plate_words
from lappet.procedure.plate import PlatePanel
from refusals import refuses

SVG = "{http://www.w3.org/2000/svg}"
STYLE = plate_style("painted")
DPI = 50.0


@pytest.fixture(scope="module")
def painted_page(cache: SkinCache, font: PlateFont) -> PlatePage:
    """The open wound from the plate's view, and cropped from above."""
    time = next(step.time for step in chosen_steps(cache) if step.kind is StepKind.RAISED)
    crop = PlatePanel("crop", time=time, view="top", at=(0.0, 6.0, 0.0), across=30.0)
    steps = (PlateStep(time, StepKind.RAISED), PlateStep(time, StepKind.RAISED, crop))
    request = PlateRequest((PlateRow(cache, steps),), {}, labels=False)
    return plate_page(request, STYLE, plate_words("en"), font)


@pytest.fixture(scope="module")
def paintings(painted_page: PlatePage) -> dict[int, bytes]:
    return page_paintings(painted_page, STYLE, None, DPI)


def pixels(png: bytes) -> NDArray[np.uint8]:
    return np.asarray(Image.open(io.BytesIO(png)).convert("RGBA"))


def wound(panel: PagePanel, shape: tuple[int, int]) -> NDArray[np.bool_]:
    """Where the line drawing has the inside of the wound, as a picture of a size."""
    inside = [list(AreaKind).index(kind) for kind in AreaKind if kind is AreaKind.BED or kind.startswith("wall")]
    mask = np.isin(panel.drawing.pixels.kind, inside).astype(np.float64)
    factors = (shape[0] / mask.shape[0], shape[1] / mask.shape[1])
    return zoom(mask, factors, order=1, grid_mode=True, mode="nearest") > 0.5


def test_the_painted_wound_lies_where_the_lines_have_it(painted_page: PlatePage, paintings: dict[int, bytes]) -> None:
    for k, panel in enumerate(painted_page.panels):
        picture = pixels(paintings[k]).astype(float)
        red = picture[..., 0] > 1.5 * picture[..., 1]
        drawn = wound(panel, red.shape)
        assert drawn.sum() > 60
        assert red[binary_erosion(drawn)].mean() > 0.9
        assert red[binary_erosion(~drawn, iterations=2)].mean() < 0.01


def test_skin_goes_on_to_the_border_of_a_painting(paintings: dict[int, bytes]) -> None:
    for png in paintings.values():
        assert pixels(png)[..., 3].min() == 255


def test_the_same_panel_is_painted_alike(painted_page: PlatePage, paintings: dict[int, bytes]) -> None:
    again = page_paintings(painted_page, STYLE, None, DPI)
    assert again.keys() == paintings.keys()
    for k, png in again.items():
        # Pictures of two seeds differ by 2.0 of 255 on the mean. Two of one seed were the same to the bit but once in
        # CI; why they were not was not found.
        assert np.abs(pixels(png).astype(float) - pixels(paintings[k])).mean() < 0.1


def test_a_darker_tone_paints_darker_skin_and_the_same_wound(
    painted_page: PlatePage, paintings: dict[int, bytes]
) -> None:
    dark = page_paintings(painted_page, plate_style("painted", 9), 9, DPI)
    before, after = pixels(paintings[0]).astype(float)[..., 0], pixels(dark[0]).astype(float)[..., 0]
    inside = wound(painted_page.panels[0], before.shape)
    outside = binary_erosion(~inside, iterations=3)
    assert after[outside].mean() < 0.5 * before[outside].mean()
    assert after[binary_erosion(inside)].mean() > 0.7 * before[binary_erosion(inside)].mean()


def test_wound_edges_threads_and_hooks_are_not_drawn_over_a_painting(
    painted_page: PlatePage, paintings: dict[int, bytes], font: PlateFont
) -> None:
    def layers(below: dict[int, bytes]) -> dict[str, int]:
        root = ET.fromstring(plate_svg(painted_page, STYLE, font, DPI, paintings=below))
        groups = [each for each in root.findall(f"{SVG}g") if each.get("id", "").startswith("layer-")]
        return {each.get("id", ""): sum(1 for _ in each.iter(f"{SVG}path")) for each in groups}

    bare, painted = layers({}), layers(paintings)
    assert bare["layer-lines"] > painted.get("layer-lines", 0)
    assert "layer-areas" in bare
    assert "layer-areas" not in painted
    images = ET.fromstring(plate_svg(painted_page, STYLE, font, DPI, paintings=paintings)).iter(f"{SVG}image")
    assert len(list(images)) == len(painted_page.panels)


def test_a_cross_section_is_not_painted(cache: SkinCache, font: PlateFont) -> None:
    section = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0)
    request = PlateRequest((PlateRow(cache, chosen_steps(cache)),), {}, section=section)
    page = plate_page(request, STYLE, plate_words("en"), font)
    painted = page_paintings(page, STYLE, None, 20.0)
    assert [k in painted for k in range(len(page.panels))] == [not panel.section for panel in page.panels]
    assert not all(panel.section for panel in page.panels)


def test_a_painting_without_blender_is_refused(
    painted_page: PlatePage, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    python = tmp_path / "python"
    python.write_text(f"#!/bin/sh\nexec {sys.executable} -S -I -c 'import bpy'\n")
    python.chmod(0o755)
    monkeypatch.setenv(PYTHON_VARIABLE, str(python))
    with refuses(ProblemCode.RENDER_NO_BPY):
        page_paintings(painted_page, STYLE, None, DPI)


def test_a_dense_picture_needs_fewer_samples_a_pixel() -> None:
    assert [samples_at(dpi) for dpi in (72, 150, 200, 300, 600, 1000)] == [6, 6, 6, 4, 3, 3]
