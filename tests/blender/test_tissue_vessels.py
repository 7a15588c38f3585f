"""Vessels are drawn as Blender's curves: what they become, what is refused."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from lappet.core.problem_code import ProblemCode
from lappet.procedure import Procedure, Vessel
from lappet.tissue.patch import flat_patch
from lappet_blender.model.scene_filling import fill_scene
from lappet_blender.model.vessel_values import vessel_values
from refusals import refusal_code
from tissue_scenes import add_curve, fill_with_patch, read


def fill(scene: bpy.types.Scene, procedure: Procedure) -> None:
    """Replace what the scene holds."""
    fill_scene(scene, procedure, scene.collection)


@pytest.fixture
def patch(scene: bpy.types.Scene) -> bpy.types.Scene:
    fill_with_patch(scene, flat_patch((20.0, 20.0, 4.0), 2.0))
    return scene


@pytest.mark.parametrize("kind", ["POLY", "BEZIER"])
def test_a_selected_curve_becomes_a_vessel_in_mm_of_the_world(patch: bpy.types.Scene, kind: str) -> None:
    obj = add_curve(patch, kind, [(-5.0, -5.0, 0.0), (5.0, 5.0, 1.0)])
    obj.location = (0.0, 0.0, 0.002)
    bpy.context.view_layer.update()
    done = bpy.ops.lappet.vessels_add(kind="NERVE", radius=0.7, label="frontal branch", typical_course=True)
    assert done == {"FINISHED"}
    (vessel,) = read(patch).vessels
    assert (vessel.name, vessel.kind, vessel.label) == ("crease", "nerve", "frontal branch")
    assert vessel.radius == pytest.approx(0.7)
    assert vessel.typical_course
    assert vessel.points[0] == pytest.approx((-5.0, -5.0, 2.0), abs=1e-5)
    assert vessel.points[-1] == pytest.approx((5.0, 5.0, 3.0), abs=1e-5)


def test_a_vessel_can_be_removed_by_its_name(patch: bpy.types.Scene) -> None:
    for name in ("angular", "infraorbital"):
        add_curve(patch, "POLY", [(-5.0, 0.0, 2.0), (5.0, 0.0, 2.0)]).name = name
        bpy.ops.lappet.vessels_add(object=name)
    assert bpy.ops.lappet.vessel_remove(name="angular") == {"FINISHED"}
    assert [vessel.name for vessel in read(patch).vessels] == ["infraorbital"]
    assert refusal_code(lambda: bpy.ops.lappet.vessel_remove(name="angular")) == ProblemCode.VESSEL_UNKNOWN


def test_what_is_no_drawn_curve_is_refused(patch: bpy.types.Scene) -> None:
    tissue = patch.lappet.tissue.object
    refused = refusal_code(lambda: bpy.ops.lappet.vessels_add(object=tissue.name))
    assert refused == ProblemCode.OBJECT_NOT_A_CURVE
    assert len(patch.lappet.vessels) == 0


def test_a_procedure_with_vessels_goes_into_the_scene_and_comes_out_the_same(scene: bpy.types.Scene) -> None:
    course = ((-4.0, -4.0, 2.0), (0.0, 1.0, 2.5), (4.0, 4.0, 2.0), (6.0, 4.0, 2.0))
    vessels = (
        Vessel("angular", course, "artery", 0.5, "angular artery", True, "catmullRom"),
        Vessel("cervical", course, "lymphatic", 0.25),
    )
    fill(scene, Procedure(flat_patch((20.0, 20.0, 4.0), 2.0), vessels=vessels))
    assert vessel_values(scene) == vessels
    assert read(scene).vessels == vessels
    fill(scene, Procedure(flat_patch((20.0, 20.0, 4.0), 2.0)))
    assert len(scene.lappet.vessels) == 0


def test_points_of_vessels_keep_single_precision(scene: bpy.types.Scene) -> None:
    vessel = Vessel("v", ((-4.1, -4.3, 2.7), (4.0 / 3.0, 4.0, 2.0)), "vein", 0.3)
    fill(scene, Procedure(flat_patch((20.0, 20.0, 4.0), 2.0), vessels=(vessel,)))
    assert np.array_equal(vessel_values(scene)[0].points, vessel.points)
