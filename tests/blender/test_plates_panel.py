"""The panel *Plate*: lists, names, undo and what the procedure gets of it."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from event_patch import co, patch_scene
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Plate, PlateAnnotation, PlatePanel
from lappet_blender.model.plate_names import active_plate
from lappet_blender.model.plate_values import keep_plates, plate_values
from lappet_blender.model.scene_procedure import read_scene
from lappet_blender.plates.panel_frame import panel_frame
from lappet_blender.plates.panel_view import look_through, panel_view, take_view, width_of
from lappet_blender.tools.shown_surface import shown_surface
from refusals import refusal

TOP = 2.0
ops = bpy.ops.lappet


@pytest.fixture
def slit(scene: bpy.types.Scene) -> bpy.types.Scene:
    """A patch of 24 x 16 x 2 mm with a slit at frame 2 and sutures at frames 4 to 6; nothing is solved."""
    patch_scene(scene, (24.0, 16.0, TOP), 8, resolution=2.0)
    ops.incision_add(points=co([(-5.7, 0, TOP), (5.7, 0.3, TOP)]), time=2, kerf=0.1)
    ops.suture_run(incision="incision_1", count=2, start=4, duration=2)
    return scene


def mine(scene: bpy.types.Scene) -> bpy.types.PropertyGroup:
    """A plate with the panels before, after and tip, which is an inset of after, and two annotations."""
    panels = (PlatePanel("before", "plan"), PlatePanel("after", "result"), PlatePanel("tip", "cut", inset_of="after"))
    notes = (
        PlateAnnotation("scar", "length", ((-5.0, 0.0, TOP), (5.0, 0.0, TOP))),
        PlateAnnotation("note", "label", ((8.0, 4.0, TOP),), "loose skin", panels=("after",), offset=(6.0, -8.0)),
    )
    keep_plates(scene, (Plate("mine", "ink", panels=panels, annotations=notes),))
    return scene.lappet.pages[0]


def test_a_template_makes_a_plate_that_is_part_of_the_procedure(slit: bpy.types.Scene) -> None:
    ops.plate_add(template="atlas")
    ops.plate_add(template="atlas")
    (first, second) = read_scene(slit).procedure.plates
    assert (first.name, second.name, second.style, second.width) == ("atlas", "atlas_2", "ink", 85.0)
    assert [panel.step for panel in first.panels] == ["plan", "cut", "result"]
    ops.plate_remove()
    assert [plate.name for plate in plate_values(slit)] == ["atlas"]


def test_a_plate_with_everything_set_goes_through_the_properties_unchanged(scene: bpy.types.Scene) -> None:
    panel = PlatePanel(
        *("detail", "", 7.25, "Naht", "", (1.5, -2.25, 4.0), 12.5, "host", "plan"),
        *((0.0, -0.6, 0.8), (0.0, 0.8, 0.6)),
    )
    host = PlatePanel("host", "sutured", view="low")
    note = PlateAnnotation("a", "angle", ((0, 0, 1), (1, 0, 1), (0, 2, 1)), "", ("host",), (-3.5, 0.1), "last-place")
    plate = Plate(
        *("mine", "halftone", 7, 85.5, 2, "fr", "top", "strain", (0.1, 0.2, 0.3), (0.6, 0.8, 0.0)),
        *(False, False, False, False, False, ("A", "tip of nose")),
        panels=(host, panel),
        annotations=(note,),
    )
    keep_plates(scene, (plate,))
    assert plate_values(scene) == (plate,)


def test_what_names_a_panel_follows_its_new_name(slit: bpy.types.Scene) -> None:
    plate = mine(slit)
    plate.panels[1].title = "before"  # taken
    assert [panel.name for panel in plate.panels] == ["before", "before_2", "tip"]
    assert plate.panels[2].inset_of == "before_2"
    assert plate_values(slit)[0].annotations[1].panels == ("before_2",)


def test_a_panel_that_is_removed_leaves_no_name_behind(slit: bpy.types.Scene) -> None:
    plate = mine(slit)
    plate.active_panel = 1
    ops.plate_item_remove(which="panels")
    (value,) = plate_values(slit)
    assert [panel.name for panel in value.panels] == ["before", "tip"]
    assert value.panels[1].inset_of == ""
    assert [note.name for note in value.annotations] == ["scar"], "what stood on it alone is off"


def test_panels_are_added_behind_the_chosen_one_and_moved(slit: bpy.types.Scene) -> None:
    plate = mine(slit)
    slit.frame_set(5)
    ops.plate_panel_add(step="FRAME")
    assert [panel.name for panel in plate.panels] == ["before", "frame_5", "after", "tip"]
    assert plate_values(slit)[0].panels[1].time == 5.0
    ops.plate_item_move(which="panels", by=-1)
    ops.plate_item_move(which="panels", by=-1)
    assert [panel.name for panel in plate.panels] == ["frame_5", "before", "after", "tip"]
    assert plate.active_panel == 0


def test_an_annotation_is_shown_on_the_chosen_panel_or_not(slit: bpy.types.Scene) -> None:
    plate = mine(slit)
    scar, note = plate.annotations
    assert (scar.shown, note.shown) == (True, False)
    scar.shown = False
    assert [each.name for each in scar.panels] == ["after", "tip"]
    scar.shown = True
    assert len(scar.panels) == 0, "on all of them, also on those to come"
    plate.active_panel = 1
    note.shown = False
    assert not note.enabled
    assert [each.name for each in plate_values(slit)[0].annotations] == ["scar"]
    note.shown = True
    assert plate_values(slit)[0].annotations[1].panels == ("after",)


def test_edits_of_a_plate_are_undone(slit: bpy.types.Scene) -> None:
    mine(slit)
    bpy.ops.ed.undo_push(message="made")
    ops.annotation_put(kind="label", text="tip", points=co([(0, 4, TOP)]))
    bpy.ops.ed.undo_push(message="put")
    assert len(bpy.context.scene.lappet.pages[0].annotations) == 3
    bpy.ops.ed.undo()
    assert [note.name for note in bpy.context.scene.lappet.pages[0].annotations] == ["scar", "note"]
    bpy.ops.ed.redo()
    assert bpy.context.scene.lappet.pages[0].annotations[2].text == "tip"


def test_a_plate_changes_no_key_of_a_frame(slit: bpy.types.Scene) -> None:
    from lappet.program.compile import compile_program
    from lappet.program.keys import frame_keys

    before = frame_keys(compile_program(read_scene(slit).procedure), "solver")
    mine(slit)
    assert frame_keys(compile_program(read_scene(slit).procedure), "solver") == before


def test_what_is_missing_is_said(slit: bpy.types.Scene) -> None:
    for act in (ops.plate_remove, ops.plate_panel_add, lambda: ops.annotation_put(points=co([(0, 0, TOP)]))):
        assert refusal(act).code is ProblemCode.PLATE_NONE_CHOSEN
    mine(slit)
    for count in (1, 3):
        points = co([(k, 0, TOP) for k in range(count)])
        assert refusal(lambda p=points: ops.annotation_put(kind="distance", points=p)).code is (
            ProblemCode.ANNOTATION_ANCHORS
        )
    assert len(active_plate(slit).annotations) == 2
    gone = refusal(lambda: ops.annotation_place(annotation="nobody", offset=(1, 1)))
    assert gone.code is ProblemCode.PLATE_NONE_CHOSEN


def test_panels_show_the_frames_of_their_events(slit: bpy.types.Scene) -> None:
    keep_plates(slit, (Plate("p", panels=tuple(PlatePanel(s, s) for s in ("plan", "cut", "sutured", "result"))),))
    assert [panel_frame(slit, panel) for panel in slit.lappet.pages[0].panels] == [1, 2, 6, 8]


def test_the_camera_of_a_view_comes_back_from_the_panel(slit: bpy.types.Scene) -> None:
    """Looking through the panel gives the very view that it was taken from."""
    plate = mine(slit)
    data = (
        next(
            area.spaces.active.region_3d
            for screen in bpy.data.screens
            for area in screen.areas
            if area.type == "VIEW_3D"
        )
        if any(area.type == "VIEW_3D" for screen in bpy.data.screens for area in screen.areas)
        else None
    )
    if data is None:
        pytest.skip("There is no 3D viewport in this file.")
    surface = shown_surface(slit)
    data.view_location, data.view_distance = (3.0, 1.0, TOP), 60.0
    take_view(slit, plate.panels[0], data, surface)
    rotation, width = data.view_rotation.copy(), width_of(data)
    value = plate_values(slit)[0].panels[0]
    np.testing.assert_allclose(value.at[2], TOP, atol=1e-3)
    view = panel_view(slit, plate, plate.panels[0], surface)
    data.view_distance, data.view_location = 500.0, (0.0, 0.0, 0.0)
    look_through(slit, data, view)
    assert data.view_rotation.rotation_difference(rotation).angle < 1e-3
    assert width_of(data) == pytest.approx(width, rel=0.01)


def test_the_camera_of_a_plate_looks_at_the_outside_of_a_tissue_whose_faces_are_all_skin(slit: bpy.types.Scene) -> None:
    mesh = slit.lappet.tissue.object.data
    for name in ("lappet_fixed", "lappet_bed"):
        mesh.attributes.remove(mesh.attributes[name])
    plate = mine(slit)
    bpy.context.view_layer.update()
    surface = shown_surface(slit)
    plate.view = "top"
    view = panel_view(slit, plate, plate.panels[0], surface)
    np.testing.assert_allclose(view.axes[2], [0.0, 0.0, 1.0], atol=1e-6)
    assert 11.4 < view.across < 40.0, "the slit, and some skin around it"
