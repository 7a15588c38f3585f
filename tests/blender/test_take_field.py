"""The skin around the 3D cursor becomes tissue, and the mesh that it was taken from stays."""

from __future__ import annotations

import bmesh
import bpy
import numpy as np
import pytest
from mathutils import Matrix

from lappet.core.problem_code import ProblemCode
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
