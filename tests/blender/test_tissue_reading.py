"""What a scene is read as: the mesh's coordinates, groups and settings, and each thing that stands in the way."""

from __future__ import annotations

import bpy

from lappet_blender.model.scene_procedure import read_scene


def test_an_empty_scene_has_no_tissue_and_says_how_to_get_one(scene: bpy.types.Scene) -> None:
    reading = read_scene(scene)
    assert reading.procedure is None
    (problem,) = reading.problems
    assert problem.sentence == "The scene has no tissue."
    assert problem.operator == "lappet.tissue_set"
