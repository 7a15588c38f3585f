"""A plate of the procedure shows the steps, crops, insets and ghosts that it names."""

from __future__ import annotations

import numpy as np
import pytest

import synthetic_skin_cache as synthetic
from lappet.core.problem import Problem
from lappet.core.problem_code import ProblemCode
from lappet.drawing.skin_read import SkinCache
from lappet.plates.feature_lines import LineKind
from lappet.plates.planned_panels import plate_panels
from lappet.plates.plate_cache import open_cache
from lappet.plates.plate_font import PlateFont
from lappet.plates.plate_page import PlatePage, plate_page
from lappet.plates.plate_request import PlateRequest, PlateRow
from lappet.plates.plate_style import plate_style
from lappet.plates.plate_svg import plate_svg
from lappet.plates.plate_words import plate_words
from lappet.procedure.plate import Plate, PlateAnnotation, PlatePanel
from refusals import refuses


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> SkinCache:
    """The incision on a coarse mesh: what is asked for here does not depend on it."""
    return open_cache(synthetic.write_cache(tmp_path_factory.mktemp("coarse"), step=4.0))


def page_of(cache: SkinCache, font: PlateFont, plate: Plate) -> PlatePage:
    request = PlateRequest((PlateRow(cache, plate_panels(cache, plate, [])),), {})
    return plate_page(request, plate_style("schematic"), plate_words("en"), font)


def test_steps_become_the_frames_that_show_them(cache: SkinCache) -> None:
    notes: list[Problem] = []
    plate = Plate("steps", panels=tuple(PlatePanel(step, step) for step in ("plan", "cut", "raised", "sutured")))
    plan, cut, raised, sutured = (step.time for step in plate_panels(cache, plate, notes))
    assert (plan, raised) == (1.0, float(synthetic.LIFTED))
    assert synthetic.INCISED <= cut < raised
    assert sutured >= synthetic.SUTURED
    assert notes == []


def test_the_result_is_the_sutured_wound_where_both_look_alike_and_is_shown_once(cache: SkinCache) -> None:
    (alone,) = plate_panels(cache, Plate("one", panels=(PlatePanel("end", "result"),)), [])
    both = Plate("both", panels=(PlatePanel("closed", "sutured"), PlatePanel("end", "result")))
    assert [step.time for step in plate_panels(cache, both, [])] == [alone.time]


def test_a_plate_without_panels_shows_the_steps_of_the_operation(cache: SkinCache) -> None:
    assert len(plate_panels(cache, Plate("empty"), [])) >= 4


def test_a_crop_shows_as_much_across_as_it_says(cache: SkinCache, font: PlateFont) -> None:
    plate = Plate("close", panels=(PlatePanel("detail", time=1.0, at=(10.0, 5.0, 0.0), across=16.0),))
    (panel,) = page_of(cache, font, plate).panels
    across = np.array([[2.0, 5.0, 0.0], [18.0, 5.0, 0.0], [10.0, 5.0, 0.0]])
    axis = panel.scene.view.axes[0]
    ends = across[2] + np.outer((-8.0, 8.0), axis)
    paper, _ = panel.drawing.projection.paper(np.vstack([ends, across[2]]))
    assert abs(paper[1, 0] - paper[0, 0]) == pytest.approx(panel.size[0], rel=1e-6)
    np.testing.assert_allclose(paper[2], 0.0, atol=1e-9)
    assert panel.bar > 0.0


def test_an_inset_stands_in_its_panel_and_hides_what_is_below(cache: SkinCache, font: PlateFont) -> None:
    detail = PlatePanel("detail", time=7.0, at=(0.0, 6.0, 0.0), across=10.0, inset_of="open")
    page = page_of(cache, font, Plate("two", panels=(PlatePanel("open", time=7.0), detail)))
    host, inset = page.panels
    assert inset.line is not None
    low, high = (inset.middle - host.middle + sign * 0.5 * np.asarray(inset.size) for sign in (-1.0, 1.0))
    assert (low >= -0.5 * np.asarray(host.size)).all()
    assert (high <= 0.5 * np.asarray(host.size)).all()
    for stroke in host.drawing.strokes:
        assert not ((stroke.points > low + 1e-6) & (stroke.points < high - 1e-6)).all(axis=1).any(), stroke.kind
    assert page.alt.count("A:") <= 1
    svg = plate_svg(page, plate_style("schematic"), font, 100.0)
    assert svg == plate_svg(page, plate_style("schematic"), font, 100.0)


def test_a_panel_and_an_inset_are_cut_in_planes_of_their_own(cache: SkinCache, font: PlateFont) -> None:
    across = {"section_at": (0.0, 0.0, 0.0), "section_normal": (1.0, 0.0, 0.0)}
    detail = PlatePanel("detail", time=7.0, at=(0.0, 0.0, 0.0), across=12.0, inset_of="open", **across)  # type: ignore[arg-type]
    panels = (
        PlatePanel("plan", time=1.0),
        PlatePanel("open", time=7.0),
        detail,
        PlatePanel("cut", time=7.0, **across),  # type: ignore[arg-type]
        PlatePanel("whole", time=1.0),
    )
    plan, host, inset, cut, _ = page_of(cache, font, Plate("cuts", panels=panels)).panels
    assert [panel.section for panel in (plan, host, inset, cut)] == [False, False, True, True]
    for panel in (plan, host):  # the line of the plane, at right angles to the x axis through the middle
        line = np.vstack([each.points for each in panel.drawing.strokes if each.kind is LineKind.SECTION])
        ends = panel.drawing.projection.paper(np.array([[0.0, -15.0, 0.0], [0.0, 15.0, 0.0]]))[0]
        way = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
        off = (line - ends[0]) - np.outer((line - ends[0]) @ way, way)
        assert np.linalg.norm(off, axis=1).max() < 1.5
    assert cut.drawing.areas
    assert inset.size[0] / 12.0 == pytest.approx(inset.drawing.projection.scale, rel=1e-6)


def test_a_ghost_is_the_outline_of_the_other_state(cache: SkinCache, font: PlateFont) -> None:
    plain = PlatePanel("end", "sutured")
    through = PlatePanel("end", "sutured", ghost="raised")
    (without,), (with_ghost,) = (page_of(cache, font, Plate("g", panels=(each,))).panels for each in (plain, through))
    assert not [each for each in without.drawing.strokes if each.kind is LineKind.GHOST]
    ghosts = np.vstack([each.points for each in with_ghost.drawing.strokes if each.kind is LineKind.GHOST])
    gape = synthetic.opening(synthetic.LIFTED) * with_ghost.drawing.projection.scale
    assert np.ptp(ghosts[:, 1]) > gape


def test_a_step_that_the_operation_lacks_is_left_out_and_said(cache: SkinCache) -> None:
    notes: list[Problem] = []
    panels = (PlatePanel("a", "plan"), PlatePanel("b", "placed"))
    placed = [step for step in plate_panels(cache, Plate("few", panels=panels), []) if step.panel is panels[1]]
    plate_panels(cache, Plate("few", panels=panels), notes)
    assert (notes == []) == bool(placed)


@pytest.mark.parametrize(
    ("panels", "annotations", "code"),
    [
        ((PlatePanel("a", time=99.0),), (), ProblemCode.PLATE_CACHE),
        ((PlatePanel("a", "plan"), PlatePanel("b", "cut", inset_of="c")), (), ProblemCode.PLATE_INSET),
        ((PlatePanel("a", "plan"), PlatePanel("b", "cut", inset_of="b")), (), ProblemCode.PLATE_INSET),
        ((PlatePanel("a", "plan", at=(0.0, 0.0, 0.0)),), (), ProblemCode.PLATE_CROP),
        (
            (PlatePanel("a", "plan"),),
            (PlateAnnotation("n", "label", ((0.0, 0.0, 0.0),), panels=("z",)),),
            ProblemCode.PLATE_PANEL,
        ),
    ],
)
def test_what_no_plate_can_show_is_refused(
    cache: SkinCache,
    panels: tuple[PlatePanel, ...],
    annotations: tuple[PlateAnnotation, ...],
    code: ProblemCode,
) -> None:
    with refuses(code):
        plate_panels(cache, Plate("bad", panels=panels, annotations=annotations), [])
