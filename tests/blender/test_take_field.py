"""The skin around the 3D cursor becomes tissue, and the mesh that it was taken from stays."""

from __future__ import annotations

import bmesh
import bpy
import numpy as np
import pytest
from mathutils import Matrix

from lappet.core.problem_code import ProblemCode
from lappet_blender.interface.operator_base import last_refusal
from refusals import refusal_code
from tissue_scenes import add_mesh, read

RADIUS = 80.0  # mm


@pytest.fixture
def ball(scene: bpy.types.Scene) -> bpy.types.Object:
    obj = add_mesh(scene, "head", [], [])
    form = bmesh.new()
    bmesh.ops.create_icosphere(form, subdivisions=5, radius=0.001 * RADIUS)
    form.to_mesh(obj.data)
    form.free()
    return obj


def test_the_skin_around_the_cursor_is_the_tissue_and_the_mesh_stays_hidden(
    scene: bpy.types.Scene, ball: bpy.types.Object
) -> None:
    scene.cursor.location = (0.0, -0.001 * RADIUS, 0.0)
    faces = len(ball.data.polygons)
    assert bpy.ops.lappet.tissue_take_field(radius=20.0, thickness=4.0) == {"FINISHED"}
    tissue = read(scene).tissue
    away = np.linalg.norm(tissue.points, axis=1)
    assert away.max() == pytest.approx(RADIUS, abs=0.05)
    assert away.min() == pytest.approx(RADIUS - 4.0, abs=0.1)
    assert tissue.points[:, 1].max() < -RADIUS * np.cos(20.0 / RADIUS) + 4.1
    assert set(tissue.subsets) == {"fixed", "bed"}
    made = scene.lappet.tissue.object
    assert made.name == "head field"
    assert bpy.context.view_layer.objects.active == made
    assert len(ball.data.polygons) == faces
    assert ball.hide_get()


def test_a_mesh_that_is_moved_and_turned_is_taken_where_it_stands(
    scene: bpy.types.Scene, ball: bpy.types.Object
) -> None:
    ball.matrix_world = Matrix.Translation((0.5, 0.0, 0.0)) @ Matrix.Rotation(1.0, 4, "X")
    bpy.context.view_layer.update()
    bpy.ops.lappet.tissue_take_field(point=(500.0, 0.0, RADIUS), radius=20.0, thickness=4.0)
    points = read(scene).tissue.points
    assert np.linalg.norm(points - (500.0, 0.0, 0.0), axis=1).max() == pytest.approx(RADIUS, abs=0.05)
    assert points[:, 2].min() > RADIUS * np.cos(20.0 / RADIUS) - 4.1


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        ({"point": (0.0, 0.0, 300.0), "radius": 20.0}, ProblemCode.REGION_POINT_OFF_SURFACE),
        ({"object": "nobody"}, ProblemCode.OBJECT_UNKNOWN),
    ],
)
def test_what_cannot_be_taken_is_refused_and_nothing_has_changed(
    scene: bpy.types.Scene, ball: bpy.types.Object, arguments: dict, code: ProblemCode
) -> None:
    objects = len(bpy.data.objects)
    assert refusal_code(lambda: bpy.ops.lappet.tissue_take_field(**arguments)) is code
    assert scene.lappet.tissue.object is None
    assert len(bpy.data.objects) == objects
    assert not ball.hide_get()


def select_cap(ball: bpy.types.Object, angle: float) -> np.ndarray:
    """Select the faces within an angle of the top, and mark their points as a vertex group; which faces."""
    middle = np.array([tuple(face.center) for face in ball.data.polygons])
    inside = middle[:, 2] > 0.001 * RADIUS * np.cos(angle)
    ball.data.polygons.foreach_set("select", inside)
    group = ball.vertex_groups.new(name="field")
    points = {k for face, chosen in zip(ball.data.polygons, inside, strict=True) if chosen for k in face.vertices}
    group.add(sorted(points), 1.0, "REPLACE")
    return inside


@pytest.mark.parametrize("way", [{"selection": True}, {"region": "field"}])
def test_marked_faces_become_tissue_with_a_fixed_rim_and_a_bed_in_one_step(
    scene: bpy.types.Scene, ball: bpy.types.Object, way: dict[str, object]
) -> None:
    angle = 0.3
    select_cap(ball, angle)
    assert bpy.ops.lappet.tissue_take_field(thickness=4.0, **way) == {"FINISHED"}
    tissue = read(scene).tissue
    away = np.linalg.norm(tissue.points, axis=1)
    assert away.max() == pytest.approx(RADIUS, abs=0.1)
    assert away.min() == pytest.approx(RADIUS - 4.0, abs=0.15)
    reach = np.arccos(tissue.points[:, 2] / away).max()
    assert reach == pytest.approx(angle, abs=0.05)
    assert set(tissue.subsets) == {"fixed", "bed"}
    assert ball.hide_get()


def test_faces_are_taken_in_edit_mode_as_they_are_selected_there(
    scene: bpy.types.Scene, ball: bpy.types.Object
) -> None:
    select_cap(ball, 0.3)
    bpy.context.view_layer.objects.active = ball
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.lappet.tissue_take_field(thickness=4.0, selection=True)
    assert bpy.context.mode == "OBJECT"
    assert scene.lappet.tissue.object.name == "head field"


def test_a_whole_closed_mesh_has_no_border_to_hold(scene: bpy.types.Scene, ball: bpy.types.Object) -> None:
    select_cap(ball, np.pi)
    with pytest.raises(RuntimeError):
        bpy.ops.lappet.tissue_take_field(thickness=4.0, selection=True)
    assert [each.code for each in last_refusal()] == [ProblemCode.FACES_NO_BORDER]
    assert scene.lappet.tissue.object is None
