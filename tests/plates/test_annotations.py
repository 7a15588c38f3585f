"""Annotations ride on the solved tissue and measure it; what cannot stand on a panel is said."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import synthetic_skin_cache as synthetic
from lappet.core.problem_code import ProblemCode
from lappet.drawing.skin_read import SkinCache
from lappet.plates.plate_cache import open_cache
from lappet.plates.plate_font import PlateFont
from lappet.plates.plate_page import PlatePage, plate_page
from lappet.plates.plate_panel import PagePanel
from lappet.plates.plate_request import PlateRequest, PlateRow
from lappet.plates.plate_steps import PlateStep, StepKind
from lappet.plates.plate_style import plate_style
from lappet.plates.plate_words import plate_words
from lappet.plates.skin_anchors import SkinAnchors
from lappet.procedure.plate import AnnotationKind, PlateAnnotation, PlatePanel
from refusals import refuses

WHOLE = PlateStep(1.0, StepKind.PLAN, PlatePanel("whole", time=1.0))
OPEN = PlateStep(float(synthetic.LIFTED), StepKind.RAISED, PlatePanel("open", time=float(synthetic.LIFTED)))


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> SkinCache:
    """The incision on a coarse mesh: what is asked for here does not depend on it."""
    return open_cache(synthetic.write_cache(tmp_path_factory.mktemp("coarse"), step=4.0))


def drawn(cache: SkinCache, font: PlateFont, steps: tuple[PlateStep, ...], *notes: PlateAnnotation) -> PlatePage:
    request = PlateRequest((PlateRow(cache, steps),), {}, labels=False, letters=False, annotations=notes)
    return plate_page(request, plate_style("ink"), plate_words("en"), font)


def only(page: PlatePage) -> PagePanel:
    (panel,) = page.panels
    return panel


def test_a_length_on_whole_skin_is_that_of_the_formula(cache: SkinCache, font: PlateFont) -> None:
    scar = PlateAnnotation("scar", "length", ((-30.0, 20.0, 0.0), (0.0, 20.0, 0.0), (0.0, 30.0, 0.0)))
    (measure,) = only(drawn(cache, font, (WHOLE,), scar)).notes.measures
    assert measure.text == "40 mm"


def test_a_distance_across_the_wound_grows_by_its_gape(cache: SkinCache, font: PlateFont) -> None:
    width = PlateAnnotation("width", "distance", ((0.0, -9.0, 0.0), (0.0, 9.0, 0.0)))
    places = np.array(width.anchors)
    there = synthetic.deform(places + np.array([[0, -1e-9, 0], [0, 1e-9, 0]]), OPEN.time, slit=True)
    expected = float(np.linalg.norm(there[1] - there[0]))
    whole, opened = drawn(cache, font, (WHOLE, OPEN), width).panels
    assert [each.text for each in whole.notes.measures] == ["18 mm"]
    assert [each.text for each in opened.notes.measures] == [f"{expected:.0f} mm"]
    assert expected > 22.0


@pytest.mark.parametrize("angle", [30.0, 60.0, 90.0, 120.0])
def test_an_angle_is_that_between_its_anchors(cache: SkinCache, font: PlateFont, angle: float) -> None:
    turn = np.radians(angle)
    ends = ((20.0, 20.0, 0.0), (0.0, 20.0, 0.0), (15.0 * np.cos(turn), 20.0 + 15.0 * np.sin(turn), 0.0))
    (measure,) = only(drawn(cache, font, (WHOLE,), PlateAnnotation("turn", "angle", ends))).notes.measures
    assert measure.text == f"{angle:.0f}°"


def test_a_dragged_label_stays_where_it_was_put_beside_its_tissue(cache: SkinCache, font: PlateFont) -> None:
    note = PlateAnnotation("scar", "label", ((0.0, 10.0, 0.0),), "old scar", offset=(9.0, -6.0))
    for panel in drawn(cache, font, (WHOLE, OPEN), note).panels:
        (label,) = panel.notes.placed
        at, _ = SkinAnchors(cache).at(np.array(note.anchors), panel.step.time)
        site = panel.drawing.projection.paper(at)[0][0]
        np.testing.assert_allclose(label.site, site, atol=1e-9)
        np.testing.assert_allclose(label.port - label.site, (9.0, -6.0), atol=1e-9)


def test_an_annotation_stands_on_the_panels_that_it_names(cache: SkinCache, font: PlateFont) -> None:
    note = PlateAnnotation("pivot", "pivot", ((10.0, 10.0, 0.0),), "turns here", panels=("open",))
    whole, opened = drawn(cache, font, (WHOLE, OPEN), note).panels
    assert not whole.notes.pivots
    assert len(opened.notes.pivots) == 1
    assert [label.text for label in opened.labels] == ["turns here"]


def test_an_arrow_runs_where_the_solve_carries_its_anchor(cache: SkinCache, font: PlateFont) -> None:
    note = PlateAnnotation("way", "arrow", ((0.0, 3.0, 0.0),), panels=("whole",))
    whole, _ = drawn(cache, font, (WHOLE, OPEN), note).panels
    (way,) = whole.notes.arrows
    ends = [SkinAnchors(cache).at(np.array(note.anchors), time)[0] for time in (WHOLE.time, OPEN.time)]
    paper = [whole.drawing.projection.paper(each)[0][0] for each in ends]
    np.testing.assert_allclose(way[[0, -1]], paper, atol=1e-9)


def test_an_anchor_beside_the_skin_is_refused_with_its_distance(cache: SkinCache, font: PlateFont) -> None:
    note = PlateAnnotation("adrift", "label", ((0.0, 10.0, 7.0),), "in the air")
    with refuses(ProblemCode.PLATE_ANCHOR_OFF) as problems:
        drawn(cache, font, (WHOLE,), note)
    assert problems[0].prim == "adrift"
    assert "7.0 mm" in problems[0].message


def test_an_annotation_that_is_out_of_the_picture_is_left_out_and_said(cache: SkinCache, font: PlateFont) -> None:
    close = PlateStep(1.0, StepKind.PLAN, PlatePanel("close", time=1.0, at=(0.0, 0.0, 0.0), across=10.0))
    note = PlateAnnotation("far", "label", ((40.0, 30.0, 0.0),), "far away", panels=("close",))
    (panel,) = drawn(cache, font, (close,), note).panels
    assert [each.code for each in panel.notes.notes] == [ProblemCode.PLATE_ANCHOR_HIDDEN]
    assert not panel.labels


def test_a_font_without_a_character_of_an_annotation_is_refused(
    cache: SkinCache, font: PlateFont, tmp_path: Path
) -> None:
    with refuses(ProblemCode.PLATE_FONT_LACKS):
        drawn(cache, font, (WHOLE,), PlateAnnotation("a", "label", ((0.0, 10.0, 0.0),), "皮瓣"))


@pytest.mark.parametrize(
    ("kind", "anchors"),
    [
        ("length", ((-20.0, 12.0, 0.0), (0.0, 12.0, 0.0))),
        ("distance", ((-20.0, 12.0, 0.0), (0.0, 12.0, 0.0))),
        ("angle", ((-20.0, 12.0, 0.0), (0.0, 12.0, 0.0), (0.0, 25.0, 0.0))),
        ("arrow", ((-20.0, 12.0, 0.0), (0.0, 12.0, 0.0))),
    ],
)
def test_a_dragged_measure_keeps_its_distance_from_the_first_anchor(
    cache: SkinCache, font: PlateFont, kind: AnnotationKind, anchors: tuple[tuple[float, float, float], ...]
) -> None:
    note = PlateAnnotation("note", kind, anchors, "text", offset=(5.0, -4.0))
    panel = only(drawn(cache, font, (WHOLE,), note))
    (measure,) = panel.notes.measures
    begin, _ = panel.drawing.projection.paper(np.array(anchors[:1]))
    np.testing.assert_allclose(measure.at - begin[0], (5.0, -4.0), atol=1e-4)
