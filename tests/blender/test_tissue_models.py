"""Add > Lappet > Model: an anatomical model with what is around it, in a scene and in its file."""

from __future__ import annotations

from pathlib import Path

import bpy
import pytest

from lappet.core.problem_code import ProblemCode
from lappet.models import body_package
from lappet.models.model_choice import ModelChoice
from lappet.models.new_model import MODELS, new_model
from lappet.usd.stage import read_procedure
from lappet_blender.events.add_menu import VIEW3D_MT_lappet_add
from lappet_blender.model.scene_procedure import read_scene
from lappet_blender.model.scenery_values import PROPERTY
from lappet_blender.tissue.model_operators import VIEW3D_MT_lappet_model
from refusals import refusal_code

ops = bpy.ops.lappet


def test_a_model_is_the_same_in_the_scene_and_in_its_file(scene: bpy.types.Scene, tmp_path: Path) -> None:
    assert ops.model_add(model="hand", excision=True) == {"FINISHED"}
    wanted = new_model("hand", ModelChoice(excision=True))
    held = read_scene(scene).procedure
    assert held is not None
    assert held.tissue == wanted.tissue
    assert [each.name for each in held.materials] == [each.name for each in wanted.materials]
    assert [line.name for line in held.skin_lines] == [line.name for line in wanted.skin_lines]
    assert {event.name for event in held.events} == {event.name for event in wanted.events}
    assert ops.export_procedure(filepath=str(tmp_path / "hand.usdc")) == {"FINISHED"}
    assert read_procedure(tmp_path / "hand.usdc").scenery == wanted.scenery


def test_scenery_is_shown_and_cannot_be_picked(scene: bpy.types.Scene) -> None:
    ops.model_add(model="nose")
    around = [obj for obj in scene.objects if PROPERTY in obj]
    assert sorted(obj[PROPERTY] for obj in around) == [each.kind for each in _sorted("nose")]
    assert all(obj.hide_select and obj.visible_get() for obj in around)
    assert all(obj.data.materials[0] is not None for obj in around)


def _sorted(name: str) -> list:
    return sorted(new_model(name).scenery, key=lambda each: each.kind)


def test_age_and_sex_shape_the_model(scene: bpy.types.Scene) -> None:
    ops.model_add(model="hand", age=70.0, sex="MALE", scenery=False)
    tissue = read_scene(scene).procedure.tissue
    assert tissue != new_model("hand").tissue
    assert not [obj for obj in scene.objects if PROPERTY in obj]


def test_a_scene_with_a_procedure_is_left_as_it_is(scene: bpy.types.Scene) -> None:
    ops.model_add(model="patch")
    objects = set(scene.objects)
    assert refusal_code(lambda: ops.model_add(model="dome")) == ProblemCode.MODEL_SCENE_TAKEN
    assert set(scene.objects) == objects


def test_without_the_package_the_command_that_fetches_it_is_named(
    scene: bpy.types.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(body_package.FOLDER_VARIABLE, str(tmp_path))
    assert refusal_code(lambda: ops.model_add(model="nose")) == ProblemCode.MODELS_NOT_FETCHED
    assert len(scene.objects) == 0


def test_a_model_can_be_taken_back(scene: bpy.types.Scene) -> None:
    bpy.ops.ed.undo_push(message="empty")
    assert ops.model_add("EXEC_DEFAULT", True, model="patch") == {"FINISHED"}
    bpy.ops.ed.undo()
    assert bpy.context.scene.lappet.tissue.object is None


class _Layout:
    def __init__(self) -> None:
        self.said: list[str] = []

    def operator(self, name: str, text: str) -> object:
        self.said.append(f"{name} {text}")
        return type("Entry", (), {})()

    def menu(self, name: str) -> None:
        self.said.append(name)


def test_the_menu_add_has_every_model(addon: None) -> None:
    drawn = type("Drawn", (), {"layout": _Layout(), "_entry": VIEW3D_MT_lappet_model._entry})()
    VIEW3D_MT_lappet_model.draw(drawn, bpy.context)
    assert [line.split()[1].lower() for line in drawn.layout.said] == list(MODELS)
    top = type("Drawn", (), {"layout": _Layout()})()
    VIEW3D_MT_lappet_add.draw(top, bpy.context)
    assert "VIEW3D_MT_lappet_model" in top.layout.said
