"""Sections are measured and labeled: what an annotation says of a plane is what the tissue has there."""

from __future__ import annotations

import numpy as np
import pytest

from lappet.core.problem_code import ProblemCode
from lappet.drawing.section_plane import SectionPlane
from lappet.drawing.skin_read import SkinCache
from lappet.plates.annotations import AnnotationDrawer, DrawnAnnotations
from lappet.plates.feature_lines import LineKind
from lappet.plates.measures import dimension
from lappet.plates.plate_cache import chosen_steps
from lappet.plates.plate_font import PlateFont
from lappet.plates.plate_page import plate_page
from lappet.plates.plate_request import PlateRequest, PlateRow
from lappet.plates.plate_scene import PlateScene, plate_scene
from lappet.plates.plate_style import plate_style
from lappet.plates.plate_words import plate_words
from lappet.plates.section_drawing import section_drawing, section_projection
from lappet.plates.section_lines import section_strokes
from lappet.plates.section_measures import dissection_depth
from lappet.procedure.plate import PlateAnnotation

SIZE = (54.0, 40.5)
ACROSS = SectionPlane.of((0.0, 0.0, 0.0, 1.0, 0.0, 0.0))


@pytest.fixture(scope="module")
def scene(cache: SkinCache) -> PlateScene:
    return plate_scene(cache, [step.time for step in chosen_steps(cache)], "oblique", SIZE)


def top(scene: PlateScene) -> float:
    return float(scene.source.rest(scene.source.epochs[0])[:, 2].max())


def noted(scene: PlateScene, *notes: PlateAnnotation) -> DrawnAnnotations:
    time = scene.source.frames[0]
    drawing = section_drawing(scene, ACROSS, section_projection(scene, ACROSS, SIZE), time)
    return AnnotationDrawer(scene, drawing, "cut", (), ACROSS).draw(notes)


def test_a_depth_is_the_thickness_of_the_tissue_below(scene: PlateScene, cache: SkinCache) -> None:
    points = cache.rest(cache.epochs[0])
    thickness = float(np.ptp(points[np.abs(points[:, 0]) < 3.0, 2]))
    found = noted(scene, PlateAnnotation("deep", "depth", ((0.0, 8.0, top(scene)),)))
    (measure,) = found.measures
    assert measure.text == f"{thickness:.0f} mm"
    scale = section_projection(scene, ACROSS, SIZE).scale
    ends = measure.arc[2:4]
    assert np.linalg.norm(ends[1] - ends[0]) / scale == pytest.approx(thickness, abs=0.05)


def test_a_width_and_a_label_stand_in_the_section_at_their_places(scene: PlateScene) -> None:
    anchors = ((0.0, -8.0, top(scene)), (0.0, 8.0, top(scene)))
    found = noted(scene, PlateAnnotation("w", "width", anchors), PlateAnnotation("l", "label", anchors[:1], "here"))
    assert [measure.text for measure in found.measures] == ["16 mm"]
    ((text, site),) = found.named
    place = section_projection(scene, ACROSS, SIZE).paper(np.array(anchors[:1]))[0]
    assert text == "here"
    assert site == pytest.approx(place, abs=0.05)


def test_what_lies_off_the_plane_is_left_out_and_said(scene: PlateScene) -> None:
    note = PlateAnnotation("far", "label", ((9.0, 8.0, top(scene)),), "far", panels=("cut",))
    found = noted(scene, note)
    assert found.named == []
    assert [each.code for each in found.notes] == [ProblemCode.PLATE_ANCHOR_HIDDEN]


def test_a_depth_on_a_panel_that_is_no_section_is_left_out_and_said(scene: PlateScene) -> None:
    drawing = section_drawing(scene, ACROSS, section_projection(scene, ACROSS, SIZE), scene.source.frames[0])
    note = PlateAnnotation("deep", "depth", ((0.0, 8.0, top(scene)),), panels=("plan",))
    found = AnnotationDrawer(scene, drawing, "plan", ()).draw((note,))
    assert found.measures == []
    assert [each.code for each in found.notes] == [ProblemCode.PLATE_ANCHOR_HIDDEN]


def test_the_level_of_dissection_is_below_what_is_undermined_and_from_then_on(
    scene: PlateScene, cache: SkinCache, monkeypatch: pytest.MonkeyPatch
) -> None:
    from lappet.drawing.skin_source import StepEvent

    ring = np.array([[-10.0, -6.0, 4.0], [10.0, -6.0, 4.0], [10.0, 6.0, 4.0], [-10.0, 6.0, 4.0], [-10.0, -6.0, 4.0]])
    begun = cache.frames[-1]
    monkeypatch.setattr(type(cache), "undermined_areas", lambda self, step: [ring])
    events = (*cache.events, StepEvent("Undermine", "around", begun, begun))
    monkeypatch.setattr(type(cache), "events", property(lambda self: events))
    projection = section_projection(scene, ACROSS, SIZE)

    def levels(time: float) -> list[np.ndarray]:
        strokes = section_strokes(scene, ACROSS, projection, time, True)
        return [each.points for each in strokes if each.kind is LineKind.DISSECTION]

    assert levels(cache.frames[0]) == []
    found = levels(begun)
    width = sum(float(np.ptp(each[:, 0])) for each in found) / projection.scale
    assert width == pytest.approx(12.0, abs=4.5)  # edges of triangles, at rest; a gaping wound takes some away
    (measure,) = dissection_depth(section_drawing(scene, ACROSS, projection, begun))
    points = cache.rest(cache.epochs[0])
    assert float(measure.text.removesuffix(" mm")) == pytest.approx(float(np.ptp(points[:, 2])), abs=1.01)


def test_a_dimension_lies_beside_its_points_and_is_as_long() -> None:
    course, middle = dimension(np.array([[0.0, 0.0], [10.0, 0.0]]), 5.0)
    assert middle == pytest.approx([5.0, 5.0])
    assert course[0] == pytest.approx([0.0, 0.0])
    assert course[-1] == pytest.approx([10.0, 0.0])
    assert np.ptp(course[:, 0]) == pytest.approx(10.0)


def test_a_section_has_a_scale_bar_of_its_own(cache: SkinCache) -> None:
    steps = chosen_steps(cache)[:2]
    request = PlateRequest((PlateRow(cache, steps),), {}, section=(0.0, 0.0, 0.0, 1.0, 0.0, 0.0))
    plan, section = plate_page(request, plate_style("ink"), plate_words("en"), PlateFont()).panels
    assert section.section
    assert plan.bar > 0.0
    assert section.bar > 0.0
    assert section.drawing.projection.scale != pytest.approx(plan.drawing.projection.scale)


def test_a_row_of_sections_alone_is_low_and_one_with_the_plan_is_not(cache: SkinCache) -> None:
    steps = chosen_steps(cache)
    steps = (steps[0], *[steps[-1]] * 3)
    request = PlateRequest((PlateRow(cache, steps),), {}, section=(0.0, 0.0, 0.0, 1.0, 0.0, 0.0), columns=2)
    panels = plate_page(request, plate_style("ink"), plate_words("en"), PlateFont()).panels
    ratios = [panel.size[1] / panel.size[0] for panel in panels]
    assert ratios == pytest.approx([0.75, 0.75, 0.45, 0.45])
    assert panels[2].middle[1] - 0.5 * panels[2].size[1] > panels[1].middle[1] + 0.5 * panels[1].size[1]
