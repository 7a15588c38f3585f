"""How the solved skin looks: parts, colors and their scale, two skins side by side, rendered pictures."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import bpy
import numpy as np
import pytest
from bpy_extras.object_utils import world_to_camera_view
from numpy.typing import NDArray

from lappet.core.problem_code import ProblemCode
from lappet.drawing.quantity_scale import ramp_linear
from lappet_blender.display import skin_display
from lappet_blender.display.color_scale import highest_of
from lappet_blender.display.display_collection import ROLE, find_collection, find_object
from lappet_blender.display.render_still import another_frame
from lappet_blender.look.skin_material import FULL_SCALE, SKIN
from lappet_blender.look.solid_texture import add_tile
from refusals import refusal_code
from slit_manifest import STEP, Solved, add_tissue, shown, slit, slit_manifest, solved, vertices

__all__ = ["shown", "solved"]  # fixtures
UNITS = 0.1
SIZE = 96


def part(scene: bpy.types.Scene, role: str) -> bpy.types.Object | None:
    """The object of a role, where it is to be seen."""
    collection = find_collection(scene)
    found = None if collection is None else find_object(collection, role)
    return None if found is None or found.hide_render or found.hide_viewport else found


def rendered(scene: bpy.types.Scene, path: Path, engine: str = "WORKBENCH") -> NDArray[np.float32]:
    """The picture of the current frame, (height, width, 3)."""
    bpy.ops.lappet.set_stage(view="TOP", engine=engine, width=SIZE, height=SIZE, samples=4)
    bpy.ops.lappet.render_still(filepath=str(path))
    image = bpy.data.images.load(str(path))
    flat = np.empty(SIZE * SIZE * 4, np.float32)
    image.pixels.foreach_get(flat)
    bpy.data.images.remove(image)
    return flat.reshape(SIZE, SIZE, 4)[::-1, :, :3]


def test_hooks_are_there_while_they_pull_and_stitches_once_they_are_placed(shown: bpy.types.Scene) -> None:
    for frame in slit.FRAMES:
        shown.frame_set(frame)
        assert (part(shown, "steel") is not None) == (slit.INCISED < frame < slit.SUTURED), frame
        assert (part(shown, "thread") is not None) == (frame > slit.LIFTED), frame
        assert (part(shown, "edge") is not None) == (frame >= slit.INCISED), frame
        assert part(shown, "landmark") is not None


def test_the_point_of_a_hook_is_in_the_skin_that_it_holds(shown: bpy.types.Scene, solved: Solved) -> None:
    for frame in (5, 7):
        shown.frame_set(frame)
        ends = solved.manifests[shown.name][1][frame].hook_points * UNITS
        steel = vertices(part(shown, "steel"))
        for end in ends:
            assert np.linalg.norm(steel - end, axis=1).min() < 1.0 * UNITS


def test_stitches_lie_across_the_closed_wound(shown: bpy.types.Scene) -> None:
    shown.frame_set(12)
    thread = vertices(part(shown, "thread")) / UNITS
    for x in np.linspace(-15.0, 15.0, 4):
        near = thread[np.abs(thread[:, 0] - x) < 1.5]
        assert near[:, 1].min() < -1.0
        assert near[:, 1].max() > 1.0
        assert near[:, 2].max() < 2.0


@pytest.mark.parametrize(
    ("toggle", "role", "frame"),
    [("show_sutures", "thread", 12), ("show_hooks", "steel", 6), ("show_landmarks", "landmark", 6)],
)
def test_a_part_that_is_switched_off_is_gone_at_once_and_comes_back(
    shown: bpy.types.Scene, toggle: str, role: str, frame: int
) -> None:
    shown.frame_set(frame)
    assert part(shown, role) is not None
    setattr(shown.lappet.look, toggle, False)
    assert part(shown, role) is None
    setattr(shown.lappet.look, toggle, True)
    assert part(shown, role) is not None


def test_wound_walls_are_faces_that_can_be_left_out(shown: bpy.types.Scene, solved: Solved) -> None:
    shown.frame_set(6)
    shape = solved.manifests[shown.name][0].epochs[1]
    skin = part(shown, "skin")
    assert len(skin.data.polygons) == len(shape.triangles)
    shown.lappet.look.show_walls = False
    assert len(part(shown, "skin").data.polygons) == (shape.origin != 1).sum()
    np.testing.assert_allclose(
        vertices(part(shown, "skin")), solved.manifests[shown.name][1][6].points * UNITS, atol=1e-6
    )


def test_a_bone_is_hidden_and_comes_back(shown: bpy.types.Scene) -> None:
    bone = bpy.data.objects.new("bone", bpy.data.meshes.new("bone"))
    shown.collection.objects.link(bone)
    shown.lappet.bones.add().object = bone
    shown.lappet.look.show_bone = False
    assert bone.hide_render
    shown.lappet.look.show_bone = True
    assert not bone.hide_render


def test_marks_of_the_planned_incision_lie_on_the_skin_until_it_is_cut(shown: bpy.types.Scene) -> None:
    event = shown.lappet.events.add()
    event.kind, event.name, event.start = "INCISION", "cut", float(slit.INCISED)
    for x in (-slit.HALF_SLIT, slit.HALF_SLIT):
        event.points.add().co = (x, 0.0, 0.0)
    shown.frame_set(1)
    marks = vertices(part(shown, "ink")) / UNITS
    assert marks[:, 0].min() == pytest.approx(-slit.HALF_SLIT, abs=0.3)
    assert marks[:, 0].max() == pytest.approx(slit.HALF_SLIT, abs=0.3)
    assert np.abs(marks[:, 1:]).max() < 0.3
    shown.frame_set(slit.INCISED)
    assert part(shown, "ink") is None


def test_the_bed_lies_under_the_skin_and_gives_way_to_it(shown: bpy.types.Scene, solved: Solved) -> None:
    shown.frame_set(7)
    bed = vertices(part(shown, "bed")) / UNITS
    assert bed[:, 2].max() < -slit.THICKNESS
    solved.manifests[shown.name][1][12].points[:, 2] -= 3.0
    shown.frame_set(12)
    pressed = vertices(part(shown, "bed")) / UNITS
    inner = np.abs(pressed[:, :2]).max(axis=1) < 25.0
    assert pressed[inner, 2].max() < -slit.THICKNESS - 3.0


def test_the_scale_is_one_for_all_frames_and_the_95th_percentile_of_the_frame_with_most(
    shown: bpy.types.Scene, solved: Solved
) -> None:
    manifest, frames = solved.manifests[shown.name]
    shown.lappet.look.color = "STRAIN"
    most = max(float(np.percentile(frame.strain, 95.0)) for frame in frames.values())
    highest = highest_of([manifest], "strain")
    assert most <= highest <= 1.5 * most
    for frame in (1, 7, 12):
        shown.frame_set(frame)
        ramp = part(shown, "skin").data.materials[0].node_tree.nodes[FULL_SCALE]
        assert ramp.inputs[1].default_value == pytest.approx(highest)


def test_vertices_carry_the_quantity_and_its_color_on_the_ramp(shown: bpy.types.Scene, solved: Solved) -> None:
    shown.lappet.look.color = "TENSION"
    shown.frame_set(7)
    manifest, frames = solved.manifests[shown.name]
    mesh, tension = part(shown, "skin").data, frames[7].tension
    quantity = np.empty(len(tension), np.float32)
    mesh.attributes["quantity"].data.foreach_get("value", quantity)
    np.testing.assert_array_equal(quantity, tension)
    colors = np.empty(4 * len(tension), np.float32)
    mesh.attributes["Color"].data.foreach_get("color", colors)
    skin = np.unique(manifest.epochs[1].triangles[manifest.epochs[1].origin == 0])
    expected = ramp_linear(tension / highest_of([manifest], "tension"))
    np.testing.assert_allclose(colors.reshape(-1, 4)[skin, :3], expected[skin], atol=0.01)


def test_the_legend_names_the_quantity_its_unit_and_the_values_of_its_ticks(
    shown: bpy.types.Scene, solved: Solved
) -> None:
    assert part(shown, "legend") is None
    shown.lappet.look.color = "TENSION"
    highest = highest_of([solved.manifests[shown.name][0]], "tension")
    words = [o.data.body for o in find_collection(shown).objects if str(o.get(ROLE)).startswith("legend text")]
    assert sorted(words) == sorted(
        ["Tension, kPa", "0", *(f"{highest * k / 4:g}" for k in (1, 2, 3)), f"≥\u2009{highest:g}"]
    )
    assert part(shown, "legend") is not None
    shown.lappet.look.show_legend = False
    assert part(shown, "legend") is None
    shown.lappet.look.show_legend = True
    shown.lappet.look.color = "GRID"
    assert part(shown, "legend") is None


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_the_legend_lies_within_the_picture_of_the_camera_however_the_camera_is_scaled(
    shown: bpy.types.Scene, kind: str
) -> None:

    shown.lappet.look.color = "STRAIN"
    bpy.ops.lappet.set_stage(view="OBLIQUE", engine="KEEP", width=160, height=120)
    shown.camera.data.type = kind
    shown.camera.scale = (2.0, 2.0, 2.0)
    bpy.context.view_layer.update()
    shown.frame_set(7)
    card = part(shown, "legend")
    evaluated = card.evaluated_get(bpy.context.evaluated_depsgraph_get())
    corners = [
        world_to_camera_view(shown, shown.camera, evaluated.matrix_world @ v.co) for v in evaluated.data.vertices
    ]
    across, up = [c.x for c in corners], [c.y for c in corners]
    assert 0.0 < min(across) < 0.06
    assert 0.2 < max(across) < 0.4
    assert 0.0 < min(up) < 0.08
    assert max(up) < 0.3


def test_solid_shading_follows_the_color(shown: bpy.types.Scene) -> None:
    for color, shading in (("STRAIN", "VERTEX"), ("CHECKER", "TEXTURE"), ("PLAIN", "MATERIAL"), ("GRID", "TEXTURE")):
        shown.lappet.look.color = color
        assert shown.display.shading.color_type == shading


def test_the_other_skin_lies_beside_this_one_at_the_same_frame_with_a_gap_and_both_names(
    shown: bpy.types.Scene, solved: Solved
) -> None:
    other = bpy.data.scenes.new("Wide")
    add_tissue(other)
    solved.manifests["Wide"] = slit_manifest(5.0, "wide")
    shown.lappet.compare_gap = 7.0
    bpy.ops.lappet.compare(scene="Wide")
    shown.frame_set(6)
    bpy.context.view_layer.update()
    beside = part(shown, "other skin")
    moved = vertices(beside) / UNITS
    np.testing.assert_allclose(moved, solved.manifests["Wide"][1][6].points, atol=1e-4)
    assert beside.matrix_world.translation.x / UNITS == pytest.approx(slit.LENGTH + 7.0, abs=1e-4)
    assert {part(shown, r).data.body for r in ("label", "other label")} == {"Scene", "Wide"}
    assert part(shown, "other steel") is not None
    bpy.ops.lappet.compare(scene="")
    assert part(shown, "other skin") is None
    assert part(shown, "other steel") is None
    assert part(shown, "label") is None


def test_two_skins_share_one_scale_so_that_they_compare(shown: bpy.types.Scene, solved: Solved) -> None:
    other = bpy.data.scenes.new("Tense")
    add_tissue(other)
    manifest, frames = solved.manifests["Tense"] = slit_manifest(5.0, "tense")
    for frame in frames.values():
        frame.strain[:] *= 10.0
    shown.lappet.look.color = "STRAIN"
    alone = highest_of([solved.manifests[shown.name][0]], "strain")
    bpy.ops.lappet.compare(scene="Tense")
    materials = [part(shown, r).data.materials[0] for r in ("skin", "other skin")]
    assert materials[0] == materials[1]
    highest = materials[0].node_tree.nodes[FULL_SCALE].inputs[1].default_value
    assert highest == pytest.approx(highest_of([manifest], "strain"))
    assert highest > 5.0 * alone


def test_a_variant_is_a_scene_with_the_first_one_beside_it(shown: bpy.types.Scene, solved: Solved) -> None:
    bpy.ops.lappet.variant_new(name="Shorter")
    made = bpy.data.scenes["Shorter"]
    assert made.lappet.compare_with == shown
    assert not any(find_collection(shown) == child for child in made.collection.children)
    solved.manifests["Shorter"] = slit_manifest(STEP, "shorter")
    skin_display.refresh(made)
    assert part(made, "skin") is not None
    assert part(made, "other skin") is not None
    assert part(made, "skin") != part(shown, "skin")


@pytest.mark.parametrize(
    ("command", "arguments", "code"),
    [
        ("compare", {"scene": "Nowhere"}, ProblemCode.COMPARE_UNKNOWN),
        ("compare", {"scene": "Scene"}, ProblemCode.COMPARE_ITSELF),
        ("render_still", {"filepath": "/tmp/picture.txt"}, ProblemCode.PICTURE_NAME),
        ("render_still", {"filepath": "//picture.png"}, ProblemCode.PICTURE_BESIDE_NOTHING),
        ("render_still", {"filepath": "/tmp/picture.png"}, ProblemCode.PICTURE_NO_CAMERA),
        ("clear_stage", {}, ProblemCode.FIGURE_NOT_SET),
    ],
)
def test_what_cannot_be_done_is_refused(
    shown: bpy.types.Scene, command: str, arguments: dict[str, str], code: ProblemCode
) -> None:
    assert refusal_code(lambda: getattr(bpy.ops.lappet, command)(**arguments)) is code


def test_a_rendered_frame_shows_the_open_wound_where_the_closed_one_is_skin(
    shown: bpy.types.Scene, tmp_path: Path
) -> None:
    shown.lappet.look.color = "PLAIN"
    for toggle in ("show_hooks", "show_sutures", "show_landmarks"):
        setattr(shown.lappet.look, toggle, False)
    pictures = {}
    for frame in (1, 7):
        shown.frame_set(frame)
        pictures[frame] = rendered(shown, tmp_path / f"{frame}.png")
    changed = np.abs(pictures[7] - pictures[1]).max(axis=2) > 0.08
    rows, columns = np.nonzero(changed)
    assert changed.mean() > 0.01
    # Seen from above, the slit lies along the middle row, from left to right.
    assert abs(rows.mean() / SIZE - 0.5) < 0.06
    assert abs(columns.mean() / SIZE - 0.5) < 0.06
    assert np.ptp(columns) > 2.0 * np.percentile(np.abs(rows - rows.mean()), 90)


def test_an_animation_renders_each_frame_with_its_own_skin(shown: bpy.types.Scene, tmp_path: Path) -> None:
    shown.frame_set(1)
    bpy.ops.lappet.set_stage(view="TOP", engine="WORKBENCH", width=SIZE, height=SIZE)
    shown.frame_start, shown.frame_end, shown.frame_step = 1, 7, 6
    shown.render.filepath = str(tmp_path / "film_")
    shown.render.image_settings.file_format = "PNG"
    bpy.ops.render.render(animation=True)
    pictures = []
    for frame in (1, 7):
        image = bpy.data.images.load(str(tmp_path / f"film_{frame:04d}.png"))
        flat = np.empty(SIZE * SIZE * 4, np.float32)
        image.pixels.foreach_get(flat)
        pictures.append(flat)
    assert (np.abs(pictures[0] - pictures[1]) > 0.08).mean() > 0.005


def test_cycles_shows_strain_in_the_colors_of_the_scale(shown: bpy.types.Scene, solved: Solved, tmp_path: Path) -> None:
    shown.lappet.look.color = "STRAIN"
    shown.lappet.look.show_legend = False
    for frame in solved.manifests[shown.name][1].values():
        frame.strain[:] = 1.0
    shown.frame_set(1)
    warm = rendered(shown, tmp_path / "warm.png", "CYCLES")[SIZE // 3 : -SIZE // 3].reshape(-1, 3).mean(axis=0)
    for frame in solved.manifests[shown.name][1].values():
        frame.strain[:] = 0.0
    skin_display.refresh(shown)
    cold = rendered(shown, tmp_path / "cold.png", "CYCLES")[SIZE // 3 : -SIZE // 3].reshape(-1, 3).mean(axis=0)
    assert warm[0] > 2.0 * warm[2]
    assert cold[2] > 1.5 * cold[0]


def test_a_still_says_where_it_shows_another_frame_than_the_one_it_is_of(
    shown: bpy.types.Scene, solved: Solved, monkeypatch: pytest.MonkeyPatch
) -> None:
    shown.frame_set(9)
    assert another_frame(shown) is None
    frames = solved.manifests[shown.name][1]
    earlier = replace(solved.shown_at(shown, 8), stale=True)  # frame 9 failed: the last good one is shown
    monkeypatch.setattr(skin_display.frames, "shown_at", lambda scene, time: earlier)
    told = another_frame(shown)
    assert told is not None
    assert (told.code, told.value) == (ProblemCode.PICTURE_NOT_SOLVED, "9")
    assert told.message.endswith("the picture shows frame 8.")
    del frames[9]
    monkeypatch.setattr(skin_display.frames, "shown_at", solved.shown_at)
    told = another_frame(shown)
    assert told is not None
    assert told.message.endswith("the picture shows the tissue at rest.")


def test_the_picture_of_the_grid_is_in_the_file_and_has_its_colors(scene: bpy.types.Scene) -> None:
    material = bpy.data.materials.new("Tile")
    if not material.use_nodes:
        material.use_nodes = True
    add_tile(material, "grid")
    image = material.node_tree.nodes.active.image
    assert image.packed_file is not None
    flat = np.empty(4 * 160 * 160, np.float32)
    image.pixels.foreach_get(flat)
    seen = flat.reshape(160, 160, 4)
    linear = np.where(seen <= 0.04045, seen / 12.92, ((seen + 0.055) / 1.055) ** 2.4)
    assert linear[40, 40, :3] == pytest.approx(SKIN[:3], abs=0.01)  # between two lines
    assert np.all(linear[0, :, :3].sum(axis=1) < 0.9 * sum(SKIN[:3]))  # along one
