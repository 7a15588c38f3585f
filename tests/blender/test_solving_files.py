"""Solving across files, folders and the add-on's own life: saving, loading, older versions, another folder, ending."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import bpy
import pytest

import lappet_blender
from fake_worker import Script
from lappet.background.assessment import Assessment
from lappet.core.problem_code import ProblemCode
from lappet_blender.model.event_list import add_event, find_event
from lappet_blender.model.procedure_properties import VERSION
from lappet_blender.solving import controller, frames, opened_files, scene_watch, solve_settings, workers
from lappet_blender.solving.solve_timer import run_timer
from solving_steps import QUIET, solve, states

pytest_plugins = ("solving_fixtures",)


def clear_memory() -> None:
    """As a Blender that has just been started."""
    controller.frame_cache.clear()
    controller.manifests.clear()


def test_a_saved_file_shows_its_frames_when_it_is_opened_without_a_worker(
    patch: bpy.types.Scene, script: Script, blend: Path
) -> None:
    solve(patch)
    height = frames.shown_at(patch, 8).frame.points[0, 2]
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    bpy.ops.wm.read_homefile(use_empty=True)
    clear_memory()
    asked = list(script.asked)
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    scene = bpy.context.scene
    assert states(scene) == "ssssssss", "no timer has run yet"
    shown = frames.shown_at(scene, 8)
    assert not shown.stale
    assert shown.frame.points[0, 2] == height
    run_timer(QUIET)
    assert script.asked == asked


def test_a_file_that_asks_for_it_is_solved_when_it_is_opened_and_only_once(
    patch: bpy.types.Scene, script: Script, blend: Path
) -> None:
    assert opened_files.wanting(bpy.data.scenes) == []
    patch.lappet.solving.when_opened = True
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    (scene,) = opened_files.wanting(bpy.data.scenes)
    assert opened_files.begin(scene)
    assert frames.progress_of(scene).running
    run_timer(QUIET)
    assert states(scene) == "ssssssss"
    assert opened_files.begin(scene), "its frames are there, but not how far they may be off"
    script.assessment = Assessment()
    run_timer(QUIET)
    bpy.ops.lappet.solve(wait=True)
    assert not opened_files.begin(scene)
    scene.lappet.tissue.object = None
    assert opened_files.wanting(bpy.data.scenes) == []


def test_a_file_that_was_saved_with_stale_frames_shows_them_as_stale(
    patch: bpy.types.Scene, script: Script, blend: Path
) -> None:
    solve(patch)
    find_event(patch, "hook_1").stiffness = 30.0
    script.held = True
    run_timer(0.5)
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    bpy.ops.wm.read_homefile(use_empty=True)
    clear_memory()
    script.held = False
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    scene = bpy.context.scene
    assert frames.shown_at(scene, 8).stale
    run_timer(QUIET)
    assert states(scene) == "sssttttt"


def test_loading_another_file_cancels_the_jobs_of_this_one_and_its_worker_serves_the_next(
    patch: bpy.types.Scene, script: Script, blend: Path
) -> None:
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    bpy.ops.lappet.solve()
    run_timer()
    (worker,) = script.workers
    bpy.ops.wm.read_homefile(use_empty=True)
    assert worker.cancelled
    run_timer(0.3)
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    run_timer(QUIET)
    assert states(bpy.context.scene).count("s") <= 2
    solve(bpy.context.scene)
    assert script.workers == [worker]


def test_a_file_without_the_mark_of_a_version_is_brought_up_to_this_one(
    patch: bpy.types.Scene, script: Script, blend: Path
) -> None:
    solve(patch)
    patch.lappet.version = 0
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    scene = bpy.context.scene
    assert scene.lappet.version == VERSION
    assert states(scene) == "ssssssss"
    assert frames.problems_of(scene) == ()


def test_a_file_of_a_newer_version_opens_with_a_warning_and_still_solves(
    patch: bpy.types.Scene, script: Script, blend: Path
) -> None:
    patch.lappet.version = VERSION + 1
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    scene = bpy.context.scene
    (problem,) = frames.problems_of(scene)
    assert problem.severity == "warning"
    assert problem.code is ProblemCode.SCENE_NEWER
    solve(scene)


def test_frames_can_be_kept_beside_the_file_and_those_solved_before_go_with_it(
    patch: bpy.types.Scene, script: Script, blend: Path, own_store: Path
) -> None:
    solve(patch)
    patch.lappet.solving.beside_file = True
    run_timer(QUIET)
    assert solve_settings.frame_folder(patch) == own_store, "a file that was never saved has no folder"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    run_timer(QUIET)
    beside = blend.parent / "lappet_frames"
    assert solve_settings.frame_folder(patch) == beside
    assert states(patch) == "ssssssss"
    clear_memory()
    keys = [frame.key for frame in frames.manifest_of(patch).frames]
    store = controller.controller_of(patch).store
    assert store.folder == beside
    assert all(key in store for key in keys)
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    assert states(bpy.context.scene) == "ssssssss"
    add_event(bpy.context.scene, "SUTURE", start=5, points=[(2, -1, 2), (2, 1, 2)])
    solve(bpy.context.scene)
    assert script.workers[-1].store.folder == beside


def test_a_folder_that_cannot_be_made_is_a_sentence_and_the_frames_stay_where_they_were(
    patch: bpy.types.Scene, script: Script, blend: Path
) -> None:
    solve(patch)
    (blend.parent / "lappet_frames").write_text("a file is in the way")
    patch.lappet.solving.beside_file = True
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    run_timer(QUIET)
    (trouble,) = frames.problems_of(patch)
    assert trouble.message.startswith("Solved frames cannot be kept in ")
    assert states(patch) == "ssssssss", "they are still in memory"
    clear_memory()
    bpy.ops.lappet.reload_frames()
    run_timer(QUIET)
    patch.lappet.solving.beside_file = False
    run_timer(QUIET)
    assert states(patch) == "ssssssss"


def test_unregistering_closes_the_workers_and_registering_again_goes_on(patch: bpy.types.Scene, script: Script) -> None:
    bpy.ops.lappet.solve()
    run_timer()
    (worker,) = script.workers
    lappet_blender.unregister()
    assert worker.closed
    assert not hasattr(bpy.types.Scene, "lappet")
    lappet_blender.register()
    run_timer(QUIET)
    solve(patch)
    assert script.workers[-1] is not worker


def test_the_folders_for_the_workers_path_hold_what_it_imports() -> None:
    folders = [Path(folder) for folder in workers.import_folders()]
    for name in ("lappet", "numpy", "zmq", "msgpack", "platformdirs"):
        assert any((folder / name).is_dir() for folder in folders), name
    assert any(list(folder.glob("manifold3d*")) for folder in folders)
    assert len(set(folders)) == len(folders)


def test_an_opened_file_whose_tissue_is_still_made_is_read_by_the_timer(
    patch: bpy.types.Scene, script: Script, blend: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    solve(patch)
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    monkeypatch.setattr(scene_watch, "_waits", lambda _scene: True)  # as in a window, with a large tissue
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    scene = bpy.context.scene
    assert controller.controller_of(scene).procedure is None, "Blender answers before the tissue is there"
    run_timer(QUIET)
    assert states(scene) == "ssssssss"
    add_event(scene, "SUTURE", start=5, points=[(2, -1, 2), (2, 1, 2)])
    bpy.ops.ed.undo_push(message="sewn")
    run_timer(QUIET)
    assert "t" in states(scene)


def test_a_file_that_is_opened_while_another_is_solved_puts_the_status_bar_off(
    patch: bpy.types.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Else Blender crashes where a timer opens it: the next one would write to the bar of a workspace that is freed."""
    calls: list[str] = []
    timers = SimpleNamespace(
        is_registered=lambda step: calls[-1:] != ["off"],
        unregister=lambda step: calls.append("off"),
        register=lambda step, first_interval, persistent: calls.append(f"on in {first_interval:g} s"),
    )
    app = SimpleNamespace(background=False, timers=timers)
    monkeypatch.setattr(opened_files, "bpy", SimpleNamespace(app=app, data=bpy.data))
    assert opened_files.wanting(bpy.data.scenes) == []
    opened_files._loaded()
    assert calls == ["off", "on in 0.5 s"]
