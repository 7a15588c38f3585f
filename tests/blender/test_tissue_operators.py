"""The operators that make tissue, its groups, materials, regions and bones: each act, its refusal, one step of undo."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from lappet.checks.suspicious_tissue import size_problems
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Region
from lappet.tissue.presets import PRESETS
from lappet_blender.interface.problem_sentence import problem_sentence
from lappet_blender.model.procedure_properties import VERSION
from lappet_blender.tissue.set_tissue import set_tissue
from refusals import refusal_code
from tissue_scenes import add_box, add_sheet, fill_with_patch, read


def group(obj: bpy.types.Object, name: str) -> list[int]:
    """The faces of a group."""
    return [i for i, each in enumerate(obj.data.attributes[f"lappet_{name}"].data) if each.value]


def test_a_closed_mesh_becomes_tissue_with_spacing_material_and_frames_chosen(scene: bpy.types.Scene) -> None:
    add_box(scene, (0.0, 0.0, 0.0), (0.1, 0.08, 0.004))
    assert bpy.ops.lappet.tissue_set() == {"FINISHED"}
    procedure = read(scene)
    # 32 000 mm³ in 40 000 cells: 0.928 mm, two digits.
    assert procedure.tissue.spacing == 0.93
    assert procedure.materials == (PRESETS["skin"].material,)
    assert procedure.tissue.material == "skin"
    assert (procedure.start_time, procedure.end_time) == (1.0, 40.0)
    assert scene.lappet.version == VERSION


def test_frames_that_the_user_chose_are_left_alone(scene: bpy.types.Scene) -> None:
    scene.frame_end = 99
    add_box(scene)
    bpy.ops.lappet.tissue_set(spacing=0.5, preset="FAT")
    procedure = read(scene)
    assert (procedure.start_time, procedure.end_time) == (1.0, 99.0)
    assert procedure.tissue.spacing == 0.5
    assert procedure.tissue.material == "fat"


def test_an_open_surface_is_thickened_and_laid_out_flat_at_1_unit_per_100_mm(scene: bpy.types.Scene) -> None:
    obj = add_sheet(scene)
    assert bpy.ops.lappet.tissue_set(object="skin", thickness=3.0) == {"FINISHED"}
    tissue = read(scene).tissue
    assert tissue.spacing == 0.75  # a quarter of the thickness: the tissue is small
    length = np.linalg.norm(np.diff(tissue.uv[[0, 1]], axis=0))
    assert length == pytest.approx(0.025, rel=1e-4)  # an edge of 2.5 mm
    # On its own thread, as the tissue is: Blender's user does not wait, and the mesh stays what it is.
    assert obj.data.uv_layers.active is None


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        ({}, ProblemCode.OBJECT_NONE_ACTIVE),
        ({"object": "nobody"}, ProblemCode.OBJECT_UNKNOWN),
        ({"object": "lamp"}, ProblemCode.OBJECT_NOT_A_MESH),
        ({"object": "block", "thickness": 2.0}, ProblemCode.SHEET_OF_CLOSED_SURFACE),
        ({"object": "empty"}, ProblemCode.MESH_EMPTY),
        ({"object": "bone"}, ProblemCode.BONE_IS_TISSUE),
    ],
)
def test_what_cannot_be_tissue_is_refused_and_nothing_has_changed(
    scene: bpy.types.Scene, arguments: dict, code: ProblemCode
) -> None:
    add_box(scene)
    add_box(scene, name="bone")
    scene.lappet.bones.add().object = bpy.data.objects["bone"]
    for name, data in (("lamp", bpy.data.lights.new("lamp", "POINT")), ("empty", bpy.data.meshes.new("empty"))):
        scene.collection.objects.link(bpy.data.objects.new(name, data))
    bpy.context.view_layer.objects.active = None
    assert refusal_code(lambda: bpy.ops.lappet.tissue_set(**arguments)) is code
    assert scene.lappet.tissue.object is None
    assert len(scene.lappet.materials) == 0
    assert scene.lappet.version == 0


def test_letting_go_of_the_tissue_keeps_the_mesh(scene: bpy.types.Scene) -> None:
    fill_with_patch(scene)
    assert bpy.ops.lappet.tissue_clear() == {"FINISHED"}
    assert scene.lappet.tissue.object is None
    assert "Tissue" in scene.objects


def test_sides_and_bottom_of_a_slab_are_fixed_and_bedded_by_two_calls(scene: bpy.types.Scene) -> None:
    obj = add_box(scene)
    bpy.ops.lappet.tissue_set()
    bpy.ops.lappet.faces_assign(group="fixed", which="SIDES")
    bpy.ops.lappet.faces_assign(group="bed", which="BOTTOM")
    assert group(obj, "fixed") == [2, 3, 4, 5]
    assert group(obj, "bed") == [0]
    bpy.ops.lappet.faces_assign(group="top", which="TOP")
    assert {name: faces.tolist() for name, faces in read(scene).tissue.subsets.items()} == {
        "fixed": [2, 3, 4, 5],
        "bed": [0],
        "top": [1],
    }


def test_sides_are_those_of_the_world_however_the_object_lies(scene: bpy.types.Scene) -> None:
    obj = add_box(scene)
    obj.rotation_euler.x = np.pi / 2  # its front (2) is now below
    bpy.ops.lappet.tissue_set()
    bpy.ops.lappet.faces_assign(group="bed", which="BOTTOM")
    assert group(obj, "bed") == [2]


def test_faces_are_added_taken_out_and_set_by_index(scene: bpy.types.Scene) -> None:
    fill_with_patch(scene)
    obj = scene.lappet.tissue.object
    for faces, action, expected in (
        ("3, 5-7", "ADD", [3, 5, 6, 7]),
        ("1", "ADD", [1, 3, 5, 6, 7]),
        ("5-6", "REMOVE", [1, 3, 7]),
        ("0", "SET", [0]),
    ):
        assert bpy.ops.lappet.faces_assign(group="grip", faces=faces, action=action) == {"FINISHED"}
        assert group(obj, "grip") == expected


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        ({"group": "grip", "faces": "0-9999"}, ProblemCode.FACES_RANGE),
        ({"group": "grip", "faces": "one"}, ProblemCode.FACES_TEXT),
        ({"group": "my grip", "faces": "1"}, ProblemCode.GROUP_NAME),
        ({"group": "grip", "which": "SELECTED"}, ProblemCode.FACES_NONE),
        ({"group": "grip", "which": "BOUNDARY"}, ProblemCode.FACES_NONE),
    ],
)
def test_a_choice_of_faces_that_is_none_is_refused(scene: bpy.types.Scene, arguments: dict, code: ProblemCode) -> None:
    given = fill_with_patch(scene)
    for polygon in scene.lappet.tissue.object.data.polygons:
        polygon.select = False
    assert refusal_code(lambda: bpy.ops.lappet.faces_assign(**arguments)) is code
    assert read(scene) == given


def test_the_selection_of_edit_mode_is_assigned_selected_and_cleared_there(scene: bpy.types.Scene) -> None:
    import bmesh

    fill_with_patch(scene)
    obj = scene.lappet.tissue.object
    for polygon in obj.data.polygons:
        polygon.select = polygon.index in (4, 8)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_mode(type="FACE")
    work = bmesh.from_edit_mesh(obj.data)
    for face in work.faces:
        face.select_set(face.index in (4, 8))
    assert bpy.ops.lappet.faces_assign(group="grip") == {"FINISHED"}
    assert read(scene).tissue.subsets["grip"].tolist() == [4, 8]
    bpy.ops.mesh.select_all(action="DESELECT")
    bpy.ops.lappet.faces_select(group="grip")
    work = bmesh.from_edit_mesh(obj.data)
    assert [face.index for face in work.faces if face.select] == [4, 8]
    bpy.ops.object.mode_set(mode="OBJECT")
    assert group(obj, "grip") == [4, 8]
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.lappet.faces_clear(group="grip")
    bpy.ops.object.mode_set(mode="OBJECT")
    assert "grip" not in read(scene).tissue.subsets


def test_selecting_a_group_out_of_edit_mode_replaces_or_extends_the_selection(scene: bpy.types.Scene) -> None:
    fill_with_patch(scene)
    obj = scene.lappet.tissue.object
    bpy.ops.lappet.faces_assign(group="grip", faces="2,9")
    bpy.ops.lappet.faces_select(group="grip")
    assert [polygon.index for polygon in obj.data.polygons if polygon.select] == [2, 9]
    bpy.ops.lappet.faces_assign(group="other", faces="3")
    bpy.ops.lappet.faces_select(group="other", extend=True)
    assert [polygon.index for polygon in obj.data.polygons if polygon.select] == [2, 3, 9]
    assert refusal_code(lambda: bpy.ops.lappet.faces_select(group="none")) is ProblemCode.GROUP_UNKNOWN


def test_one_undo_takes_one_act_back_and_redo_brings_it_again(scene: bpy.types.Scene) -> None:
    add_box(scene)
    bpy.ops.ed.undo_push(message="box")
    bpy.ops.lappet.tissue_set("EXEC_DEFAULT", True)
    bpy.ops.lappet.faces_assign("EXEC_DEFAULT", True, group="fixed", which="SIDES")
    held = read(bpy.context.scene)
    bpy.ops.ed.undo()
    assert read(bpy.context.scene).tissue.subsets == {}
    bpy.ops.ed.undo()
    assert bpy.context.scene.lappet.tissue.object is None
    assert bpy.context.scene.lappet.version == 0
    bpy.ops.ed.redo()
    bpy.ops.ed.redo()
    assert read(bpy.context.scene) == held


def test_materials_are_added_renamed_and_given_presets_and_nothing_loses_its_own(scene: bpy.types.Scene) -> None:
    fill_with_patch(scene)
    bpy.ops.lappet.material_add(preset="FAT")
    bpy.ops.lappet.material_add(preset="FAT")
    assert [material.name for material in read(scene).materials] == ["skin", "fat", "fat_2"]
    bpy.ops.lappet.region_add(group="bed", material="fat", depth_from=1.5)
    bpy.ops.lappet.material_rename(name="fat", new_name="deep")
    bpy.ops.lappet.material_rename(name="skin", new_name="scalp")
    procedure = read(scene)
    assert procedure.tissue.material == "scalp"
    assert procedure.tissue.regions == (Region("bed", "deep", 1.5),)
    bpy.ops.lappet.material_preset(name="scalp", preset="DERMIS")
    from dataclasses import replace

    found, given = read(scene).material("scalp"), PRESETS["dermis"].material
    rounded = {name: pytest.approx(getattr(given, name), rel=1e-6) for name in ("youngs_modulus", "fiber_k1")}
    assert {name: getattr(found, name) for name in rounded} == rounded
    same = {name: getattr(found, name) for name in ("name", *rounded)}
    assert found == replace(given, **same)


@pytest.mark.parametrize(
    ("operator", "arguments", "code"),
    [
        ("material_remove", {"name": "skin"}, ProblemCode.MATERIAL_IN_USE),
        ("material_remove", {"name": "fat"}, ProblemCode.MATERIAL_IN_USE),
        ("material_remove", {"name": "steel"}, ProblemCode.MATERIAL_UNKNOWN),
        ("material_rename", {"name": "fat", "new_name": "skin"}, ProblemCode.MATERIAL_EXISTS),
        ("material_rename", {"name": "fat", "new_name": "deep fat"}, ProblemCode.MATERIAL_NAME),
        ("material_add", {"name": "fat"}, ProblemCode.MATERIAL_EXISTS),
        ("region_add", {"group": "bed", "material": "fat"}, ProblemCode.REGION_SUBSET_TWICE),
        ("region_add", {"group": "nose", "material": "fat"}, ProblemCode.GROUP_UNKNOWN),
        ("region_add", {"group": "fixed", "material": "steel"}, ProblemCode.MATERIAL_UNKNOWN),
        ("region_add", {"group": "fixed", "depth_from": 3.0, "depth_to": 2.0}, ProblemCode.REGION_DEPTHS),
        ("region_remove", {"group": "fixed"}, ProblemCode.REGION_OF_GROUP_UNKNOWN),
    ],
)
def test_materials_and_regions_in_use_or_not_there_are_refused(
    scene: bpy.types.Scene, operator: str, arguments: dict, code: ProblemCode
) -> None:
    fill_with_patch(scene)
    bpy.ops.lappet.material_add(preset="FAT")
    bpy.ops.lappet.region_add(group="bed", material="fat", depth_from=1.5)
    before = read(scene)
    assert refusal_code(lambda: getattr(bpy.ops.lappet, operator)(**arguments)) is code
    assert read(scene) == before


def test_keyframes_of_a_muscle_stay_with_it_when_a_material_before_it_goes(scene: bpy.types.Scene) -> None:
    fill_with_patch(scene)
    bpy.ops.lappet.material_add(name="filler")
    bpy.ops.lappet.material_add(name="muscle")
    for material, value in (("filler", 0.2), ("muscle", 0.9)):
        each = scene.lappet.materials[material]
        each.muscle_stress = 100.0
        for frame, activation in ((1, 0.0), (5, value)):
            each.activation = activation
            each.keyframe_insert("activation", frame=frame)
    bpy.ops.lappet.material_remove(name="filler")
    samples = dict(read(scene).material("muscle").muscle_activation)
    assert (samples[1.0], samples[5.0]) == (0.0, 0.9)
    # Blender eases between keyframes by default; a sample a frame follows the curve.
    assert sorted(samples) == [float(frame) for frame in range(1, 11)]
    assert 0.0 < samples[2.0] < 0.9 / 4


def test_an_activation_without_keyframes_holds_throughout(scene: bpy.types.Scene) -> None:
    fill_with_patch(scene)
    scene.lappet.materials[0].activation = 0.4
    assert read(scene).materials[0].muscle_activation == ((1.0, 0.4),)


def test_a_head_of_25_m_is_noticed_when_it_becomes_the_tissue(scene: bpy.types.Scene) -> None:
    """Modeled in centimetres, in a scene whose unit is a metre."""
    bpy.ops.mesh.primitive_uv_sphere_add(radius=12.5)
    said = set_tissue(scene, bpy.context.object, 0.0, 0.0, "skin")
    (found,) = size_problems(read(scene).tissue.points)
    assert (found.code, found.value) == (ProblemCode.TISSUE_LARGE, "25000")
    assert said == problem_sentence(found)
