"""What a user does to the skin that is shown: edits, sculpts, hides, deletes it, gives it another material."""

from __future__ import annotations

import logging
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest

from lappet_blender.display import skin_display
from lappet_blender.display.display_collection import find_collection
from lappet_blender.tools.flap_gizmos import shown_places
from lappet_blender.tools.handles import handles_of
from lappet_blender.tools.plan_overlay import plan_lines
from lappet_blender.tools.shown_surface import clear_cache, shown_object, shown_surface
from slit_manifest import Solved, add_tissue, slit_manifest, solved

__all__ = ["solved"]  # a fixture


@pytest.fixture
def shown(scene: bpy.types.Scene, solved: Solved) -> bpy.types.Scene:
    """A scene with the slit patch solved and an incision drawn, at frame 1."""
    add_tissue(scene)
    bpy.ops.lappet.incision_add(points=[{"name": "", "co": (x, 0.0, 0.0)} for x in (-10.0, 10.0)], time=3.0)
    solved.manifests[scene.name] = slit_manifest(5.0)
    skin_display.refresh(scene)
    clear_cache()
    bpy.context.view_layer.update()
    return scene


def skin(scene: bpy.types.Scene) -> bpy.types.Object:
    found = skin_display.skin_object(scene)
    assert found is not None
    return found


def activate(each: bpy.types.Object) -> None:
    bpy.context.view_layer.objects.active = each
    each.select_set(True)


def look_at_everything(scene: bpy.types.Scene) -> None:
    """What a redraw of the window asks for."""
    bpy.context.view_layer.update()
    surface = shown_surface(scene)
    if surface is not None:
        plan_lines(scene, surface)
    handles_of(scene, scene.frame_current)
    shown_places(scene, None)


@pytest.mark.parametrize("mode", ["EDIT", "SCULPT", "VERTEX_PAINT", "WEIGHT_PAINT"])
def test_the_skin_may_be_in_any_mode_while_the_window_draws_and_frames_pass(
    shown: bpy.types.Scene, solved: Solved, caplog: pytest.LogCaptureFixture, mode: str
) -> None:
    activate(skin(shown))
    bpy.ops.object.mode_set(mode=mode)
    with caplog.at_level(logging.WARNING):
        for frame in (1, 5, 9):
            shown.frame_set(frame)
            look_at_everything(shown)
    assert not caplog.records
    bpy.ops.object.mode_set(mode="OBJECT")
    shown.frame_set(6)
    places = np.empty(3 * len(skin(shown).data.vertices), np.float32)
    skin(shown).data.vertices.foreach_get("co", places)
    np.testing.assert_allclose(places.reshape(-1, 3), solved.manifests[shown.name][1][6].points * 0.1, atol=1e-6)


def test_a_skin_in_edit_mode_is_not_drawn_on(shown: bpy.types.Scene) -> None:
    assert shown_object(shown) == skin(shown)
    activate(skin(shown))
    bpy.ops.object.mode_set(mode="EDIT")
    assert shown_object(shown) is None
    bpy.ops.object.mode_set(mode="OBJECT")
    assert shown_object(shown) == skin(shown)


def test_a_tissue_in_edit_mode_is_not_drawn_on_either(scene: bpy.types.Scene) -> None:
    activate(add_tissue(scene))
    bpy.ops.object.mode_set(mode="EDIT")
    look_at_everything(scene)
    assert shown_surface(scene) is None


def hide(each: bpy.types.Object) -> None:
    each.hide_set(True)


def hide_everywhere(each: bpy.types.Object) -> None:
    each.hide_viewport = True


def delete(each: bpy.types.Object) -> None:
    bpy.data.objects.remove(each)


def dissolve(each: bpy.types.Object) -> None:
    activate(each)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.delete(type="VERT")
    bpy.ops.object.mode_set(mode="OBJECT")


def duplicate(each: bpy.types.Object) -> None:
    bpy.context.scene.collection.objects.link(each.copy())


def make_local_copy(each: bpy.types.Object) -> None:
    each.data = each.data.copy()


@pytest.mark.parametrize("harm", [hide, hide_everywhere, delete, dissolve, duplicate, make_local_copy])
def test_whatever_is_done_to_the_skin_nothing_is_logged(
    shown: bpy.types.Scene, caplog: pytest.LogCaptureFixture, harm: Callable[[bpy.types.Object], None]
) -> None:
    shown.frame_set(5)
    harm(skin(shown))
    with caplog.at_level(logging.WARNING):
        for frame in (5, 6, 2, 9):
            look_at_everything(shown)
            shown.frame_set(frame)
    assert not caplog.records


def test_a_changed_frame_rate_and_two_scenes_are_shown_without_a_word(
    shown: bpy.types.Scene, solved: Solved, caplog: pytest.LogCaptureFixture
) -> None:
    other = shown.copy()
    solved.manifests[other.name] = solved.manifests[shown.name]
    with caplog.at_level(logging.WARNING):
        shown.render.fps, shown.render.fps_base = 60, 1.001
        for scene, frame in ((shown, 4), (other, 9), (shown, 9)):
            scene.frame_set(frame)
            look_at_everything(scene)
    assert not caplog.records


def own_material(name: str = "Mine") -> bpy.types.Material:
    return bpy.data.materials.new(name)


def test_a_material_of_ones_own_is_kept_on_the_skin_through_frames_epochs_and_a_saved_file(
    shown: bpy.types.Scene, blend: Path
) -> None:
    given = tuple(skin(shown).data.materials)
    skin(shown).data.materials[0] = own_material()
    for frame in (2, 6, 12, 1):
        shown.frame_set(frame)
        worn = tuple(skin(shown).data.materials)
        assert [worn[0].name, *worn[1:]] == ["Mine", *given[1:]]
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    bpy.context.scene.frame_set(6)
    assert skin(bpy.context.scene).data.materials[0].name == "Mine"


def test_the_wound_walls_may_have_a_material_of_ones_own_too(shown: bpy.types.Scene) -> None:
    shown.frame_set(6)
    skin(shown).data.materials[1] = own_material()
    for frame in (1, 7):
        shown.frame_set(frame)
        assert skin(shown).data.materials[1].name == "Mine"


def test_a_material_of_ones_own_belongs_to_the_color_that_it_was_put_on(shown: bpy.types.Scene) -> None:
    skin(shown).data.materials[0] = own_material()
    shown.frame_set(2)
    shown.lappet.look.color = "STRAIN"
    skin_display.refresh(shown)
    assert skin(shown).data.materials[0].name != "Mine", "a map of strain is not painted over"
    shown.lappet.look.color = "GRID"
    skin_display.refresh(shown)
    assert skin(shown).data.materials[0].name == "Mine"


def test_a_slot_that_is_emptied_gets_the_material_of_the_display_again(shown: bpy.types.Scene) -> None:
    given = skin(shown).data.materials[0]
    skin(shown).data.materials[0] = own_material()
    shown.frame_set(2)
    skin(shown).data.materials[0] = None
    shown.frame_set(3)
    assert skin(shown).data.materials[0] == given
    assert not any(name.startswith("own material") for name in find_collection(shown).keys())  # noqa: SIM118


@pytest.mark.parametrize("way", ["ur", "uur", "uuurrr", "uruuru"])
def test_undo_and_redo_past_what_was_shown_meanwhile_leave_nothing_that_is_freed(
    scene: bpy.types.Scene, solved: Solved, way: str
) -> None:
    """Without taking the display away first Blender crashes here: it reads a collection whose objects are freed."""
    add_tissue(scene)
    name = scene.name
    solved.manifests[name] = slit_manifest(5.0)
    skin_display.refresh(scene)
    for count in range(5):
        bpy.context.scene.lappet.look.show_plan = bool(count % 2)
        bpy.ops.ed.undo_push(message=f"step {count}")
    bpy.context.scene.frame_set(10)  # thread, steel and bed are made, and no step of undo tells of them
    bpy.context.view_layer.update()
    for frame, step in enumerate(way, start=3):
        getattr(bpy.ops.ed, "undo" if step == "u" else "redo")()
        bpy.context.scene.frame_set(frame)
        bpy.context.view_layer.update()
        assert all(each.name for each in bpy.context.scene.objects[:])
        places = np.empty(3 * len(skin(bpy.context.scene).data.vertices), np.float32)
        skin(bpy.context.scene).data.vertices.foreach_get("co", places)
        wanted = solved.manifests[name][1][frame].points * 0.1
        np.testing.assert_allclose(places.reshape(-1, 3), wanted, atol=1e-6)


def test_a_material_of_ones_own_outlives_an_undo(shown: bpy.types.Scene) -> None:
    bpy.ops.ed.undo_push(message="solved")
    skin(shown).data.materials[0] = own_material()
    shown.frame_set(2)
    bpy.ops.ed.undo_push(message="material")
    shown.lappet.look.show_plan = not shown.lappet.look.show_plan
    bpy.ops.ed.undo_push(message="plan")
    bpy.ops.ed.undo()
    assert skin(bpy.context.scene).data.materials[0].name == "Mine"
    bpy.ops.ed.undo()
    assert skin(bpy.context.scene).data.materials[0].name != "Mine", "it was undone"
