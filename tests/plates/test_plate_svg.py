"""A plate as SVG: named layers, text that is text, lines and letters of sizes that are printed, the same bytes."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from PIL import Image

from lappet.drawing.quantity_scale import frame_peak, full_value
from lappet.drawing.skin_read import SkinCache
from lappet.drawing.skin_source import SCALARS
from lappet.plates.plate_cache import chosen_steps, compared_steps
from lappet.plates.plate_files import write_plate
from lappet.plates.plate_font import PlateFont
from lappet.plates.plate_page import PlatePage, plate_page
from lappet.plates.plate_request import PlateRequest, PlateRow
from lappet.plates.plate_steps import StepKind
from lappet.plates.plate_style import plate_style
from lappet.plates.plate_svg import plate_svg
from lappet.plates.plate_words import plate_words

POINT = 25.4 / 72.0
SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def ink(page: PlatePage, font: PlateFont) -> str:
    return plate_svg(page, plate_style("ink"), font, 300)


def test_a_plate_tells_the_steps_of_the_operation_in_order(page: PlatePage) -> None:
    kinds = [panel.step.kind for panel in page.panels]
    assert kinds[0] is StepKind.PLAN
    assert StepKind.SUTURED in kinds
    assert [panel.letter for panel in page.panels] == list("ABCDEFG"[: len(kinds)])
    times = [panel.step.time for panel in page.panels]
    assert times == sorted(set(times))


def test_ink_and_schematic_plates_have_no_image_and_a_wash_has_one_a_panel(page: PlatePage, font: PlateFont) -> None:
    for name, images in (("ink", 0), ("schematic", 0), ("wash", len(page.panels))):
        svg = plate_svg(page, plate_style(name), font, 72)
        assert len(ET.fromstring(svg).findall(f".//{SVG}image")) == images


def test_the_same_plate_gives_the_same_bytes(cache: SkinCache, ink: str, font: PlateFont) -> None:
    again = plate_page(
        PlateRequest((PlateRow(cache, chosen_steps(cache)),), {}), plate_style("ink"), plate_words("en"), PlateFont()
    )
    assert plate_svg(again, plate_style("ink"), font, 300) == ink


def test_captions_labels_and_letters_are_text(page: PlatePage, ink: str) -> None:
    texts = {"".join(each.itertext()) for each in ET.fromstring(ink).iter(f"{SVG}text")}
    assert {"Planned incisions", "planned incision", "A", "a"} <= texts
    assert set(page.texts()) <= texts


def test_lines_are_half_a_point_and_letters_seven_at_least(ink: str) -> None:
    widths = [float(each) for each in re.findall(r'stroke-width="([\d.]+)"', ink)]
    sizes = [float(each) for each in re.findall(r'font-size="([\d.]+)"', ink)]
    assert min(widths) >= 0.5 * POINT - 1e-3
    assert min(sizes) >= 7.0 * POINT - 1e-3


def test_layers_have_names_and_every_number_is_finite(ink: str) -> None:
    root = ET.fromstring(ink)
    label = "{http://www.inkscape.org/namespaces/inkscape}label"
    names = [group.get(label) for group in root.iter(f"{SVG}g") if group.get(label)]
    assert {"lines", "labels", "captions", "threads"} <= set(names)
    assert "nan" not in ink.lower().split("</style>")[1]


def test_letters_ride_on_the_tissue(page: PlatePage, cache: SkinCache) -> None:
    """Where a corner's letter stands on the last panel is where the solved skin has carried that place."""
    last = page.panels[-1]
    letters = {each.text: each.at for each in last.drawing.letters}
    assert letters
    for corner, kept in zip(last.scene.corners, last.scene.kept, strict=True):
        if corner.letter in letters:
            inset = 3.2 / last.drawing.projection.scale
            place = last.scene.on_skin(corner.inset(inset, kept)[None], last.step.time)
            assert last.drawing.projection.paper(place)[0][0] == pytest.approx(letters[corner.letter])


def test_panels_lie_side_by_side_on_the_page(page: PlatePage) -> None:
    assert page.size[0] == 174.0
    middles = np.array([panel.middle for panel in page.panels])
    boxes = [(m - 0.5 * np.asarray(page.panel), m + 0.5 * np.asarray(page.panel)) for m in middles]
    for k, (low, high) in enumerate(boxes):
        assert low.min() >= -1e-9
        assert (high <= np.asarray(page.size) + 1e-9).all()
        assert all((low >= other[1]).any() or (high <= other[0]).any() for other in boxes[:k])


def test_a_pdf_is_tagged_and_embeds_its_font(page: PlatePage, ink: str, font: PlateFont, tmp_path: Path) -> None:
    write_plate(ink, page.size, page.alt, font, tmp_path / "plate.pdf", 300)
    data = (tmp_path / "plate.pdf").read_bytes()
    assert data.startswith(b"%PDF")
    for part in (b"SourceSansPro", b"/StructTreeRoot", b"/Alt"):
        assert part in data
    for image in (b"/Subtype /Image", b"/Subtype/Image"):
        assert image not in data


def test_a_png_and_a_tiff_have_the_size_in_print(page: PlatePage, ink: str, font: PlateFont, tmp_path: Path) -> None:
    image = pytest.importorskip("PIL.Image")
    for name in ("plate.png", "plate.tiff"):
        write_plate(ink, page.size, page.alt, font, tmp_path / name, 150)
        with image.open(tmp_path / name) as picture:
            assert picture.size[0] == pytest.approx(174.0 / 25.4 * 150, abs=1.5)
            assert picture.info["dpi"][0] == pytest.approx(150, abs=0.1)
            assert np.asarray(picture.convert("L")).min() < 60  # something is drawn


def test_procedures_that_are_compared_are_drawn_at_one_scale(cache: SkinCache, font: PlateFont) -> None:
    steps = compared_steps(cache)
    rows = tuple(PlateRow(cache, steps, title) for title in ("first", "second"))
    page = plate_page(PlateRequest(rows, {}, columns=2), plate_style("schematic"), plate_words("en"), font)
    assert [panel.caption[0].split(":")[0] for panel in page.panels] == ["first", "first", "second", "second"]
    assert len({round(panel.drawing.projection.scale, 9) for panel in page.panels}) == 1
    assert {panel.step.time for panel in page.panels} == {cache.frames[0], steps[-1].time}


def test_a_map_has_a_key_whose_top_is_what_the_skin_reaches(cache: SkinCache, font: PlateFont) -> None:
    rows = (PlateRow(cache, chosen_steps(cache)),)
    mapped = next(name for name in SCALARS if cache.scalar(cache.epochs[-1], name, cache.frames[-1]) is not None)
    page = plate_page(PlateRequest(rows, {}, mapped=mapped), plate_style("ink"), plate_words("en"), font)
    peaks = [
        frame_peak(found)
        for panel in page.panels
        if (found := cache.scalar(cache.epoch_at(panel.step.time), mapped, panel.step.time)) is not None
    ]
    assert page.full == full_value(max(peaks))
    assert set(page.key) <= {"".join(each.itertext()) for each in ET.fromstring(svg_of(page, font)).iter(f"{SVG}text")}


def test_a_landmark_is_named_where_the_solve_has_carried_it(cache: SkinCache, font: PlateFont) -> None:
    label = "left apex"
    rows = (PlateRow(cache, chosen_steps(cache, (cache.frames[0], cache.frames[-1]))),)
    request = PlateRequest(rows, {}, labels=False, landmarks=(label,))
    page = plate_page(request, plate_style("schematic"), plate_words("en"), font)
    for panel in page.panels:
        (found,) = panel.labels
        place = cache.named_landmarks(panel.step.time)[label]
        assert found.text == label
        assert found.site == pytest.approx(panel.drawing.projection.paper(place[None])[0][0])


def svg_of(page: PlatePage, font: PlateFont) -> str:
    return plate_svg(page, plate_style("ink"), font, 72)


@pytest.mark.parametrize(
    ("size", "dpi"), [((150.0, 84.375), 25.4 * 640 / 150), ((174.0, 120.3), 200), ((85.0, 61.2), 300)]
)
def test_a_picture_has_no_seam(tmp_path: Path, font: PlateFont, size: tuple[float, float], dpi: float) -> None:
    width, height = (f"{each:.3f}" for each in size)
    svg = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}mm" height="{height}mm" viewBox="0 0 {width} {height}">'
        f'<rect width="{width}" height="{height}" fill="#fff"/>'
        f'<line x1="0" y1="0" x2="{width}" y2="{height}" stroke="#000" stroke-width="1.5"/></svg>'
    )
    write_plate(svg, size, "a diagonal", font, tmp_path / "plate.png", dpi)
    with Image.open(tmp_path / "plate.png") as picture:
        assert picture.size == tuple(round(side / 25.4 * dpi) for side in size)
        ink = 255.0 - np.asarray(picture.convert("L"), np.float64)
    at = (ink * np.arange(ink.shape[1])).sum(axis=1) / ink.sum(axis=1)
    steps = np.diff(at[20:-20])  # beyond, the line is cut by the border
    assert np.abs(steps - size[0] / size[1]).max() < 0.15
