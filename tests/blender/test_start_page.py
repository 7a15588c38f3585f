"""Start without a blank page: the template's files and scene, the asset library, and presets of one's own."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import bpy
import numpy as np
import pytest
from bpy_extras.object_utils import world_to_camera_view

from event_patch import co, patch_scene
from lappet.checks.validation import check
from lappet.core.problem_code import ProblemCode
from lappet.tissue.presets import PRESETS as PRESETS_OF_TISSUE
from lappet_blender.events.flap_assets import size_of, suit_unit
from lappet_blender.model.scene_procedure import read_scene
from lappet_blender.start import asset_home, asset_items, asset_library, asset_operators, own_presets, template_files
from lappet_blender.start import registration as start
from lappet_blender.start.asset_library import TAG
from lappet_blender.start.first_scene import fill_first_scene
from lappet_blender.start.template_offer import draw_offer
from refusals import refusal_code

ops = bpy.ops.lappet
TOP = 4.0


@pytest.fixture
def scripts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The user's scripts folder, an empty one, whose presets leave no name behind."""

    def user_resource(_kind: str, *, path: str = "", create: bool = False) -> str:
        folder = tmp_path / "scripts" / path
        if create:
            folder.mkdir(parents=True, exist_ok=True)
        return str(folder)

    monkeypatch.setattr(bpy.utils, "user_resource", user_resource)
    yield tmp_path / "scripts"
    own_presets.unregister()


def test_the_template_is_written_where_blender_looks_and_taken_away_again(addon: None, scripts: Path) -> None:
    assert not template_files.is_written()
    assert ops.template_install() == {"FINISHED"}
    folder = scripts / "startup" / "bl_app_templates_user" / "Lappet"
    assert [each.name for each in folder.iterdir()] == ["__init__.py"]
    assert ops.template_install() == {"FINISHED"}  # anew, over the old one
    assert ops.template_remove() == {"FINISHED"}
    assert not folder.exists()


def test_the_template_adds_its_handler_and_takes_it_off(addon: None, scripts: Path) -> None:
    source = template_files.write_template("lappet_blender") / "__init__.py"
    spec = importlib.util.spec_from_file_location("template_of_lappet", source)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    handlers = bpy.app.handlers.load_factory_startup_post
    before = len(handlers)
    module.register()
    assert len(handlers) == before + 1
    module.unregister()
    assert len(handlers) == before


def test_the_first_scene_is_an_operation_without_a_problem_seen_whole_by_its_camera(scene: bpy.types.Scene) -> None:
    bpy.ops.mesh.primitive_cube_add()
    fill_first_scene(scene)
    assert "Cube" not in bpy.data.objects
    reading = read_scene(scene)
    assert reading.procedure is not None
    assert [each for each in check(reading.procedure) if each.severity == "error"] == []
    assert {event.kind for event in scene.lappet.events} >= {"INCISION", "HOOK"}
    assert scene.unit_settings.scale_length == pytest.approx(0.001)
    assert any(obj.type == "LIGHT" for obj in scene.objects)
    bpy.context.view_layer.update()
    tissue = scene.lappet.tissue.object
    places = [world_to_camera_view(scene, scene.camera, tissue.matrix_world @ v.co) for v in tissue.data.vertices]
    seen = np.array([tuple(each) for each in places])
    assert seen[:, :2].min() > 0.0
    assert seen[:, :2].max() < 1.0
    assert seen[:, 2].min() > scene.camera.data.clip_start
    across = np.ptp(seen[:, 0])
    assert across > 0.4  # and not far away
    names = [marker.name for marker in sorted(scene.timeline_markers, key=lambda each: each.frame)]
    assert names == [
        "Planned incisions",
        "Incised and undermined",
        "Raised with hooks",
        "Closed with sutures",
        "Result",
    ]


@pytest.fixture
def library(scene: bpy.types.Scene, tmp_path: Path) -> Iterator[Path]:
    """The library in a folder, registered."""
    scene.unit_settings.scale_length = 0.001
    assert ops.assets_install(directory=str(tmp_path)) == {"FINISHED"}
    yield tmp_path
    asset_library.unregister_library(bpy.context.preferences)


def test_the_library_holds_every_kind_in_its_catalog_and_names_itself_in_the_preferences(library: Path) -> None:
    known = bpy.context.preferences.filepaths.asset_libraries["Lappet"]
    assert Path(known.path) == library
    lines = (library / "blender_assets.cats.txt").read_text(encoding="utf-8").splitlines()
    catalogs = {line.split(":")[0]: line.split(":")[1] for line in lines if line.count(":") == 2}
    assert set(catalogs.values()) == {"Lappet", "Lappet/Flaps", *asset_items.CATALOGS.values()}
    with bpy.data.libraries.load(str(library / "lappet.blend"), assets_only=True) as (there, into):
        into.objects = list(there.objects)
    items = {item.tag: item for item in asset_items.asset_items()}
    assert {obj[TAG] for obj in into.objects} == set(items)
    assert {item.kind for item in items.values()} == set(asset_items.KINDS)
    for obj in into.objects:
        assert catalogs[obj.asset_data.catalog_id] == asset_items.CATALOGS[items[obj[TAG]].kind]
        assert obj.asset_data.description
    assert (library / "flaps.blend").is_file()
    assert not [obj for obj in bpy.context.scene.objects if TAG in obj]


def test_writing_the_library_twice_leaves_one_entry_and_removing_takes_it_out(library: Path) -> None:
    ops.assets_install(directory=str(library))
    libraries = bpy.context.preferences.filepaths.asset_libraries
    assert [each.name for each in libraries].count("Lappet") == 1
    assert ops.assets_remove() == {"FINISHED"}
    assert "Lappet" not in libraries


def libraries_of(preferences: bpy.types.Preferences) -> list[tuple[str, str]]:
    """The asset libraries that the preferences name."""
    return [(each.name, each.path) for each in preferences.filepaths.asset_libraries]


def test_the_library_names_itself_and_leaves_the_preferences_as_they_were(addon: None, tmp_path: Path) -> None:
    preferences = bpy.context.preferences
    before, preferences.is_dirty = libraries_of(preferences), False
    assert asset_home.name_library(preferences, tmp_path)
    assert not asset_home.name_library(preferences, tmp_path)  # once
    assert libraries_of(preferences) == [*before, ("Lappet", str(tmp_path))]
    assert asset_home.forget_library(preferences, tmp_path)
    assert libraries_of(preferences) == before
    assert not preferences.is_dirty


def test_a_library_that_the_user_keeps_elsewhere_is_neither_moved_nor_taken_out(library: Path, tmp_path: Path) -> None:
    preferences, before = bpy.context.preferences, libraries_of(bpy.context.preferences)
    assert not asset_home.name_library(preferences, tmp_path / "own")
    assert not asset_home.forget_library(preferences, tmp_path / "own")
    assert libraries_of(preferences) == before


def test_a_library_is_written_again_only_by_another_version(library: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert asset_home.is_current(library)
    monkeypatch.setattr(asset_home, "version", lambda: "of tomorrow")
    assert not asset_home.is_current(library)
    (library / "lappet.blend").unlink()
    monkeypatch.undo()
    assert not asset_home.is_current(library)


def test_scripts_without_a_window_write_no_library_and_name_none(addon: None) -> None:
    assert bpy.app.background
    assert not bpy.app.timers.is_registered(asset_home._offer)
    assert "Lappet" not in bpy.context.preferences.filepaths.asset_libraries


def test_a_plan_that_is_dropped_into_a_scene_in_meters_is_as_large_as_in_one_in_mm(library: Path) -> None:
    scene = bpy.context.scene
    with bpy.data.libraries.load(str(library / "flaps.blend"), assets_only=True) as (_, into):
        into.objects = ["Limberg flap"]
    (plan,) = into.objects
    scene.collection.objects.link(plan)
    assert not suit_unit(scene, plan)
    scene.unit_settings.scale_length = 1.0
    assert suit_unit(scene, plan)
    bpy.context.view_layer.update()
    assert size_of(scene, plan) == pytest.approx(1.0)
    assert max(plan.dimensions) < 0.2


def test_the_empty_panel_offers_the_template_until_it_is_there(scene: bpy.types.Scene, scripts: Path) -> None:
    drawn: list[str] = []
    layout = SimpleNamespace(separator=lambda: None, operator=lambda name, **_: drawn.append(name))
    draw_offer(SimpleNamespace(layout=layout), bpy.context)
    assert drawn == ["lappet.template_install"]
    ops.template_install()
    draw_offer(SimpleNamespace(layout=layout), bpy.context)
    assert len(drawn) == 1


def test_the_picture_of_a_material_is_its_curve(addon: None) -> None:
    stress = asset_items._stress
    fat, skin = PRESETS_OF_TISSUE["fat"].material, PRESETS_OF_TISSUE["skin"].material
    assert stress(skin, 1.0) == pytest.approx(0.0, abs=1e-6)
    step = 1e-4
    assert (stress(fat, 1.0 + step) - stress(fat, 1.0)) / step == pytest.approx(fat.youngs_modulus, rel=0.02)
    assert stress(skin, 1.3) > 10.0 * stress(fat, 1.3)


def test_pictures_differ_from_asset_to_asset_but_for_models_of_bodies(addon: None) -> None:
    items = asset_items.asset_items()
    pictures = {item.tag: asset_items.picture(item) for item in items}
    for shown in pictures.values():
        assert shown.shape == (asset_items.SIZE, asset_items.SIZE, 4)
        assert shown.min() >= 0.0
        assert shown.max() <= 1.0
        assert np.ptp(shown[..., 0]) > 0.2
    threads = [pictures[item.tag].tobytes() for item in items if item.kind == "thread"]
    assert len(set(threads)) == len(threads)


def dropped(tag: str, at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> bpy.types.Object:
    """An object as Blender appends it."""
    obj = bpy.data.objects.new("asset", None)
    obj[TAG] = tag
    obj.location = at
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.update()
    return obj


@pytest.fixture
def patch(scene: bpy.types.Scene) -> bpy.types.Scene:
    """A patch of 60 x 40 x 4 mm, a suture on it."""
    patch_scene(scene, (60.0, 40.0, TOP), 40)
    ops.suture_add(first=(3, 1, TOP), second=(3, -1, TOP), start=21, duration=3)
    return scene


def test_a_model_that_is_dropped_becomes_the_tissue(scene: bpy.types.Scene) -> None:
    dropped("model:patch")
    assert ops.asset_take_up(object="asset") == {"FINISHED"}
    assert scene.lappet.tissue.object is not None
    assert "asset" not in bpy.data.objects


def test_a_material_a_thread_and_a_plate_that_are_dropped_are_used(patch: bpy.types.Scene) -> None:
    name = next(item.name for item in asset_items.asset_items() if item.kind == "material")
    dropped(f"material:{name}")
    ops.asset_take_up(object="asset")
    assert patch.lappet.tissue.material == patch.lappet.materials[patch.lappet.active_material].name
    patch.lappet.active_event = 0
    dropped("thread:silk 3-0")
    ops.asset_take_up(object="asset")
    event = patch.lappet.events[0]
    assert (event.mode, event.thread) == ("THREAD", "SILK_3_0")
    dropped("plate:atlas")
    ops.asset_take_up(object="asset")
    assert len(patch.lappet.pages) == 1


@pytest.mark.parametrize("preset", PRESETS_OF_TISSUE)
def test_a_material_that_is_there_already_is_used_and_one_that_was_changed_is_not(
    patch: bpy.types.Scene, preset: str
) -> None:
    ops.material_add(preset="SKIN", name="another")
    for _ in range(2):
        dropped(f"material:{preset}")
        ops.asset_take_up(object="asset")
    names = [each.name for each in patch.lappet.materials]
    used = patch.lappet.tissue.material
    assert not [name for name in names if name.endswith("_2")]
    assert patch.lappet.materials[patch.lappet.active_material].name == used
    patch.lappet.materials[used].youngs_modulus *= 2.0
    dropped(f"material:{preset}")
    ops.asset_take_up(object="asset")
    assert patch.lappet.tissue.material != used


def test_a_hook_and_a_landmark_are_set_where_they_are_dropped(patch: bpy.types.Scene) -> None:
    dropped("instrument:hook", (5.0, -3.0, TOP + 1.0))
    ops.asset_take_up(object="asset")
    hook = patch.lappet.events["hook_1"]
    assert tuple(hook.points[0].co) == pytest.approx((5.0, -3.0, TOP), abs=1e-3)
    dropped("instrument:landmark", (-7.0, 2.0, TOP + 2.0))
    ops.asset_take_up(object="asset")
    assert tuple(patch.lappet.events[-1].points[0].co) == pytest.approx((-7.0, 2.0, TOP), abs=1e-3)


def test_what_cannot_be_taken_up_is_refused_and_goes_after_a_drop(patch: bpy.types.Scene) -> None:
    dropped("model:patch")
    assert refusal_code(lambda: ops.asset_take_up(object="asset")) is ProblemCode.MODEL_SCENE_TAKEN
    assert "asset" in bpy.data.objects
    asset_operators.take_up_dropped()  # what Blender calls after a drop
    assert "asset" not in bpy.data.objects
    ops.landmark_add(point=(5, 5, TOP), label="here")
    dropped("thread:silk 3-0")
    assert refusal_code(lambda: ops.asset_take_up(object="asset")) is ProblemCode.ASSET_NO_SUTURE
    ops.incision_add(points=co([(-10, 0, TOP), (10, 0, TOP)]), time=3)
    assert refusal_code(lambda: ops.asset_take_up(object="patch")) is ProblemCode.ASSET_UNKNOWN
    assert "patch" in bpy.data.objects


PRESETS = {
    "skin": (own_presets._SKIN, lambda data: data.materials[data.active_material]),
    "thread": (own_presets._THREAD, lambda data: data.events[data.active_event]),
    "plate": (own_presets._PLATE, lambda data: data.pages[data.active_page]),
    "look": (own_presets._LOOK, lambda data: data.look),
}


def other(owner: Any, field: str) -> Any:
    """Another value of a property."""
    info, value = owner.bl_rna.properties[field], getattr(owner, field)
    if info.type == "BOOLEAN":
        return not value
    if info.type == "ENUM":
        return next(each.identifier for each in info.enum_items if each.identifier != value)
    if info.type == "STRING":
        return "de"
    if getattr(info, "is_array", False):
        return tuple(0.9 * each + 0.05 for each in value)
    changed = value * 0.9 + 0.05
    return round(changed) + 1 if info.type == "INT" else min(max(changed, info.hard_min), info.hard_max)


@pytest.mark.parametrize("kind", PRESETS)
def test_a_preset_of_ones_own_brings_every_value_back(patch: bpy.types.Scene, scripts: Path, kind: str) -> None:
    ops.plate_add(template="steps")
    patch.lappet.active_event = 0
    fields, owner_of = PRESETS[kind]
    owner = owner_of(patch.lappet)
    kept = {}
    for field in fields:
        setattr(owner, field, other(owner, field))
    for field in fields:
        value = getattr(owner, field)
        kept[field] = value if isinstance(value, str | bool | int | float) else tuple(value)
    assert getattr(ops, f"{kind}_preset_add")(name="My Own") == {"FINISHED"}
    file = scripts / "presets" / "lappet" / kind / "My_Own.py"
    assert file.is_file() or list(file.parent.glob("*.py"))
    for field in fields:
        setattr(owner, field, other(owner, field))
    made = next(iter(file.parent.glob("*.py")))
    bpy.ops.script.execute_preset(filepath=str(made), menu_idname=f"LAPPET_PT_{kind}_presets")
    for field, value in kept.items():
        found = getattr(owner, field)
        assert (found if isinstance(found, str | bool | int) else pytest.approx(value, rel=1e-6)) == value


def test_a_list_of_presets_has_its_name_again_once_the_add_on_is_off(patch: bpy.types.Scene, scripts: Path) -> None:
    before = own_presets.LAPPET_PT_look_presets.bl_label
    ops.look_preset_add(name="My Own")
    assert own_presets.LAPPET_PT_look_presets.bl_label == "My Own"  # Blender's way to say which one is chosen
    start.unregister()
    start.register()
    assert own_presets.LAPPET_PT_look_presets.bl_label == before
