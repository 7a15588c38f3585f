"""What stands in the way of an object as tissue or bone: a sentence each, and the operator it names repairs it."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from lappet.core.problem import Problem
from lappet.core.problem_code import ProblemCode
from lappet.geometry.surface_check import first_intersection, signed_volume
from lappet.tissue.fan_triangles import fan_triangles
from lappet_blender.interface.problem_repairs import repair_of
from lappet_blender.model.scene_procedure import read_scene
from refusals import refusal_code
from tissue_scenes import add_box, add_sheet, fill_with_patch, read


def only_problem(scene: bpy.types.Scene) -> Problem:
    """The one problem of a scene that cannot be read."""
    reading = read_scene(scene)
    assert reading.procedure is None
    (problem,) = reading.problems
    return problem


def repair(problem: Problem) -> None:
    """Presses the problem's button."""
    found = repair_of(problem)
    assert found is not None
    part, name = found.operator.split(".")
    assert getattr(getattr(bpy.ops, part), name)(**dict(found.arguments)) == {"FINISHED"}


def test_a_tissue_that_was_deleted_can_be_brought_back(scene: bpy.types.Scene) -> None:
    given = fill_with_patch(scene)
    bpy.data.scenes["Scene"].collection.objects.unlink(scene.lappet.tissue.object)
    problem = only_problem(scene)
    assert (problem.code, problem.prim, problem.value) == (ProblemCode.OBJECT_NOT_IN_SCENE, "Tissue", "Scene")
    repair(problem)
    assert read(scene) == given


def test_a_tissue_removed_from_the_file_leaves_a_scene_without_one(scene: bpy.types.Scene) -> None:
    fill_with_patch(scene)
    bpy.data.objects.remove(scene.lappet.tissue.object)
    assert only_problem(scene).code is ProblemCode.TISSUE_NONE


def test_what_is_no_mesh_is_named(scene: bpy.types.Scene) -> None:
    scene.lappet.tissue.object = bpy.data.objects.new("lamp", bpy.data.lights.new("lamp", "POINT"))
    problem = only_problem(scene)
    assert (problem.code, problem.prim, problem.value) == (ProblemCode.OBJECT_NOT_A_MESH, "lamp", "light")


def test_a_mesh_without_a_face_is_no_tissue(scene: bpy.types.Scene) -> None:
    mesh = bpy.data.meshes.new("dots")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0)], [], [])
    scene.lappet.tissue.object = bpy.data.objects.new("dots", mesh)
    scene.collection.objects.link(scene.lappet.tissue.object)
    assert only_problem(scene).code is ProblemCode.MESH_EMPTY
    scene.lappet.tissue.object.data = bpy.data.meshes.new("nothing")
    assert only_problem(scene).code is ProblemCode.MESH_EMPTY


def test_an_applied_modifier_gives_the_shape_that_was_seen_and_keeps_the_groups(scene: bpy.types.Scene) -> None:
    given = fill_with_patch(scene)
    obj = scene.lappet.tissue.object
    modifier = obj.modifiers.new("Shift", "DISPLACE")
    modifier.direction, modifier.strength, modifier.mid_level = "Z", 2.0, 0.0
    problem = only_problem(scene)
    assert (problem.code, problem.prim, problem.value) == (ProblemCode.OBJECT_MODIFIERS, "Tissue", "Shift")
    repair(problem)
    found = read(scene).tissue
    np.testing.assert_allclose(found.points, given.tissue.points + np.array([0.0, 0.0, 2.0]), atol=1e-5)
    assert {name: faces.tolist() for name, faces in found.subsets.items()} == {
        name: faces.tolist() for name, faces in given.tissue.subsets.items()
    }
    assert len(obj.modifiers) == 0


def test_a_modifier_that_is_switched_off_is_no_problem(scene: bpy.types.Scene) -> None:
    given = fill_with_patch(scene)
    modifier = scene.lappet.tissue.object.modifiers.new("Subdivision", "SUBSURF")
    modifier.show_viewport = modifier.show_render = False
    assert read(scene) == given


def test_applied_shape_keys_stay_as_they_are_mixed(scene: bpy.types.Scene) -> None:
    given = fill_with_patch(scene)
    obj = scene.lappet.tissue.object
    obj.shape_key_add(name="Basis")
    key = obj.shape_key_add(name="Swollen")
    for point in key.data:
        point.co.z += 1.0
    key.value = 0.5
    problem = only_problem(scene)
    assert (problem.code, problem.value) == (ProblemCode.OBJECT_SHAPE_KEYS, "2")
    repair(problem)
    np.testing.assert_allclose(read(scene).tissue.points, given.tissue.points + np.array([0.0, 0.0, 0.5]), atol=1e-5)
    assert obj.data.shape_keys is None


@pytest.mark.parametrize(
    ("scale", "code"),
    [
        ((0.001, 0.002, 0.001), ProblemCode.OBJECT_STRETCHED),
        ((0.001, -0.001, 0.001), ProblemCode.OBJECT_MIRRORED),
    ],
)
def test_an_applied_scale_leaves_the_tissue_where_it_is_seen_and_outside_out(
    scene: bpy.types.Scene, scale: tuple[float, float, float], code: ProblemCode
) -> None:
    given = fill_with_patch(scene)
    obj = scene.lappet.tissue.object
    obj.location, obj.rotation_euler, obj.scale = (0.01, 0.0, 0.0), (0.0, 0.0, np.pi / 2), scale
    problem = only_problem(scene)
    assert problem.code is code
    repair(problem)
    x, y, z = (given.tissue.points * 1000.0 * scale).T
    found = read(scene).tissue
    np.testing.assert_allclose(found.points, np.stack([10.0 - y, x, z], axis=1), atol=1e-4)
    from lappet.geometry.surface_check import signed_volume
    from lappet.geometry.triangulation import triangulate

    triangles = triangulate(found.points, found.face_vertex_counts.astype(int), found.face_vertex_indices.astype(int))
    assert signed_volume(found.points, triangles[0]) > 0.0


def test_a_mesh_that_another_object_uses_is_copied_before_a_scale_is_applied(scene: bpy.types.Scene) -> None:
    fill_with_patch(scene)
    obj = scene.lappet.tissue.object
    other = bpy.data.objects.new("other", obj.data)
    before = np.array([vertex.co for vertex in other.data.vertices])
    obj.scale.x *= 2.0
    repair(only_problem(scene))
    np.testing.assert_array_equal([vertex.co for vertex in other.data.vertices], before)


def test_a_tissue_that_keyframes_or_a_constraint_move_is_fixed_where_it_stands(scene: bpy.types.Scene) -> None:
    given = fill_with_patch(scene)
    obj = scene.lappet.tissue.object
    obj.keyframe_insert("location", frame=1)
    problem = only_problem(scene)
    assert (problem.code, problem.value) == (ProblemCode.OBJECT_MOVES, "keyframes")
    repair(problem)
    assert read(scene) == given
    constraint = obj.constraints.new("COPY_LOCATION")
    constraint.target = bpy.data.objects.new("leader", None)
    scene.collection.objects.link(constraint.target)
    constraint.target.location = (0.0, 0.0, 0.05)
    bpy.context.view_layer.update()
    problem = only_problem(scene)
    assert problem.value == "the constraint Copy Location"
    repair(problem)
    np.testing.assert_allclose(read(scene).tissue.points, given.tissue.points + np.array([0.0, 0.0, 50.0]), atol=1e-4)


def test_a_tissue_whose_parent_is_keyframed_lets_go_of_it(scene: bpy.types.Scene) -> None:
    given = fill_with_patch(scene)
    parent = bpy.data.objects.new("parent", None)
    scene.collection.objects.link(parent)
    scene.lappet.tissue.object.parent = parent
    assert read(scene) == given
    parent.keyframe_insert("rotation_euler", frame=1)
    problem = only_problem(scene)
    assert problem.value == "keyframes of its parent 'parent'"
    repair(problem)
    assert scene.lappet.tissue.object.parent is None
    assert read(scene) == given


def test_a_linked_mesh_is_made_local_and_its_library_stays_as_it_was(scene: bpy.types.Scene, blend: Path) -> None:
    given = fill_with_patch(scene)
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    kept = blend.read_bytes()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    fresh = bpy.context.scene
    with bpy.data.libraries.load(str(blend), link=True) as (_, wanted):
        wanted.objects = ["Tissue"]
    fresh.collection.objects.link(wanted.objects[0])
    fresh.lappet.tissue.object = wanted.objects[0]
    problem = only_problem(fresh)
    assert problem.code is ProblemCode.OBJECT_LINKED
    assign = bpy.ops.lappet.faces_assign
    assert refusal_code(lambda: assign(group="fixed", which="ALL")) is ProblemCode.OBJECT_LINKED
    repair(problem)
    found = read(fresh).tissue
    np.testing.assert_array_equal(found.points, given.tissue.points)
    assert fresh.lappet.tissue.object.data.library is None
    assert bpy.ops.lappet.faces_assign(group="fixed", which="ALL") == {"FINISHED"}
    assert blend.read_bytes() == kept


def test_a_mesh_cannot_be_tissue_and_bone_or_two_bones(scene: bpy.types.Scene) -> None:
    fill_with_patch(scene)
    entry = scene.lappet.bones.add()
    entry.object = scene.lappet.tissue.object
    problem = only_problem(scene)
    assert (problem.code, problem.prim) == (ProblemCode.BONE_IS_TISSUE, "Tissue")
    repair(problem)
    assert len(scene.lappet.bones) == 0
    box = add_box(scene, (0.0, 0.0, -0.02), (0.01, 0.01, -0.01), name="skull")
    for _ in range(2):
        scene.lappet.bones.add().object = box
    problem = only_problem(scene)
    assert (problem.code, problem.prim) == (ProblemCode.BONE_TWICE, "skull")
    repair(problem)
    assert [bone.name for bone in read(scene).bones] == ["skull"]


def test_bones_are_read_in_the_world_under_names_that_a_stage_takes(scene: bpy.types.Scene) -> None:
    fill_with_patch(scene)
    box = add_box(scene, (0.0, 0.0, 0.0), (0.01, 0.01, 0.01), name="2 skull.cap")
    box.matrix_basis = Matrix.Translation((0.0, 0.0, -0.05))
    assert bpy.ops.lappet.bone_add() == {"FINISHED"}
    (bone,) = read(scene).bones
    assert bone.name == "_2_skull_cap"
    assert bone.points.min(axis=0).tolist() == pytest.approx([0.0, 0.0, -50.0])
    assert refusal_code(lambda: bpy.ops.lappet.bone_add(object="2 skull.cap")) is ProblemCode.BONE_KNOWN
    assert bpy.ops.lappet.bone_remove(object="2 skull.cap") == {"FINISHED"}
    assert read(scene).bones == ()


def test_an_open_surface_without_a_thickness_is_no_tissue_yet(scene: bpy.types.Scene) -> None:
    scene.lappet.tissue.object = add_sheet(scene)
    problem = only_problem(scene)
    assert (problem.code, problem.prim) == (ProblemCode.MESH_OPEN, "skin")
    assert problem.place is not None
    assert len(problem.place.points) == 32  # one for each edge of the border
    scene.lappet.tissue.thicken = True
    assert read(scene).tissue.subsets["bed"].tolist() == list(range(64, 128))


def test_a_thickness_of_a_closed_surface_is_refused_and_switched_off(scene: bpy.types.Scene) -> None:
    given = fill_with_patch(scene)
    scene.lappet.tissue.thicken = True
    problem = only_problem(scene)
    assert (problem.code, problem.value) == (ProblemCode.SHEET_OF_CLOSED_SURFACE, "4")
    repair(problem)
    assert read(scene) == given


def test_a_sheet_too_thick_for_its_curvature_is_as_thick_as_there_is_room(scene: bpy.types.Scene) -> None:
    axis = np.linspace(0.2 * np.pi, 1.8 * np.pi, 25)  # most of a tube of 3 mm radius, looking inwards
    places = [(0.003 * np.cos(a), 0.003 * np.sin(a), z) for a in axis for z in np.linspace(0.0, 0.01, 9)]
    faces = [[9 * i + k, 9 * i + k + 1, 9 * i + k + 10, 9 * i + k + 9] for i in range(24) for k in range(8)]
    from tissue_scenes import add_mesh

    obj = add_mesh(scene, "tube", places, [face[::-1] for face in faces])
    scene.lappet.tissue.object, scene.lappet.tissue.thicken, scene.lappet.tissue.thickness = obj, True, 5.0
    tissue = read(scene).tissue
    to_axis = np.linalg.norm(tissue.points[:, :2], axis=1)
    assert to_axis.max() == pytest.approx(3.0, abs=0.05)
    triangles = fan_triangles(tissue)[0]
    assert first_intersection(tissue.points, triangles) is None  # where 5 mm would cross the axis
    assert signed_volume(tissue.points, triangles) > 0.0
    assert 0.0 < to_axis.min() < 2.0
    scene.lappet.tissue.thickness = 1.0
    assert np.linalg.norm(read(scene).tissue.points[:, :2], axis=1).min() == pytest.approx(2.0, abs=0.1)


def test_an_event_that_cannot_be_read_is_named_and_the_others_still_are(scene: bpy.types.Scene) -> None:
    fill_with_patch(scene)
    event = scene.lappet.events.add()
    event.name, event.kind, event.uid = "hook_1", "HOOK", "1"
    problem = only_problem(scene)
    assert problem.prim == "hook_1"
    event.enabled = False
    assert read(scene).events == ()


def test_a_vertex_without_a_finite_place_is_named_and_nothing_is_made_of_it(scene: bpy.types.Scene) -> None:
    fill_with_patch(scene)
    scene.lappet.tissue.object.data.vertices[7].co.x = float("nan")
    problem = only_problem(scene)
    assert problem.code is ProblemCode.MESH_NOT_FINITE
    assert bpy.ops.lappet.tissue_check() == {"FINISHED"}
    assert refusal_code(lambda: bpy.ops.lappet.tissue_set(object="Tissue")) is ProblemCode.MESH_NOT_FINITE


def test_a_scale_of_0_is_a_problem_that_cannot_be_applied(scene: bpy.types.Scene) -> None:
    fill_with_patch(scene)
    scene.lappet.tissue.object.scale.z = 0.0
    problem = only_problem(scene)
    assert refusal_code(lambda: repair(problem)) is ProblemCode.OBJECT_SCALE_ZERO


def test_a_rigid_parent_stays_when_a_scale_is_applied(scene: bpy.types.Scene) -> None:
    given = fill_with_patch(scene)
    obj = scene.lappet.tissue.object
    parent = bpy.data.objects.new("parent", None)
    scene.collection.objects.link(parent)
    parent.location = (0.0, 0.02, 0.0)
    obj.parent = parent
    obj.scale = (0.001, 0.001, 0.003)
    repair(only_problem(scene))
    assert obj.parent == parent
    expected = given.tissue.points * (1.0, 1.0, 3.0) + np.array([0.0, 20.0, 0.0])
    np.testing.assert_allclose(read(scene).tissue.points, expected, atol=1e-4)
