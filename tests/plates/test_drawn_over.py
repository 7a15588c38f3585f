"""What is drawn over panels: hatching where it was undermined, the pull of hooks, ghosts, other operations, pens."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from lappet.core.problem_code import ProblemCode
from lappet.drawing.skin_read import SkinCache
from lappet.drawing.skin_source import StepEvent
from lappet.plates.feature_lines import LineKind
from lappet.plates.ghost_outline import VARIANTS
from lappet.plates.plate_cache import chosen_steps
from lappet.plates.plate_font import PlateFont
from lappet.plates.plate_page import PlatePage, plate_page
from lappet.plates.plate_request import PlateRequest, PlateRow
from lappet.plates.plate_scene import PlateScene, plate_scene
from lappet.plates.plate_steps import StepKind
from lappet.plates.plate_style import plate_style
from lappet.plates.plate_svg import plate_svg
from lappet.plates.plate_words import plate_words
from lappet.plates.pull_arrows import pull_arrows
from lappet.plates.undermined_hatch import thinned_marks, undermined_hatch
from lappet.procedure.plate import PLAN_PENS, PlatePanel
from refusals import refuses

SIZE = (54.0, 40.5)
SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def scene(cache: SkinCache) -> PlateScene:
    return plate_scene(cache, [step.time for step in chosen_steps(cache)], "oblique", SIZE)


def test_the_area_undermined_is_hatched_evenly_and_nowhere_else(
    scene: PlateScene, cache: SkinCache, monkeypatch: pytest.MonkeyPatch
) -> None:
    top = float(cache.rest(cache.epochs[0])[:, 2].max())
    half = np.array([14.0, 9.0])
    ring = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]]) * half
    area = np.column_stack([ring, np.full(5, top)])
    begun = cache.frames[0]
    monkeypatch.setattr(type(cache), "undermined_areas", lambda self, step: [area])
    events = (StepEvent("Undermine", "around", begun, begun),)
    monkeypatch.setattr(type(cache), "events", property(lambda self: events))
    lines = undermined_hatch(scene, begun, 2.0)
    assert {line.kind for line in lines} == {LineKind.UNDERMINED_HATCH}
    points = np.concatenate([line.points for line in lines])
    assert (np.abs(points[:, :2]) <= half + 1e-6).all()
    length = sum(float(np.linalg.norm(np.diff(line.points, axis=0), axis=1).sum()) for line in lines)
    assert length * 2.0 == pytest.approx(4.0 * half.prod(), rel=0.05)  # lines times their distance fill the area
    monkeypatch.setattr(type(cache), "events", property(lambda self: (replace(events[0], start=1e6),)))
    assert undermined_hatch(scene, begun, 2.0) == []


def test_what_is_thinned_is_hatched_across_the_other_way_inside_a_dotted_line_while_the_skin_is_laid_back(
    scene: PlateScene, cache: SkinCache, monkeypatch: pytest.MonkeyPatch
) -> None:
    top = float(cache.rest(cache.epochs[0])[:, 2].max())
    half = np.array([14.0, 9.0])
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]]) * half
    ring = np.vstack([np.linspace(a, b, 30, endpoint=False) for a, b in pairwise(corners)] + [corners[:1]])
    outline = np.column_stack([ring, np.full(len(ring), top)])
    begun = cache.frames[0]
    monkeypatch.setattr(type(cache), "thinned_areas", lambda self, step: {"thin": outline, "late": outline})
    events = (StepEvent("Thin", "thin", begun, begun + 2.0), StepEvent("Thin", "late", begun + 9.0, begun + 9.0))
    monkeypatch.setattr(type(cache), "events", property(lambda self: events))
    lines = thinned_marks(scene, begun, 2.0)
    hatch = [line.points for line in lines if line.kind is LineKind.THINNED_HATCH]
    border = np.concatenate([line.points for line in lines if line.kind is LineKind.THINNED])
    length = sum(float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum()) for points in hatch)
    assert length * 2.0 == pytest.approx(4.0 * half.prod(), rel=0.05)
    assert (np.abs(border[:, :2]) < half).all()
    assert np.abs(border[:, :2]).max(axis=0) == pytest.approx(half, abs=1.0)
    way = next(points[-1] - points[0] for points in hatch if len(points) > 4)
    assert float(way @ scene.axes[0]) * float(way @ scene.axes[1]) < 0.0  # from upper left to lower right
    assert thinned_marks(scene, begun + 2.0, 2.0) == []


def test_a_pull_points_where_the_hook_has_drawn_the_tissue(scene: PlateScene, cache: SkinCache) -> None:
    raised = next(step for step in chosen_steps(cache) if step.kind is StepKind.RAISED)
    projection = scene.projection(SIZE)
    arrows = pull_arrows(scene, raised.time, projection)
    hooks = cache.hooks(raised.time)
    assert 1 <= len(arrows) <= int(hooks.active.sum())
    held = np.flatnonzero(hooks.active)
    first = [next(cache.hooks(t).ends[k, 0] for t in cache.frames if cache.hooks(t).active[k]) for k in held]
    begins, ends = (projection.paper(np.array(each))[0] for each in (first, hooks.ends[held, 0]))
    ways = (ends - begins) / np.linalg.norm(ends - begins, axis=1)[:, None]
    for arrow in arrows:
        way = (arrow[1] - arrow[0]) / np.linalg.norm(arrow[1] - arrow[0])
        nearest = int(np.argmin(np.linalg.norm(ends - arrow[0], axis=1)))
        assert way == pytest.approx(ways[nearest], abs=1e-6)


def page_of(cache: SkinCache, font: PlateFont, **asked: object) -> PlatePage:
    steps = asked.pop("steps", chosen_steps(cache)[:2])
    request = PlateRequest((PlateRow(cache, steps),), {}, **asked)  # type: ignore[arg-type]
    return plate_page(request, plate_style("schematic"), plate_words("en"), font)


def test_other_operations_are_drawn_over_it_each_with_a_line_and_a_name_of_its_own(
    cache: SkinCache, font: PlateFont
) -> None:
    others = tuple(PlateRow(cache, chosen_steps(cache), title) for title in ("first", "second"))
    page = page_of(cache, font, overlaid=others, labels=False)
    kinds = {stroke.kind for panel in page.panels for stroke in panel.drawing.strokes}
    assert set(VARIANTS[:2]) <= kinds
    assert [label.text for panel in page.panels for label in panel.labels] == ["first", "second"]
    own = plate_style("schematic").pens
    assert len({(own[kind].color, own[kind].dashes) for kind in VARIANTS}) == len(VARIANTS)
    plan = page.panels[0].drawing.strokes
    first, mine = (
        np.concatenate([stroke.points for stroke in plan if stroke.kind is kind])
        for kind in (VARIANTS[0], LineKind.PLAN)
    )
    # The same operation lies upon itself.
    gaps = np.linalg.norm(first[:, None] - mine[None], axis=2).min(axis=1)
    assert np.median(gaps) < 0.2


def test_more_operations_than_can_be_told_apart_are_refused(cache: SkinCache, font: PlateFont) -> None:
    with refuses(ProblemCode.PLATE_OVERLAY) as problems:
        page_of(cache, font, overlaid=(PlateRow(cache, chosen_steps(cache), "x"),) * 4)
    assert problems[0].value == "4"


def test_a_filled_ghost_is_translucent_and_lies_where_the_wound_was(cache: SkinCache, font: PlateFont) -> None:
    steps = chosen_steps(cache)
    raised = next(step for step in steps if step.kind is StepKind.RAISED)
    ghost = PlatePanel("after", "result", ghost="raised", ghost_filled=True)
    shown = (replace(steps[-1], panel=ghost, ghost=raised.time), replace(raised, panel=PlatePanel("r", "raised")))
    page = page_of(cache, font, steps=shown, labels=False)
    after, opened = page.panels
    assert after.drawing.ghosts
    low, high = (np.concatenate([ring for area in after.drawing.ghosts for ring in area.rings]) for _ in range(2))
    wound = np.concatenate([ring for area in opened.drawing.areas if area.kind.value != "skin" for ring in area.rings])
    assert low.min(axis=0) == pytest.approx(wound.min(axis=0), abs=0.5)
    assert high.max(axis=0) == pytest.approx(wound.max(axis=0), abs=0.5)
    root = ET.fromstring(plate_svg(page, plate_style("schematic"), font, 72))
    clear = [path for path in root.iter(f"{SVG}path") if path.get("fill-opacity")]
    assert len(clear) == len(after.drawing.ghosts)


@pytest.mark.parametrize("pen", PLAN_PENS)
def test_planned_cuts_are_drawn_with_the_pen_that_is_asked_for(pen: str) -> None:
    own, plain = (plate_style("schematic", plan_pen=each).pens[LineKind.PLAN] for each in (pen, ""))  # type: ignore[arg-type]
    if pen in ("dashed", "dotted"):
        assert own.dashes
    elif pen == "marker":
        assert own.width > 2.0 * plain.width
    else:
        assert own == plain


def test_every_face_of_a_collection_but_one_is_passed_over(tmp_path: Path) -> None:
    from fontTools.ttLib import TTCollection, TTFont

    faces = TTCollection()
    for name in ("Some Sans JP", "Some Sans SC"):
        face = TTFont(PlateFont().path)
        for record in face["name"].names:
            if record.nameID in (1, 16):
                record.string = name
        faces.fonts.append(face)
    faces.save(tmp_path / "faces.ttc")
    assert PlateFont(tmp_path / "faces.ttc").family == "Some Sans SC"


def test_a_chinese_plate_takes_an_installed_font_and_the_best_of_several(tmp_path: Path) -> None:
    from lappet.plates.installed_fonts import chinese_font

    assert chinese_font([tmp_path, tmp_path / "nowhere"]) is None
    (tmp_path / "deep").mkdir()
    for name in ("SourceHanSans-Regular.ttc", "deep/NotoSansSC-Regular.otf", "Arial.ttf"):
        (tmp_path / name).write_bytes(b"")
    assert chinese_font([tmp_path]) == tmp_path / "deep" / "NotoSansSC-Regular.otf"
