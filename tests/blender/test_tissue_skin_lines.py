"""Skin lines are drawn as Blender's curves: what they become, what is refused, and where their fibers run."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from lappet.core.problem_code import ProblemCode
from lappet.program.compile import compile_program
from lappet.tissue.patch import flat_patch
from refusals import refusal_code
from tissue_scenes import add_curve, fill_with_patch, read


@pytest.fixture
def patch(scene: bpy.types.Scene) -> bpy.types.Scene:
    fill_with_patch(scene, flat_patch((20.0, 20.0, 4.0), 2.0))
    return scene


@pytest.mark.parametrize("kind", ["POLY", "BEZIER"])
def test_a_curve_becomes_a_line_in_mm_of_the_world_along_which_the_fibers_run(
    patch: bpy.types.Scene, kind: str
) -> None:
    obj = add_curve(patch, kind, [(-5.0, -5.0, 0.0), (5.0, 5.0, 0.0)])
    obj.location = (0.0, 0.0, 0.004)
    bpy.context.view_layer.update()
    assert bpy.ops.lappet.skin_lines_add(use_tension=True, tension=(20.0, 10.0)) == {"FINISHED"}
    procedure = read(patch)
    (line,) = procedure.skin_lines
    assert line.name == "crease"
    assert line.tension == (20.0, 10.0)
    assert line.points[0] == pytest.approx((-5.0, -5.0, 4.0), abs=1e-5)
    assert line.points[-1] == pytest.approx((5.0, 5.0, 4.0), abs=1e-5)
    directions = compile_program(procedure).epochs[0].regions.skin_directions
    assert len(directions)
    assert np.abs(directions @ np.array([1.0, 1.0, 0.0])) == pytest.approx(np.sqrt(2.0), abs=1e-5)


def test_a_freehand_stroke_of_many_knots_keeps_its_course_in_few_points(patch: bpy.types.Scene) -> None:
    angle = np.linspace(0.0, np.pi, 300)
    add_curve(patch, "BEZIER", [(8.0 * np.cos(a), 8.0 * np.sin(a), 4.0) for a in angle])
    bpy.ops.lappet.skin_lines_add()
    (line,) = read(patch).skin_lines
    assert 10 <= len(line.points) <= 50
    assert line.tension is None
    assert np.allclose(np.linalg.norm(np.array(line.points)[:, :2], axis=1), 8.0, atol=0.01)


def test_two_splines_of_a_curve_are_two_lines_of_their_own_names_and_each_can_be_removed(
    patch: bpy.types.Scene,
) -> None:
    obj = add_curve(patch, "POLY", [(-5.0, 0.0, 4.0), (5.0, 0.0, 4.0)])
    spline = obj.data.splines.new("POLY")
    spline.points.add(1)
    spline.points[0].co, spline.points[1].co = (-0.005, 0.003, 0.004, 1.0), (0.005, 0.003, 0.004, 1.0)
    bpy.ops.lappet.skin_lines_add(object="crease")
    names = [line.name for line in read(patch).skin_lines]
    assert len(set(names)) == 2
    assert bpy.ops.lappet.skin_line_remove(name=names[0]) == {"FINISHED"}
    assert [line.name for line in read(patch).skin_lines] == names[1:]


def test_what_is_no_drawn_curve_is_refused_and_nothing_is_added(patch: bpy.types.Scene) -> None:
    tissue = patch.lappet.tissue.object
    add_curve(patch, "POLY", []).name = "blank"
    for arguments, code in (
        ({"object": tissue.name}, ProblemCode.OBJECT_NOT_A_CURVE),
        ({"object": "blank"}, ProblemCode.CURVE_EMPTY),
        ({"object": "nobody"}, ProblemCode.OBJECT_UNKNOWN),
    ):
        assert refusal_code(lambda given=arguments: bpy.ops.lappet.skin_lines_add(**given)) == code
    assert refusal_code(lambda: bpy.ops.lappet.skin_line_remove(name="wrinkle")) == ProblemCode.SKIN_LINE_UNKNOWN
    assert len(patch.lappet.skin_lines) == 0
