"""The stage of a figure: camera, lights and paper around the skin, and the body around the tissue."""

from __future__ import annotations

from dataclasses import replace

import bpy
import numpy as np
import pytest
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Vector
from numpy.typing import NDArray

from lappet.core.problem_code import ProblemCode
from lappet.procedure import Scenery
from lappet_blender.display.frame_all import off_stage
from lappet_blender.look.skin_material import skin_material
from lappet_blender.model.scenery_values import make_scenery
from refusals import refusal_code
from slit_manifest import shown, solved, vertices
from small_procedure import small_procedure

__all__ = ["shown", "solved"]  # fixtures


def skin_in_picture(scene: bpy.types.Scene) -> list[tuple[float, float]]:
    """Where in the camera's picture, 0 to 1, the corners of the tissue's box are."""
    tissue = scene.lappet.tissue.object
    seen = [world_to_camera_view(scene, scene.camera, tissue.matrix_world @ Vector(each)) for each in tissue.bound_box]
    return [(each.x, each.y) for each in seen]


def evaluated_corners(obj: bpy.types.Object) -> NDArray[np.float64]:
    """The corners of a flat mesh in the world as its modifiers leave it in a view, shape (n, 3)."""
    bpy.context.view_layer.update()
    there = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return np.array([there.matrix_world @ vertex.co for vertex in there.data.vertices])


def test_a_stage_without_a_solved_skin_is_refused(scene: bpy.types.Scene) -> None:
    assert refusal_code(bpy.ops.lappet.set_stage) is ProblemCode.FIGURE_NOTHING_SHOWN
    assert scene.camera is None


def test_setting_the_stage_again_replaces_it_and_clearing_it_leaves_nothing(shown: bpy.types.Scene) -> None:
    before = {o.name for o in shown.objects}
    bpy.ops.lappet.set_stage(engine="KEEP")
    count = len(shown.objects)
    bpy.ops.lappet.set_stage(engine="KEEP", view="TOP")
    assert len(shown.objects) == count
    bpy.ops.lappet.clear_stage()
    assert {o.name for o in shown.objects} == before


def test_framing_leaves_out_the_stage_and_nothing_else(shown: bpy.types.Scene) -> None:
    layer = bpy.context.view_layer
    assert off_stage(shown, layer) == []
    before = set(shown.objects)
    bpy.ops.lappet.set_stage(engine="KEEP")
    bpy.context.view_layer.update()
    assert set(off_stage(shown, layer)) == set(shown.objects) - before
    next(each for each in shown.objects if each.name == "Backdrop").hide_set(True)
    assert "Backdrop" not in [each.name for each in off_stage(shown, layer)]  # what the user hid stays hidden after


@pytest.mark.parametrize("view", ["OBLIQUE", "TOP", "LOW"])
def test_the_stages_paper_fills_the_picture_in_a_view_and_reaches_the_horizon_in_a_render(
    shown: bpy.types.Scene, view: str
) -> None:
    """Frame All of a view holds the paper as the view shows it: were it all of it, the skin would be a dot."""
    bpy.ops.lappet.set_stage(engine="KEEP", view=view, width=1600, height=1200)
    paper, camera = shown.objects["Backdrop"], shown.camera
    corners = evaluated_corners(paper)
    picture = [world_to_camera_view(shown, camera, Vector(each)) for each in corners]
    assert min(each.z for each in picture) > 0.0
    for axis in (0, 1):
        assert min(each[axis] for each in picture) < 0.0
        assert max(each[axis] for each in picture) > 1.0
    lights = np.array([each.location for each in shown.objects if each.type == "LIGHT"])
    widest = float(np.ptp(lights, axis=0).max())
    assert np.ptp(corners, axis=0).max() < 2.0 * widest
    assert paper.modifiers[0].show_render
    paper.modifiers[0].show_viewport = True
    assert np.ptp(evaluated_corners(paper), axis=0).max() > 10.0 * widest


def test_an_oblique_stage_is_seen_so_steeply_that_the_patch_fills_the_picture(shown: bpy.types.Scene) -> None:
    """As a plate is: the rim of a patch is no part of an operation."""
    bpy.ops.lappet.set_stage(engine="KEEP", view="OBLIQUE", width=1600, height=1200)
    tissue = shown.lappet.tissue.object
    skin = np.array([tissue.matrix_world @ Vector(each) for each in vertices(tissue)])
    (west, south), (east, north) = skin[:, :2].min(axis=0), skin[:, :2].max(axis=0)
    rim = [(west, south), (east, south), (east, north), (west, north)]
    seen = [world_to_camera_view(shown, shown.camera, Vector((*each, skin[:, 2].max()))) for each in rim]
    for (x, y, _), (next_x, next_y, _) in zip(seen, [*seen[1:], seen[0]], strict=True):
        for corner_x, corner_y in ((0, 0), (0, 1), (1, 0), (1, 1)):
            assert (next_x - x) * (corner_y - y) > (next_y - y) * (corner_x - x)


def test_where_a_body_is_shown_the_stage_holds_enough_of_it_and_its_paper_lies_below(shown: bpy.types.Scene) -> None:
    """As plates do: of a wound alone nobody knows where on a face it is."""
    bpy.ops.lappet.set_stage(engine="KEEP", view="TOP", width=1600, height=1200)
    alone = np.array(skin_in_picture(shown))
    bpy.ops.mesh.primitive_uv_sphere_add(radius=10.0, location=(0.0, 0.0, -12.0))
    body = bpy.context.object
    body["lappet_scenery"] = "skin"
    bpy.ops.lappet.set_stage(engine="KEEP", view="TOP", width=1600, height=1200)
    around = np.array(skin_in_picture(shown))
    assert np.ptp(alone[:, 0]) > 1.0  # the patch's rim is beyond the picture
    assert around.min() > 0.0
    assert around.max() < 1.0
    paper = shown.objects["Backdrop"].matrix_world.translation.z
    assert paper < min((body.matrix_world @ vertex.co).z for vertex in body.data.vertices)
    body.hide_render = True
    bpy.ops.lappet.set_stage(engine="KEEP", view="TOP", width=1600, height=1200)
    np.testing.assert_allclose(skin_in_picture(shown), alone, atol=1e-5)


def test_the_skin_of_the_body_around_has_the_color_of_the_tissues_own(scene: bpy.types.Scene) -> None:
    """Or the cut-out shows as a disk on a face."""
    square = np.array([(0.0, 0.0, 0.0), (9.0, 0.0, 0.0), (9.0, 9.0, 0.0)])
    around = Scenery("Around", square, np.array([3]), np.array([0, 1, 2]), "skin")
    (made,) = make_scenery(scene, scene.collection, replace(small_procedure(), scenery=(around,)))

    def shader(material: bpy.types.Material) -> bpy.types.ShaderNode:
        return next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")

    own, other = shader(skin_material("plain", 0.1)), shader(made.data.materials[0])
    mottle = own.inputs["Base Color"].links[0].from_node.color_ramp.elements
    between = np.array([element.color[:3] for element in mottle])
    color = np.array(other.inputs["Base Color"].default_value[:3])
    assert (between.min(axis=0) < color).all()
    assert (color < between.max(axis=0)).all()
    assert other.inputs["Roughness"].default_value == own.inputs["Roughness"].default_value


def test_a_stage_that_is_removed_leaves_no_nodes(shown: bpy.types.Scene) -> None:
    before = len(bpy.data.node_groups)
    bpy.ops.lappet.set_stage(engine="KEEP")
    bpy.ops.lappet.set_stage(engine="KEEP")
    assert len(bpy.data.node_groups) == before + 1
    bpy.ops.lappet.clear_stage()
    assert len(bpy.data.node_groups) == before
