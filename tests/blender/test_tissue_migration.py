"""Files of earlier and later versions."""

from __future__ import annotations

from pathlib import Path

import bpy
import pytest

from lappet_blender.model import migrate
from lappet_blender.model.procedure_properties import VERSION
from tissue_scenes import fill_with_patch, read


def test_a_file_without_a_version_is_brought_up_to_this_one_when_it_is_loaded(
    scene: bpy.types.Scene, blend: Path
) -> None:
    given = fill_with_patch(scene)
    scene.lappet.version = 0
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    assert bpy.context.scene.lappet.version == VERSION
    assert read(bpy.context.scene) == given


def test_versions_are_passed_one_at_a_time_in_order(scene: bpy.types.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    fill_with_patch(scene)
    passed = []
    monkeypatch.setattr(migrate, "VERSION", 4)
    steps = {k: lambda each, k=k: passed.append((k, each.lappet.version)) for k in (0, 1, 3)}
    monkeypatch.setattr(migrate, "STEPS", steps)
    scene.lappet.version = 1
    assert migrate.migrate(scene)
    assert passed == [(1, 1), (3, 3)]
    assert scene.lappet.version == 4
    assert not migrate.migrate(scene)


def test_an_untouched_scene_and_one_of_a_newer_version_are_left_alone(scene: bpy.types.Scene) -> None:
    assert not migrate.migrate(scene)
    assert scene.lappet.version == 0
    fill_with_patch(scene)
    scene.lappet.version = VERSION + 6
    assert not migrate.migrate(scene)
    assert scene.lappet.version == VERSION + 6
    assert migrate.from_newer_version(scene)
