"""The panels draw in every state of a scene, with properties, operators and arguments that exist."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import bpy
import pytest

from lappet.tissue.presets import PRESETS
from lappet_blender.model.scene_procedure import read_scene
from lappet_blender.tissue.material_panel import LAPPET_MT_presets, LAPPET_PT_materials
from lappet_blender.tissue.tissue_check import check_tissue
from lappet_blender.tissue.tissue_panel import (
    LAPPET_PT_tissue,
    LAPPET_PT_tissue_faces,
    LAPPET_PT_tissue_skin_lines,
    LAPPET_PT_tissue_surroundings,
    LAPPET_PT_tissue_vessels,
)
from tissue_scenes import add_box, add_sheet, fill_with_patch


class Button:
    """An operator in a panel: takes the arguments that the operator has and no others."""

    def __init__(self, name: str, text: str) -> None:
        part, operator = name.split(".")
        self.__dict__.update(name=name, text=text, given={})
        self.__dict__["known"] = {
            each.identifier for each in getattr(getattr(bpy.ops, part), operator).get_rna_type().properties
        }

    def __setattr__(self, name: str, value: object) -> None:
        assert name in self.known, f"{self.name} has no argument {name}"
        self.given[name] = value


class Layout:
    """A layout that writes down what is drawn and refuses what does not exist."""

    operator_context = "INVOKE_DEFAULT"  # Blender sets it between what a panel and what is hung into it draws

    def __init__(self, drawn: list[Any]) -> None:
        self.__dict__["drawn"] = drawn

    def __setattr__(self, name: str, value: object) -> None:
        assert name in bpy.types.UILayout.bl_rna.properties, name

    def _part(self, *_: object, **__: object) -> Layout:
        return Layout(self.drawn)

    row = column = box = split = _part

    def separator(self) -> None:
        pass

    def label(self, text: str = "", icon: str = "NONE") -> None:
        self.drawn.append(text)

    def prop(self, owner: Any, name: str, **_: object) -> None:
        assert name in owner.bl_rna.properties, name
        self.drawn.append(name)

    def prop_search(self, owner: Any, name: str, where: Any, listed: str, **_: object) -> None:
        self.prop(owner, name)
        assert listed in where.bl_rna.properties

    def operator(self, name: str, text: str | None = None, icon: str = "NONE") -> Button:
        assert icon in bpy.types.UILayout.bl_rna.functions["operator"].parameters["icon"].enum_items
        button = Button(name, text or "")
        self.drawn.append(button)
        return button

    def operator_menu_enum(self, name: str, choice: str, **_: object) -> None:
        assert choice in Button(name, "").known

    def menu(self, name: str, **_: object) -> None:
        assert hasattr(bpy.types, name)

    def template_list(self, *_: object, **__: object) -> None:
        self.drawn.append("list")


def draw(panel: type, scene: bpy.types.Scene) -> list[Any]:
    """What a panel draws."""
    drawn: list[Any] = []
    blender = bpy.context
    context = SimpleNamespace(
        scene=scene, region=None, preferences=None, view_layer=blender.view_layer, workspace=blender.workspace
    )
    panel.draw(SimpleNamespace(layout=Layout(drawn)), context)
    return drawn


def buttons(drawn: list[Any]) -> list[str]:
    """The operators among what was drawn."""
    return [each.name for each in drawn if isinstance(each, Button)]


def said(drawn: list[Any]) -> str:
    """The labels among what was drawn, in one line."""
    return " ".join(each for each in drawn if isinstance(each, str))


@pytest.mark.parametrize("has_template", [False, True])
def test_a_scene_without_tissue_offers_to_make_some_and_the_template_until_it_is_there(
    scene: bpy.types.Scene, monkeypatch: pytest.MonkeyPatch, has_template: bool
) -> None:
    monkeypatch.setattr("lappet_blender.start.template_offer.is_written", lambda: has_template)
    offers = ["lappet.tissue_set", *2 * ["lappet.tissue_take_field"], *["lappet.template_install"] * (not has_template)]
    assert buttons(draw(LAPPET_PT_tissue, scene)) == offers
    add_box(scene)
    button, *_ = draw(LAPPET_PT_tissue, scene)
    assert button.text == "Make block the Tissue"
    draw(LAPPET_PT_materials, scene)


def test_the_panel_shows_groups_with_their_counts_cells_and_time(scene: bpy.types.Scene) -> None:
    fill_with_patch(scene)
    drawn = [*draw(LAPPET_PT_tissue, scene), *draw(LAPPET_PT_tissue_faces, scene)]
    assert "fixed: 72" in drawn
    assert "bed: 80" in drawn
    assert "cells; 10 frames: about" in said(drawn)
    assigned = [each.given for each in drawn if isinstance(each, Button) and each.name == "lappet.faces_assign"]
    assert {"group": "bed", "action": "REMOVE"} in assigned


def test_vessels_are_listed_and_can_be_removed(scene: bpy.types.Scene) -> None:
    fill_with_patch(scene)
    assert buttons(draw(LAPPET_PT_tissue_vessels, scene)) == ["lappet.vessels_add"]
    for name in ("angular", "infraorbital"):
        scene.lappet.vessels.add().name = name
    drawn = draw(LAPPET_PT_tissue_vessels, scene)
    removes = [each.given for each in drawn if isinstance(each, Button) and each.name == "lappet.vessel_remove"]
    assert removes == [{"name": "angular"}, {"name": "infraorbital"}]


def test_skin_lines_are_listed_with_their_tension_and_can_be_removed(scene: bpy.types.Scene) -> None:
    fill_with_patch(scene)
    assert buttons(draw(LAPPET_PT_tissue_skin_lines, scene)) == ["lappet.skin_lines_add"]
    for name in ("crease", "fold"):
        scene.lappet.skin_lines.add().name = name
    scene.lappet.skin_lines["fold"].use_tension = True
    drawn = draw(LAPPET_PT_tissue_skin_lines, scene)
    assert drawn.count("use_tension") == 2
    assert drawn.count("tension") == 1
    removes = [each.given for each in drawn if isinstance(each, Button) and each.name == "lappet.skin_line_remove"]
    assert removes == [{"name": "crease"}, {"name": "fold"}]


def test_a_problem_is_said_with_the_button_that_mends_it(scene: bpy.types.Scene) -> None:
    scene.lappet.tissue.object = add_sheet(scene)
    drawn = draw(LAPPET_PT_tissue, scene)
    assert read_scene(scene).problems[0].message in said(drawn)
    (remedy,) = [each for each in drawn if isinstance(each, Button) and each.name == "lappet.tissue_repair"]
    assert remedy.given == {"kind": "HOLES"}
    assert remedy.text == "Fill Small Holes"


@pytest.mark.parametrize("kind", ["scale", "modifier", "light", "deleted", "bone", "edit"])
def test_the_panel_draws_in_every_state(scene: bpy.types.Scene, kind: str) -> None:
    fill_with_patch(scene)
    obj = scene.lappet.tissue.object
    if kind == "scale":
        obj.scale.x *= 2.0
    elif kind == "modifier":
        obj.modifiers.new("Wave", "WAVE")
    elif kind == "light":
        scene.lappet.tissue.object = bpy.data.objects.new("lamp", bpy.data.lights.new("lamp", "POINT"))
    elif kind == "deleted":
        scene.collection.objects.unlink(obj)
    elif kind == "bone":
        add_box(scene)
        bpy.ops.lappet.bone_add()
    else:
        bpy.ops.object.mode_set(mode="EDIT")
    assert draw(LAPPET_PT_tissue, scene)
    for part in (LAPPET_PT_tissue_faces, LAPPET_PT_tissue_surroundings):
        assert part.poll(SimpleNamespace(scene=scene)) == (kind != "light")
        if kind != "light":
            assert draw(part, scene)


def test_what_a_check_found_is_listed_with_its_places(scene: bpy.types.Scene) -> None:
    fill_with_patch(scene)
    scene.lappet.tissue.object.data.flip_normals()
    bpy.ops.lappet.tissue_check()
    drawn = draw(LAPPET_PT_tissue, scene)
    assert check_tissue(scene).places[0].problem.message in said(drawn)
    bpy.ops.lappet.tissue_repair(kind="ORIENT")
    bpy.ops.lappet.tissue_check()
    assert "No problems found." in draw(LAPPET_PT_tissue, scene)


def test_materials_show_what_they_have_and_where_a_presets_numbers_come_from(scene: bpy.types.Scene) -> None:
    fill_with_patch(scene)
    bpy.ops.lappet.material_add(preset="FAT")
    bpy.ops.lappet.region_add(group="bed", material="fat", depth_from=1.0, depth_to=2.0)
    drawn = draw(LAPPET_PT_materials, scene)
    assert "Sims et al. 2010" in said(drawn)
    assert "fiber_k2" not in drawn
    assert "depth_to" in drawn
    scene.lappet.materials[1].fiber_k1 = 10.0
    scene.lappet.materials[1].muscle_stress = 10.0
    drawn = draw(LAPPET_PT_materials, scene)
    assert "fiber_k2" in drawn
    assert "activation" in drawn
    menu = draw(LAPPET_MT_presets, scene)
    assert [each.given for each in menu] == [{"name": "fat", "preset": name.upper()} for name in PRESETS]
