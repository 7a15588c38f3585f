"""A section shows the layers of the tissue as thick as they are, and its pieces apart."""

from __future__ import annotations

import numpy as np
import pytest

from lappet.anatomy.tissue_kind import KINDS
from lappet.anatomy.tissue_layers import TissueLayers
from lappet.drawing.deep_bed import BED_GAP
from lappet.drawing.framing import half_angles
from lappet.drawing.section_plane import SectionPlane
from lappet.drawing.skin_read import SkinCache
from lappet.plates.filled_areas import WALL_AREAS, AreaKind, wall_kinds
from lappet.plates.plate_cache import chosen_steps
from lappet.plates.plate_scene import PlateScene, plate_scene
from lappet.plates.plate_style import STYLES, PlateStyle
from lappet.plates.section_drawing import section_drawing, section_line, section_projection

SIZE = (54.0, 40.5)
ACROSS = SectionPlane.of((0.0, 0.0, 0.0, 1.0, 0.0, 0.0))


@pytest.fixture(scope="module")
def scene(cache: SkinCache) -> PlateScene:
    return plate_scene(cache, [step.time for step in chosen_steps(cache)], "oblique", SIZE)


def test_whole_tissue_is_as_thick_in_the_section_as_it_is(scene: PlateScene, cache: SkinCache) -> None:
    projection = section_projection(scene, ACROSS, SIZE)
    drawing = section_drawing(scene, ACROSS, projection, cache.frames[0])
    points = cache.positions(cache.epochs[0], cache.frames[0])
    thickness = float(np.ptp(points[np.abs(points[:, 0]) < 3.0, 2]))
    pixel = float(drawing.pixels.y[1] - drawing.pixels.y[0])
    tall = (drawing.pixels.kind >= 0).sum(axis=0).max() * pixel / projection.scale
    assert tall == pytest.approx(thickness, abs=2.0 * pixel / projection.scale)
    assert half_angles(SIZE)[0] > projection.half_width  # without perspective


def test_a_cut_parts_the_section(scene: PlateScene, cache: SkinCache) -> None:
    projection = section_projection(scene, ACROSS, SIZE)
    whole = section_drawing(scene, ACROSS, projection, cache.frames[0])
    cut = next(step.time for step in chosen_steps(cache) if cache.epoch_at(step.time).name != cache.epochs[0].name)
    parted = section_drawing(scene, ACROSS, projection, cut)

    def pieces(drawing: object) -> int:
        middle = (drawing.pixels.kind >= 0).any(axis=0)  # type: ignore[attr-defined]
        return int((np.diff(np.concatenate([[0], middle.astype(int)])) == 1).sum())

    assert pieces(whole) == 1
    assert pieces(parted) == 2


def test_the_line_of_the_section_lies_in_its_plane(scene: PlateScene, cache: SkinCache) -> None:
    lines = section_line(scene, ACROSS, cache.frames[0])
    assert lines
    for line in lines:
        assert np.abs(ACROSS.beyond(line.points)).max() < 1e-4


def test_areas_of_a_section_are_layers(scene: PlateScene, cache: SkinCache) -> None:
    drawing = section_drawing(scene, ACROSS, section_projection(scene, ACROSS, SIZE), cache.frames[-1])
    kinds = {tuple(AreaKind)[k] for k in np.unique(drawing.pixels.kind) if k >= 0}
    assert kinds <= {AreaKind.WALL_SKIN, AreaKind.WALL_FAT, AreaKind.WALL_DEEP}
    assert kinds


def test_each_kind_of_tissue_is_an_area_of_its_own_in_the_order_of_its_depth() -> None:
    order = ("skin", "fat", "fascia", "muscle", "cartilage")
    kinds = np.array([KINDS.index(name) for name in order], np.int32)
    layers = TissueLayers(np.zeros(5, np.int32), np.arange(5.0), kinds)
    found = wall_kinds(np.arange(5) + 0.5, np.zeros(5, np.int64), layers)
    assert [tuple(AreaKind)[k] for k in found] == [AreaKind(f"wall-{name}") for name in order]


def luminance(color: str) -> float:
    """Relative luminance of #rrggbb (WCAG 2.2)."""
    levels = np.array([int(color[k : k + 2], 16) for k in (1, 3, 5)]) / 255.0
    linear = np.where(levels <= 0.04045, levels / 12.92, ((levels + 0.055) / 1.055) ** 2.4)
    return float(linear @ (0.2126, 0.7152, 0.0722))


@pytest.mark.parametrize("style", STYLES.values(), ids=STYLES)
def test_cartilage_and_fascia_are_pale_and_muscle_is_dark_in_every_style(style: PlateStyle) -> None:
    muscle = luminance(style.fills[AreaKind.WALL_MUSCLE])
    for kind in (AreaKind.WALL_CARTILAGE, AreaKind.WALL_FASCIA):
        assert (luminance(style.fills[kind]) + 0.05) / (muscle + 0.05) > 1.4
    walls = {style.fills[kind] for kind in WALL_AREAS.values()}
    assert len(walls) == len(set(WALL_AREAS.values()))


def test_what_the_tissue_lies_on_is_a_band_below_it(scene: PlateScene, cache: SkinCache) -> None:
    projection = section_projection(scene, ACROSS, SIZE)
    cut = next(step.time for step in chosen_steps(cache) if cache.epoch_at(step.time).name != cache.epochs[0].name)
    drawing = section_drawing(scene, ACROSS, projection, cut)
    rings = [area.rings[0] for area in drawing.areas if area.kind is AreaKind.BED]
    first = cache.epochs[0]
    low = cache.rest(first)[np.unique(first.triangles)][:, 2].min()
    top, bottom = min(ring[:, 1].min() for ring in rings), max(ring[:, 1].max() for ring in rings)
    at = projection.paper(np.array([[0.0, 0.0, low - BED_GAP]]))[0][0, 1]
    pixel = float(drawing.pixels.y[1] - drawing.pixels.y[0])
    assert top == pytest.approx(at, abs=pixel)
    assert bottom - top == pytest.approx(5.0, abs=2.0 * pixel)
    assert np.ptp(np.concatenate(rings)[:, 0]) == pytest.approx(SIZE[0], abs=2.0 * pixel)  # under all of the picture
