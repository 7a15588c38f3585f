"""Frames as they are solved, go stale, fail and come back: with a worker of formulas that the test drives."""

from __future__ import annotations

import dataclasses
import math

import bpy
import numpy as np
import pytest

from fake_worker import Script
from lappet.core.problem import Problem
from lappet.core.problem_code import ProblemCode
from lappet.daemon.solved_frame import SolvedFrame
from lappet.procedure import Landmark
from lappet_blender.model import changes
from lappet_blender.model.event_list import add_event, find_event, remove_event
from lappet_blender.model.scene_procedure import read_scene
from lappet_blender.solving import controller, frames, workers
from lappet_blender.solving.first_change import first_change
from lappet_blender.solving.frames import FrameRun
from lappet_blender.solving.solve_timer import run_timer
from refusals import refusal_code
from solving_steps import QUIET, solve, states

pytest_plugins = ("solving_fixtures",)


def place(scene: bpy.types.Scene, time: int) -> float:
    """How high the shown skin lies."""
    return float(frames.shown_at(scene, time).frame.points[0, 2])


def test_a_scene_is_planned_by_itself_and_solved_by_the_button(patch: bpy.types.Scene, script: Script) -> None:
    run_timer(QUIET)
    assert script.asked == [("manifest", frames.manifest_of(patch).key)]
    assert states(patch) == "mmmmmmmm"
    shown = frames.shown_at(patch, 5)
    assert shown.frame is None
    assert not shown.stale
    assert shown.epoch is shown.manifest.epochs[1], "an unsolved frame shows its epoch at rest"
    assert bpy.ops.lappet.solve() == {"FINISHED"}
    assert frames.progress_of(patch).running
    assert not run_timer(QUIET)
    assert frames.frame_runs(patch) == (FrameRun("solved", 1, 8),)
    assert [place(patch, time) for time in range(1, 9)] == [time - 1.0 + 2.0 for time in range(1, 9)]
    assert not frames.progress_of(patch).running
    assert frames.progress_of(patch).line == "8 of 8 frames solved"


def test_frames_come_one_after_another_and_those_not_there_show_the_last_one_before(
    patch: bpy.types.Scene, script: Script
) -> None:
    bpy.ops.lappet.solve()
    seen = []
    while run_timer():
        seen.append((states(patch).count("s"), frames.progress_of(patch).done))
        if seen[-1][0] == 4:
            shown = frames.shown_at(patch, 7)
            assert (shown.time, shown.stale) == (4, True)
    assert sorted({solved for solved, _ in seen}) == list(range(9))
    assert all(solved == done for solved, done in seen)


def test_an_edit_makes_only_the_frames_from_there_on_stale_and_a_solve_redoes_only_those(
    patch: bpy.types.Scene, script: Script
) -> None:
    solve(patch)
    before = [place(patch, time) for time in range(1, 9)]
    script.held = True
    find_event(patch, "hook_1").stiffness = 50.0
    run_timer(0.5)
    assert frames.manifest_of(patch) is None, "the new manifest is not there yet"
    assert states(patch) == "sssttttt", "what an event does begins with it, and this is known at once"
    script.held = False
    run_timer(QUIET)
    assert frames.frame_runs(patch) == (FrameRun("solved", 1, 3), FrameRun("stale", 4, 8))
    assert [place(patch, time) for time in range(1, 9)] == before, "stale frames go on being shown"
    assert [frames.shown_at(patch, time).stale for time in range(1, 9)] == [False] * 3 + [True] * 5
    line = frames.progress_of(patch).line
    assert line.startswith("3 of 8 frames solved, 5 stale; about "), line
    bpy.ops.lappet.solve()
    job = controller.controller_of(patch).job
    run_timer(QUIET)
    assert (job.done, job.solved) == (8, 5)
    assert states(patch) == "ssssssss"


def test_undo_brings_the_old_frames_back_at_once_and_redo_the_stale_ones_without_asking_anybody(
    patch: bpy.types.Scene, script: Script
) -> None:
    bpy.ops.ed.undo_push(message="before")
    solve(patch)
    bpy.ops.ed.undo_push(message="solved")
    add_event(patch, "SUTURE", start=5, points=[(2, -1, 2), (2, 1, 2)])
    bpy.ops.ed.undo_push(message="suture")
    run_timer(QUIET)
    assert states(patch) == "sssstttt"
    asked = list(script.asked)
    script.held = True  # nobody would answer
    bpy.ops.ed.undo()
    scene = bpy.context.scene
    assert len(scene.lappet.events) == 2
    assert states(scene) == "ssssssss", "no timer has run yet"
    assert not any(frames.shown_at(scene, time).stale for time in range(1, 9))
    run_timer(0.6)
    assert script.asked == asked
    bpy.ops.ed.redo()
    scene = bpy.context.scene
    assert len(scene.lappet.events) == 3
    assert states(scene) == "sssstttt"
    run_timer(0.6)
    assert script.asked == asked
    assert frames.manifest_of(scene) is not None


def test_undo_finds_frames_that_are_no_longer_in_memory_in_the_store(patch: bpy.types.Scene, script: Script) -> None:
    bpy.ops.ed.undo_push(message="before")
    solve(patch)
    find_event(patch, "hook_1").start = 5.0
    bpy.ops.ed.undo_push(message="later")
    run_timer(QUIET)
    assert states(patch) == "sssttttt"
    controller.manifests.clear()
    controller.frame_cache.clear()
    asked = list(script.asked)
    bpy.ops.ed.undo()
    assert states(bpy.context.scene) == "ssssssss"
    assert place(bpy.context.scene, 8) == 9.0
    assert script.asked == asked


def test_a_failed_frame_says_why_and_the_panel_can_go_there(patch: bpy.types.Scene, script: Script) -> None:
    script.failing[6] = "The hook tears the skin; pull it less far."
    with pytest.raises(RuntimeError, match="Frame 6: The hook tears the skin"):
        bpy.ops.lappet.solve(wait=True)
    assert states(patch) == "sssssfmm"
    failed = frames.frame_problem(patch, 6)
    assert failed is not None
    assert "The hook tears the skin" in failed.message
    assert frames.frame_problem(patch, 5) is None
    shown = frames.shown_at(patch, 8)
    assert (shown.time, shown.stale) == (5, True)
    assert bpy.ops.lappet.failure_show() == {"FINISHED"}
    assert patch.frame_current == 6
    script.failing.clear()
    solve(patch)
    assert frames.frame_problem(patch, 6) is None


def test_cancel_keeps_what_is_solved(patch: bpy.types.Scene, script: Script) -> None:
    bpy.ops.lappet.solve()
    while states(patch).count("s") < 3:
        run_timer()
    assert bpy.ops.lappet.solve_cancel() == {"FINISHED"}
    assert "kept" in frames.progress_of(patch).line
    assert not run_timer(QUIET)
    assert states(patch) == "sssmmmmm"
    assert not bpy.ops.lappet.solve_cancel.poll()
    solve(patch)


def test_a_solve_may_end_before_the_last_frame(patch: bpy.types.Scene, script: Script) -> None:
    assert bpy.ops.lappet.solve(wait=True, until=4) == {"FINISHED"}
    assert states(patch) == "ssssmmmm"
    assert refusal_code(lambda: bpy.ops.lappet.solve(wait=True, until=9)) is ProblemCode.SOLVE_UNTIL


def test_what_the_solver_refuses_is_shown_and_a_click_selects_the_event(patch: bpy.types.Scene, script: Script) -> None:
    script.refusal = (
        Problem(
            ProblemCode.EVENT_OFF_TISSUE,
            "/Procedure/Timeline/hook_1",
            "9 mm",
            "The anchor is 9 mm off the skin.",
            "Move it onto the skin.",
        ),
    )
    run_timer(QUIET)
    assert frames.problems_of(patch) == script.refusal
    with pytest.raises(RuntimeError, match=r"hook_1: The anchor is 9 mm off the skin\. Move it onto the skin\."):
        bpy.ops.lappet.solve(wait=True)
    patch.lappet.active_event = 0
    assert bpy.ops.lappet.problem_show(index=0) == {"FINISHED"}
    assert patch.lappet.events[patch.lappet.active_event].name == "hook_1"
    assert patch.frame_current == 4
    assert refusal_code(lambda: bpy.ops.lappet.problem_show(index=3)) is ProblemCode.PROBLEM_UNKNOWN
    asked = len(script.asked)
    find_event(patch, "hook_1").stiffness = 99.0
    script.refusal = ()
    run_timer(QUIET)
    assert frames.problems_of(patch) == ()
    assert len(script.asked) == asked + 1


def test_a_procedure_that_was_refused_is_not_asked_for_again_by_itself(patch: bpy.types.Scene, script: Script) -> None:
    script.refusal = (Problem(ProblemCode.EVENT_OFF_TISSUE, "/Procedure", "", "No.", "Yes."),)
    run_timer(QUIET)
    asked = len(script.asked)
    changes.changed(patch)
    run_timer(QUIET)
    assert len(script.asked) == asked
    assert frames.problems_of(patch) == script.refusal
    script.refusal = ()
    assert bpy.ops.lappet.plan_now() == {"FINISHED"}
    assert frames.problems_of(patch) == ()
    assert frames.manifest_of(patch) is not None


def test_a_scene_without_tissue_is_refused_with_the_repair(scene: bpy.types.Scene, script: Script) -> None:
    assert refusal_code(lambda: bpy.ops.lappet.solve(wait=True)) is ProblemCode.TISSUE_NONE
    assert frames.shown_at(scene, 1) is None
    assert script.asked == []


def test_an_edit_while_it_solves_lets_the_frames_before_it_finish_and_stops_there(
    patch: bpy.types.Scene, script: Script
) -> None:
    bpy.ops.lappet.solve()
    while states(patch).count("s") < 2:
        run_timer()
    key = controller.controller_of(patch).job.key
    add_event(patch, "SUTURE", start=6, points=[(2, -1, 2), (2, 1, 2)])
    script.held = True
    run_timer(0.6)
    assert frames.progress_of(patch).running, "frames 3 to 5 are the same in both"
    script.held = False
    assert not run_timer(QUIET)
    assert states(patch) == "sssssmmm"
    assert ProblemCode.PROCEDURE_CHANGED in [note.code for note in frames.notes_of(patch)]
    assert frames.manifest_of(patch).key != key
    solve(patch)


def test_deleting_the_tissue_while_it_solves_loses_nothing(patch: bpy.types.Scene, script: Script) -> None:
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.lappet.solve()
    while states(patch).count("s") < 4:
        run_timer()
    bpy.data.objects.remove(patch.lappet.tissue.object)
    bpy.ops.ed.undo_push(message="deleted")
    assert not run_timer(QUIET)
    assert [problem.code for problem in frames.problems_of(patch)] == [ProblemCode.TISSUE_NONE]
    assert frames.manifest_of(patch) is None
    assert refusal_code(bpy.ops.lappet.solve) is ProblemCode.TISSUE_NONE
    bpy.ops.ed.undo()
    scene = bpy.context.scene
    assert states(scene).startswith("ssss")
    solve(scene)


def test_moving_a_vertex_of_the_tissue_makes_every_frame_stale(patch: bpy.types.Scene, script: Script) -> None:
    solve(patch)
    mesh = patch.lappet.tissue.object.data
    mesh.vertices[0].co.x += 0.25
    mesh.update()
    bpy.context.view_layer.update()
    run_timer(QUIET)
    assert states(patch) == "tttttttt"


def test_moving_a_hooks_target_or_the_end_of_the_timeline_is_noticed(patch: bpy.types.Scene, script: Script) -> None:
    solve(patch)
    bpy.data.objects["target"].location.z += 1.0
    bpy.context.view_layer.update()
    run_timer(QUIET)
    assert states(patch) == "sssttttt"
    patch.frame_end = 10
    run_timer(QUIET)
    assert frames.frame_state(patch, 10) == "missing"
    assert frames.frame_runs(patch)[-1] == FrameRun("missing", 9, 10)


def test_going_through_the_frames_reads_nothing_again(patch: bpy.types.Scene, script: Script) -> None:
    empty = bpy.data.objects["target"]
    empty.keyframe_insert("location", frame=4)
    empty.location.z += 2.0
    empty.keyframe_insert("location", frame=8)
    run_timer(QUIET)
    read_at = controller.controller_of(patch).read_at
    for time in range(1, 9):
        patch.frame_set(time)
        run_timer()
    assert controller.controller_of(patch).dirty_since is None
    assert controller.controller_of(patch).read_at == read_at


def test_a_hook_that_hangs_on_another_object_is_read_once_not_for_ever(patch: bpy.types.Scene, script: Script) -> None:
    rail = bpy.data.objects.new("rail", None)
    patch.collection.objects.link(rail)
    bpy.data.objects["target"].parent = rail
    bpy.context.view_layer.update()
    assert not run_timer(QUIET)
    asked = list(script.asked)
    for _ in range(8):
        bpy.context.view_layer.update()
        run_timer(0.3)
    assert script.asked == asked
    rail.location.z = 2.0
    bpy.context.view_layer.update()
    run_timer(QUIET)
    assert len(script.asked) == len(asked) + 1


def test_two_scenes_are_solved_at_once_and_a_copy_shares_the_frames(patch: bpy.types.Scene, script: Script) -> None:
    bpy.ops.scene.new(type="LINK_COPY")
    other = bpy.context.scene
    assert other != patch
    other.lappet.tissue.spacing = 2.0
    bpy.ops.lappet.solve()
    with bpy.context.temp_override(scene=patch):
        bpy.ops.lappet.solve()
    assert frames.progress_of(other).running
    assert frames.progress_of(patch).running
    assert len(script.workers) == 2
    assert not run_timer(QUIET)
    assert states(patch) == states(other) == "ssssssss"
    assert frames.manifest_of(patch).key != frames.manifest_of(other).key
    asked = script.count("solve")
    other.lappet.tissue.spacing = patch.lappet.tissue.spacing
    run_timer(QUIET)
    assert states(other) == "ssssssss", "the copy finds what the other scene solved"
    assert script.count("solve") == asked
    bpy.data.scenes.remove(other)
    run_timer(QUIET)
    assert [each.uid for each in controller.controllers()] == [patch.session_uid]


def test_a_frame_that_vanished_from_the_store_is_missing_and_solved_again(
    patch: bpy.types.Scene, script: Script
) -> None:
    solve(patch)
    store = controller.controller_of(patch).store
    store.path(frames.manifest_of(patch).frames[4].key).unlink()
    controller.frame_cache.clear()
    shown = frames.shown_at(patch, 5)
    assert (shown.time, shown.stale) == (4, True)
    assert frames.frame_state(patch, 5) == "missing"
    solve(patch)


def test_clearing_removes_the_frames_and_reloading_finds_those_of_another_program(
    patch: bpy.types.Scene, script: Script
) -> None:
    solve(patch)
    store = controller.controller_of(patch).store
    kept = {frame.key: store.get(frame.key, SolvedFrame) for frame in frames.manifest_of(patch).frames}
    assert bpy.ops.lappet.clear_frames() == {"FINISHED"}
    assert states(patch) == "mmmmmmmm"
    assert not any(key in store for key in kept)
    for key, frame in list(kept.items())[:3]:
        store.put(key, frame)
    assert states(patch) == "mmmmmmmm"
    assert bpy.ops.lappet.reload_frames() == {"FINISHED"}
    assert states(patch) == "sssmmmmm"


def test_listeners_are_told_when_what_is_shown_changes_and_not_otherwise(
    patch: bpy.types.Scene, script: Script
) -> None:
    notified: list[str] = []

    def listen(scene: bpy.types.Scene) -> None:
        notified.append(scene.name)

    frames.subscribe(listen)
    try:
        run_timer(QUIET)
        assert notified
        notified.clear()
        for _ in range(5):
            run_timer()
        assert notified == []
        bpy.ops.lappet.solve(wait=True)
        assert len(notified) >= 8, "one for each frame"
    finally:
        frames.unsubscribe(listen)


def test_the_worker_that_cannot_be_started_is_a_sentence_not_a_traceback(
    patch: bpy.types.Scene, script: Script, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> object:
        raise OSError("no more processes")

    monkeypatch.setattr(workers, "create", fail)
    assert not run_timer(QUIET)
    problem = frames.problems_of(patch)[0]
    assert (problem.code, problem.value) == (ProblemCode.SOLVER_NOT_STARTED, "no more processes")
    assert refusal_code(bpy.ops.lappet.solve) is ProblemCode.SOLVER_NOT_STARTED


def test_from_which_time_on_two_procedures_differ_is_the_start_of_the_event_that_does(patch: bpy.types.Scene) -> None:
    old = read_scene(patch).procedure
    assert first_change(old, old) == math.inf
    cut, hook = old.events
    renamed = dataclasses.replace(hook, name="other")
    assert first_change(old, dataclasses.replace(old, events=(cut, renamed))) == math.inf
    assert first_change(old, dataclasses.replace(old, events=(hook, cut))) == math.inf
    assert first_change(old, dataclasses.replace(old, events=(cut,))) == 4.0
    later = dataclasses.replace(hook, start=6.0)
    assert first_change(old, dataclasses.replace(old, events=(cut, later))) == 4.0
    assert first_change(old, dataclasses.replace(old, events=(hook,))) == 3.0
    mark = Landmark("mark", ((0.0, 0.0, 2.0),), "corner")
    assert first_change(old, old.with_events(mark)) == -math.inf
    stiffer = tuple(dataclasses.replace(each, youngs_modulus=70.0) for each in old.materials)
    assert first_change(old, dataclasses.replace(old, materials=stiffer)) == -math.inf
    assert first_change(old, dataclasses.replace(old, end_time=20.0)) == math.inf
    finer = dataclasses.replace(old.tissue, spacing=0.5)
    assert first_change(old, dataclasses.replace(old, tissue=finer)) == -math.inf


def test_removing_an_event_and_adding_it_again_finds_its_frames(patch: bpy.types.Scene, script: Script) -> None:
    add_event(patch, "SUTURE", "stitch", start=5, points=[(2, -1, 2), (2, 1, 2)])
    solve(patch)
    remove_event(patch, find_event(patch, "stitch"))
    run_timer(QUIET)
    assert states(patch) == "sssstttt"
    add_event(patch, "SUTURE", "stitch", start=5, points=[(2, -1, 2), (2, 1, 2)])
    asked = len(script.asked)
    run_timer(QUIET)
    assert states(patch) == "ssssssss"
    assert len(script.asked) == asked
    np.testing.assert_array_equal(frames.shown_at(patch, 8).frame.points[:, 2], 10.0)


def test_undo_finds_the_frames_of_a_hook_that_hangs_on_another_object(patch: bpy.types.Scene, script: Script) -> None:
    rail = bpy.data.objects.new("rail", None)
    patch.collection.objects.link(rail)
    bpy.data.objects["target"].parent = rail
    bpy.context.view_layer.update()
    solve(patch)
    bpy.ops.ed.undo_push(message="solved")
    bpy.data.objects["rail"].location.z = 2.0
    bpy.context.view_layer.update()
    bpy.ops.ed.undo_push(message="lifted")
    run_timer(QUIET)
    assert states(patch) == "sssttttt"
    for _ in range(2):
        bpy.ops.ed.undo()
        assert states(bpy.context.scene) == "ssssssss"
        bpy.ops.ed.redo()
        assert bpy.data.objects["rail"].location.z == 2.0
        assert states(bpy.context.scene) == "sssttttt"
    assert [each.name for each in bpy.data.scenes] == [bpy.context.scene.name]
