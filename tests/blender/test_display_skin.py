"""The solved skin in a scene: right mesh, right places, right at once after everything that can happen to it."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import bpy
import numpy as np
import pytest
from numpy.typing import NDArray

from lappet_blender.display import skin_display
from lappet_blender.display.display_collection import find_collection
from lappet_blender.display.epoch_mesh import KEY, build_epoch_mesh
from slit_manifest import Solved, add_tissue, epoch_shape, show_slit, slit, slit_manifest, solved

__all__ = ["solved"]  # a fixture
UNITS = 0.1  # the scene's unit is a centimetre
STEP = 5.0


@pytest.fixture
def shown(scene: bpy.types.Scene, solved: Solved) -> bpy.types.Scene:
    return show_slit(scene, solved, STEP)


def skin(scene: bpy.types.Scene) -> bpy.types.Object:
    found = skin_display.skin_object(scene)
    assert found is not None
    return found


def positions(scene: bpy.types.Scene, each: bpy.types.Object) -> NDArray[np.float32]:
    """World positions (n, 3) as Blender evaluates them."""
    evaluated = each.evaluated_get(bpy.context.evaluated_depsgraph_get())
    flat = np.empty(3 * len(evaluated.data.vertices), np.float32)
    evaluated.data.vertices.foreach_get("co", flat)
    matrix = np.array(evaluated.matrix_world)
    return (flat.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]).astype(np.float32)


def attribute(mesh: bpy.types.Mesh, name: str, field: str, width: int) -> NDArray:
    data = mesh.attributes[name].data
    values = np.empty(
        len(data) * width, np.int32 if field == "value" and width == 1 and name != "depth" else np.float32
    )
    data.foreach_get(field, values)
    return values.reshape(-1, width) if width > 1 else values


def test_every_frame_shows_its_epoch_at_its_positions_in_the_units_of_the_scene(
    shown: bpy.types.Scene, solved: Solved
) -> None:
    manifest, frames = solved.manifests[shown.name]
    for listed in manifest.frames:
        shown.frame_set(listed.time)
        shape = manifest.epochs[listed.epoch]
        assert skin(shown).data[KEY] == shape.key
        assert len(skin(shown).data.polygons) == len(shape.triangles)
        np.testing.assert_allclose(positions(shown, skin(shown)), frames[listed.time].points * UNITS, atol=1e-6)


def test_an_epoch_has_one_mesh_that_is_swapped_and_built_once(shown: bpy.types.Scene) -> None:
    shown.frame_set(2)
    whole = skin(shown).data
    shown.frame_set(5)
    cut = skin(shown).data
    assert whole != cut
    for frame in (1, 6, 2, 12):
        shown.frame_set(frame)
        assert skin(shown).data == (whole if frame < slit.INCISED else cut)
    assert sum(KEY in mesh for mesh in bpy.data.meshes) == 2


def test_a_mesh_holds_rest_positions_origins_faces_grid_and_depth(shown: bpy.types.Scene, solved: Solved) -> None:
    shown.frame_set(slit.LIFTED)
    shape, mesh = solved.manifests[shown.name][0].epochs[1], skin(shown).data
    np.testing.assert_array_equal(attribute(mesh, "rest", "vector", 3), shape.rest)
    np.testing.assert_array_equal(attribute(mesh, "origin", "value", 1), shape.origin)
    np.testing.assert_array_equal(attribute(mesh, "face", "value", 1), shape.face)
    np.testing.assert_array_equal(attribute(mesh, "grid", "vector", 2), shape.grid.reshape(-1, 2))
    np.testing.assert_array_equal(attribute(mesh, "depth", "value", 1), shape.depth)
    assert mesh.uv_layers.active.name == "UVMap"
    assert [m.name.split(".")[0] for m in mesh.materials] == ["Skin", "Wound wall", "Underside", "Rim"]


def test_the_border_between_skin_and_wound_is_sharp_and_nothing_else_is() -> None:
    shape = epoch_shape(STEP, True)
    mesh = build_epoch_mesh(shape)
    faces: dict[tuple[int, int], set[int]] = {}
    for triangle, origin in zip(shape.triangles, shape.origin, strict=True):
        for a, b in ((0, 1), (1, 2), (2, 0)):
            faces.setdefault(tuple(sorted((int(triangle[a]), int(triangle[b])))), set()).add(int(origin))
    sharp = attribute(mesh, "sharp_edge", "value", 1).astype(bool)
    for edge in mesh.edges:
        assert sharp[edge.index] == (len(faces[tuple(sorted(edge.vertices))]) > 1)


def test_the_tissue_is_hidden_while_its_skin_is_shown_and_comes_back_as_it_was(shown: bpy.types.Scene) -> None:
    tissue = shown.lappet.tissue.object
    assert tissue.hide_viewport
    assert tissue.hide_render
    shown.lappet.look.show_solved = False
    assert not tissue.hide_viewport
    assert not tissue.hide_render
    assert skin_display.skin_object(shown) is None
    tissue.hide_render = True
    shown.lappet.look.show_solved = True
    shown.lappet.look.show_solved = False
    assert not tissue.hide_viewport
    assert tissue.hide_render


def test_locked_interface_is_switched_on_where_a_skin_is_shown(shown: bpy.types.Scene) -> None:
    assert shown.render.use_lock_interface


def test_a_frame_that_the_store_has_lost_shows_the_epoch_at_rest(shown: bpy.types.Scene, solved: Solved) -> None:
    manifest, frames = solved.manifests[shown.name]
    del frames[9]
    shown.frame_set(9)
    np.testing.assert_allclose(positions(shown, skin(shown)), manifest.epochs[1].rest * UNITS, atol=1e-6)


@pytest.mark.parametrize("damage", ["short", "nan"])
def test_a_damaged_frame_shows_the_epoch_at_rest(shown: bpy.types.Scene, solved: Solved, damage: str) -> None:
    manifest, frames = solved.manifests[shown.name]
    points = frames[9].points[:-1] if damage == "short" else np.full_like(frames[9].points, np.nan)
    frames[9] = replace(frames[9], points=points)
    shown.frame_set(9)
    np.testing.assert_allclose(positions(shown, skin(shown)), manifest.epochs[1].rest * UNITS, atol=1e-6)


def test_what_is_deleted_renamed_parented_or_moved_is_right_again_at_the_next_frame(
    shown: bpy.types.Scene, solved: Solved
) -> None:
    frames = solved.manifests[shown.name][1]
    empty = bpy.data.objects.new("empty", None)
    shown.collection.objects.link(empty)
    empty.location = (3.0, 0.0, 0.0)

    def delete_mesh() -> None:
        bpy.data.meshes.remove(skin(shown).data)

    def delete_object() -> None:
        bpy.data.objects.remove(skin(shown))

    def delete_collection() -> None:
        bpy.data.collections.remove(find_collection(shown))

    def rename() -> None:
        skin(shown).name = find_collection(shown).name = "mine"
        skin(shown).data.name = "theirs"

    def parent() -> None:
        skin(shown).parent = empty

    def move() -> None:
        skin(shown).location = (1.0, 2.0, 3.0)
        skin(shown).scale = (2.0, 2.0, 2.0)

    def edit() -> None:
        skin(shown).data.clear_geometry()

    def strip() -> None:
        skin(shown).data.materials.clear()
        for name in ("rest", "grid"):
            skin(shown).data.attributes.remove(skin(shown).data.attributes[name])

    for frame, harm in enumerate(
        (delete_mesh, delete_object, delete_collection, rename, parent, move, edit, strip), start=4
    ):
        shown.frame_set(frame)
        harm()
        shown.frame_set(frame - 1)
        shown.frame_set(frame)
        np.testing.assert_allclose(positions(shown, skin(shown)), frames[frame].points * UNITS, atol=1e-5)
        assert len(skin(shown).data.materials) == 4
        assert "rest" in skin(shown).data.attributes


def test_the_skin_is_shown_after_the_file_is_saved_and_opened(
    shown: bpy.types.Scene, solved: Solved, blend: Path
) -> None:
    shown.frame_set(6)
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    scene = bpy.context.scene
    frames = solved.manifests[scene.name][1]
    np.testing.assert_allclose(positions(scene, skin(scene)), frames[6].points * UNITS, atol=1e-6)
    assert sum("lappet_role" in o for o in bpy.data.objects) == len(find_collection(scene).objects)
    for frame in (1, 11):
        scene.frame_set(frame)
        np.testing.assert_allclose(positions(scene, skin(scene)), frames[frame].points * UNITS, atol=1e-6)


def test_undo_takes_nothing_from_what_is_shown(shown: bpy.types.Scene, solved: Solved) -> None:
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.lappet.look_preset(preset="STRAIN")
    bpy.ops.ed.undo_push(message="strain")
    shown.frame_set(6)
    bpy.ops.ed.undo()
    scene = bpy.context.scene
    assert scene.lappet.look.color == "GRID"
    points = solved.manifests[scene.name][1][scene.frame_current].points
    np.testing.assert_allclose(positions(scene, skin(scene)), points * UNITS, atol=1e-6)


def test_two_scenes_of_one_procedure_show_a_frame_each(shown: bpy.types.Scene, solved: Solved) -> None:
    other = shown.copy()
    solved.manifests[other.name] = solved.manifests[shown.name]
    shown.frame_set(5)
    skin_display.refresh(other)
    other.frame_set(8)
    frames = solved.manifests[shown.name][1]
    assert skin(shown) != skin(other)
    assert skin(shown).data != skin(other).data
    assert other.lappet.skin == skin(other)
    assert find_collection(shown) not in list(other.collection.children)
    for scene, frame in ((shown, 5), (other, 8)):
        flat = np.empty(3 * len(skin(scene).data.vertices), np.float32)
        skin(scene).data.vertices.foreach_get("co", flat)
        np.testing.assert_allclose(flat.reshape(-1, 3), frames[frame].points * UNITS, atol=1e-6)


def test_a_scene_with_a_tissue_of_another_scene_shows_its_tissue_unless_it_is_solved_too(
    shown: bpy.types.Scene,
) -> None:
    other = shown.copy()  # has no manifest
    skin_display.refresh(other)
    assert not shown.lappet.tissue.object.hide_render
    skin_display.refresh(shown)
    assert shown.lappet.tissue.object.hide_render


def test_a_tissue_that_is_deleted_takes_the_skin_with_it_and_raises_nothing(shown: bpy.types.Scene) -> None:
    bpy.data.objects.remove(shown.lappet.tissue.object)
    shown.frame_set(5)
    assert skin_display.skin_object(shown) is None


def test_a_manifest_of_other_epochs_leaves_no_meshes_behind(shown: bpy.types.Scene, solved: Solved) -> None:
    shown.frame_set(5)
    solved.manifests[shown.name] = slit_manifest(4.0, "finer")
    skin_display.refresh_all()
    shown.frame_set(1)
    skin_display.tidy()
    keys = {epoch.key for epoch in solved.manifests[shown.name][0].epochs}
    assert {mesh[KEY] for mesh in bpy.data.meshes if KEY in mesh} == keys


def test_a_linked_scene_is_left_alone(shown: bpy.types.Scene, solved: Solved, blend: Path) -> None:
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(str(blend), link=True) as (held, wanted):
        wanted.scenes = held.scenes
    linked = next(s for s in bpy.data.scenes if s.library is not None)
    solved.manifests[linked.name] = slit_manifest(STEP)
    skin_display.refresh(linked)
    skin_display.show(linked, 5)


def test_trouble_in_a_handler_is_one_line_in_the_log_and_no_more(
    shown: bpy.types.Scene, solved: Solved, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def broken(*_: object) -> None:
        raise OSError("the disk is gone")

    monkeypatch.setattr("lappet_blender.solving.frames.shown_at", broken)
    for _ in range(3):
        shown.frame_set(7)
    lines = [r.getMessage() for r in caplog.records if "the disk is gone" in r.getMessage()]
    assert len(lines) == 1
    assert "cannot be shown at frame 7" in lines[0]


@pytest.mark.parametrize(("step", "vertices", "limit"), [(0.9, 20_000, 1 / 60), (0.4, 100_000, 1 / 24)])
def test_frames_follow_one_another_fast_enough_to_scrub(
    scene: bpy.types.Scene, solved: Solved, step: float, vertices: int, limit: float
) -> None:
    add_tissue(scene)
    manifest, _ = solved.manifests[scene.name] = slit_manifest(step, f"slit {step}", 40)
    assert len(manifest.epochs[1].rest) >= vertices
    skin_display.refresh(scene)
    for listed in manifest.frames:
        scene.frame_set(listed.time)
    spent = []
    for _ in range(4):
        for listed in manifest.frames:
            begun = time.thread_time()
            scene.frame_set(listed.time)
            spent.append(time.thread_time() - begun)
    # Processor time of the main thread, since a test may share the machine; twice the limit allows for slow ones.
    assert np.median(spent) < 2.0 * limit
