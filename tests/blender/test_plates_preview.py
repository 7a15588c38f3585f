"""What the preview shows of a panel's annotations, in pixels."""

from __future__ import annotations

import bpy
import numpy as np
import pytest
from numpy.typing import NDArray

from event_patch import co, patch_scene
from lappet.drawing.framing import NEARER, WIDEST
from lappet.procedure import Plate, PlateAnnotation, PlatePanel
from lappet_blender.model.plate_names import active_plate
from lappet_blender.model.plate_values import keep_plates
from lappet_blender.plates.annotation_tools import offset_under
from lappet_blender.plates.panel_view import panel_size, panel_view, pixels_per_mm
from lappet_blender.plates.preview_marks import PreviewMarks, PreviewPage, preview_marks
from lappet_blender.tools.shown_surface import shown_surface

TOP = 2.0
PIXELS = 10.0  # for a unit of the world, looking down the z axis
PAGE = PreviewPage(5.0, np.array([[-300.0, -200.0], [300.0, 200.0]]), 12.0, lambda text: 6.0 * len(text))


def looking_down(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """An orthographic view along -z."""
    return PIXELS * np.asarray(places)[:, :2]


def marks(scene: bpy.types.Scene, *notes: PlateAnnotation, panel: str = "p") -> PreviewMarks:
    """The marks of annotations on a patch of 24 x 16 x 2 mm."""
    patch_scene(scene, (24.0, 16.0, TOP), 2, resolution=2.0)
    keep_plates(scene, (Plate("mine", panels=(PlatePanel("p", "plan"), PlatePanel("q", "result")), annotations=notes),))
    bpy.context.view_layer.update()
    surface = shown_surface(scene)
    assert surface is not None
    return preview_marks(active_plate(scene), panel, surface, looking_down, PAGE)


def test_a_placed_label_ends_its_leader_where_its_offset_says(scene: bpy.types.Scene) -> None:
    found = marks(scene, PlateAnnotation("a", "label", ((3.0, 2.0, TOP),), "bed", offset=(8.0, -6.0)))
    (leader,) = found.lines
    np.testing.assert_allclose(leader, [[30.0, 20.0], [30.0 + 8.0 * 5.0, 20.0 + 6.0 * 5.0]], atol=1e-4)
    (text,) = found.texts
    assert text.text == "bed"
    assert text.place[0] > leader[1, 0]
    assert text.holds(text.place + np.array([9.0, 4.0]), found.size)
    assert not text.holds(leader[0], found.size)


def test_dragging_a_text_gives_the_offset_under_the_mouse() -> None:
    assert offset_under(np.array([70.0, 50.0]), np.array([30.0, 20.0]), 5.0) == (8.0, -6.0)


def test_measures_say_the_lengths_and_angles_of_what_is_shown(scene: bpy.types.Scene) -> None:
    corner = ((6.0, 0.0, TOP), (0.0, 0.0, TOP), (0.0, 6.0, TOP))
    found = marks(
        scene,
        PlateAnnotation("l", "length", ((-5.0, 0.0, TOP), (5.0, 0.0, TOP))),
        PlateAnnotation("d", "distance", ((0.0, 0.0, TOP), (3.0, 4.0, TOP))),
        PlateAnnotation("w", "angle", corner),
    )
    assert [text.text for text in found.texts] == ["10 mm", "5 mm", "90°"]


def test_free_labels_stand_at_the_sides_and_their_leaders_do_not_meet(scene: bpy.types.Scene) -> None:
    rng = np.random.default_rng(3)
    places = rng.uniform([-11, -7], [11, 7], (14, 2))
    notes = [PlateAnnotation(f"n{k}", "label", ((x, y, TOP),), f"label {k}") for k, (x, y) in enumerate(places)]
    found = marks(scene, *notes)
    assert len(found.texts) == len(found.lines) == 14
    for text in found.texts:
        inside = PAGE.frame[0, 0] - 1e-6 <= text.place[0] <= PAGE.frame[1, 0] - text.width + 1e-6
        assert inside, text.text
    boxes = [(text.place, text.width) for text in found.texts]
    for k, (one, width) in enumerate(boxes):
        for other, wide in boxes[k + 1 :]:
            apart = one[0] + width < other[0] or other[0] + wide < one[0] or abs(one[1] - other[1]) >= found.size
            assert apart, "two labels overlap"


def test_only_what_stands_on_the_panel_and_has_its_tissue_is_shown(scene: bpy.types.Scene) -> None:
    found = marks(
        scene,
        PlateAnnotation("here", "label", ((0.0, 0.0, TOP),), "here", panels=("p",)),
        PlateAnnotation("there", "label", ((0.0, 0.0, TOP),), "there", panels=("q",)),
        PlateAnnotation("gone", "label", ((0.0, 0.0, TOP + 9.0),), "gone"),
        PlateAnnotation("way", "arrow", ((0.0, 0.0, TOP), (4.0, 0.0, TOP))),
    )
    assert [text.text for text in found.texts] == ["here"]
    assert any(np.allclose(line, [[0.0, 0.0], [40.0, 0.0]], atol=1e-4) for line in found.lines)


def test_where_a_body_is_shown_a_panels_camera_holds_as_much_around_the_wound_as_the_plate(
    scene: bpy.types.Scene,
) -> None:
    patch_scene(scene, (60.0, 60.0, TOP), 2, resolution=5.0)
    bpy.ops.lappet.incision_add(points=co([(-6.0, 0.0, TOP), (6.0, 0.0, TOP)]))
    keep_plates(scene, (Plate("mine", panels=(PlatePanel("p", "plan"),)),))
    plate = active_plate(scene)

    def across() -> float:
        surface = shown_surface(scene)
        assert surface is not None
        return panel_view(scene, plate, plate.panels[0], surface).across

    alone = across()
    bpy.ops.mesh.primitive_cube_add(size=100.0)
    bpy.context.object["lappet_scenery"] = "skin"
    bpy.context.view_layer.update()
    around = float(np.hypot(60.0, 60.0)) / 12.0  # how far the tissue reaches, in lengths of the wound
    assert across() == pytest.approx(alone * min(around, WIDEST) ** NEARER, rel=0.02)


def test_paper_fills_the_view_as_far_as_the_panel_goes(scene: bpy.types.Scene) -> None:
    keep_plates(scene, (Plate("mine", width=85.0, columns=1),))
    plate = active_plate(scene)
    assert panel_size(plate) == (85.0, pytest.approx(63.75))
    assert pixels_per_mm(plate, (1000.0, 400.0)) == pytest.approx(0.9 * 400.0 / 63.75)
