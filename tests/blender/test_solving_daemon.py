"""Solving from Blender with the real worker and the real solver."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

import bpy
import numpy as np
import pytest

from lappet.background.manifest_key import manifest_key
from lappet.core.problem_code import ProblemCode
from lappet.daemon.daemon_solver import connect_to, solver_identity
from lappet.daemon.process import DaemonMissing, find_daemon
from lappet.program.compile import compile_program
from lappet.program.keys import frame_keys
from lappet.solve.solve_frames import SolveObserver, solve_program
from lappet.solve.store import FrameStore
from lappet_blender.model.event_list import add_event, find_event
from lappet_blender.model.scene_procedure import read_scene
from lappet_blender.solving import controller, frames, speed_estimate
from lappet_blender.solving.solve_settings import solve_settings
from lappet_blender.solving.solve_timer import run_timer
from patch_scene import make_patch_scene
from solving_steps import live_points, solve, states

pytest_plugins = ("solving_fixtures",)
PATIENCE = 120.0
SLOW = 0.3  # mm, at which a frame takes long enough to do something meanwhile


@pytest.fixture(scope="session", autouse=True)
def _daemon() -> None:
    try:
        find_daemon()
    except DaemonMissing as reason:
        pytest.skip(str(reason))


@pytest.fixture
def patch(scene: bpy.types.Scene, own_store: Path) -> bpy.types.Scene:
    """The patch scene, unsolved."""
    return make_patch_scene(scene)


def pump_until(condition, what: str) -> None:  # type: ignore[no-untyped-def]
    """Lets the timer run until something has happened."""
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, f"still waiting until {what}"
        run_timer()
        time.sleep(0.01)


def quiet() -> None:
    assert not run_timer(PATIENCE), "something is still under way"


def test_the_button_gives_the_frames_of_the_command_line_bit_for_bit(patch: bpy.types.Scene, tmp_path: Path) -> None:
    solve(patch)
    procedure = read_scene(patch).procedure
    settings = solve_settings(patch)
    program = compile_program(procedure, settings=settings)
    manifest = frames.manifest_of(patch)
    assert manifest.key == manifest_key(procedure, settings, solver_identity(None))
    assert tuple(frame.key for frame in manifest.frames) == frame_keys(program, solver_identity(None))
    other = FrameStore(tmp_path / "command line")
    solved = solve_program(program, other, connect_to(None), solver_identity(None), SolveObserver())
    assert solved.reason is None
    for frame, own in zip(solved.frames, manifest.frames, strict=True):
        shown = frames.shown_at(patch, own.time).frame
        np.testing.assert_array_equal(shown.points, frame.solved.points)
        np.testing.assert_array_equal(shown.stress, frame.solved.stress)


def test_the_hook_lifts_the_skin_and_a_changed_hook_is_solved_from_its_start_on(patch: bpy.types.Scene) -> None:
    solve(patch)

    def height(time: int) -> float:
        return float(frames.shown_at(patch, time).frame.points[:, 2].max())

    assert height(3) < 2.0 + 0.2
    assert height(7) > height(3) + 0.1
    low = height(7)
    bpy.data.objects["target"].location.z += 2.0
    bpy.context.view_layer.update()
    quiet()
    assert states(patch) == "sssttttt"
    assert bpy.ops.lappet.solve() == {"FINISHED"}
    job = controller.controller_of(patch).job
    quiet()
    assert (job.done, job.solved) == (8, 5)
    assert states(patch) == "ssssssss"
    assert height(7) > low + 0.1
    assert frames.progress_of(patch).line == "8 of 8 frames solved"
    assert speed_estimate.speed_estimate().seconds(1000.0) > 0.0


def test_undo_brings_solved_frames_back_at_once(patch: bpy.types.Scene) -> None:
    bpy.ops.ed.undo_push(message="before")
    solve(patch)
    bpy.ops.ed.undo_push(message="solved")
    add_event(patch, "SUTURE", start=5, points=[(2, -1, 2), (2, 1, 2)])
    bpy.ops.ed.undo_push(message="suture")
    quiet()
    assert states(patch) == "sssstttt"
    begun = time.perf_counter()
    bpy.ops.ed.undo()
    assert time.perf_counter() - begun < 1.0
    assert states(bpy.context.scene) == "ssssssss"
    bpy.ops.ed.redo()
    assert states(bpy.context.scene) == "sssstttt"


def test_a_saved_file_opens_with_its_frames_and_starts_no_worker(patch: bpy.types.Scene, blend: Path) -> None:
    solve(patch)
    points = frames.shown_at(patch, 8).frame.points
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    controller.drop_all()
    controller.frame_cache.clear()
    controller.manifests.clear()
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    scene = bpy.context.scene
    assert states(scene) == "ssssssss"
    np.testing.assert_array_equal(frames.shown_at(scene, 8).frame.points, points)
    quiet()
    assert controller.controller_of(scene).client is None


def test_cancel_keeps_what_is_solved_and_a_solve_goes_on_from_there(patch: bpy.types.Scene) -> None:
    patch.lappet.tissue.spacing = SLOW
    bpy.ops.lappet.solve()
    pump_until(lambda: states(patch).count("s") >= 2, "two frames are there")
    bpy.ops.lappet.solve_cancel()
    quiet()
    done = states(patch).count("s")
    assert 2 <= done < 8
    bpy.ops.lappet.solve()
    job = controller.controller_of(patch).job
    quiet()
    assert states(patch) == "ssssssss"
    assert job.solved == 8 - done


def test_a_worker_that_is_killed_is_started_again_with_one_line(patch: bpy.types.Scene) -> None:
    patch.lappet.tissue.spacing = SLOW
    bpy.ops.lappet.solve()
    pump_until(lambda: states(patch).count("s") >= 1, "a frame is there")
    os.kill(controller.controller_of(patch).client.worker, signal.SIGKILL)
    quiet()
    assert states(patch) == "ssssssss"
    codes = [note.code for note in frames.notes_of(patch)]
    assert codes.count(ProblemCode.BACKGROUND_RESTARTED) == 1
    assert frames.problems_of(patch) == ()


@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="finds the daemon in /proc")
def test_a_daemon_that_is_killed_is_started_again_with_one_line(patch: bpy.types.Scene) -> None:
    patch.lappet.tissue.spacing = SLOW
    bpy.ops.lappet.solve()
    pump_until(lambda: states(patch).count("s") >= 1, "a frame is there")
    worker = controller.controller_of(patch).client.worker
    tasks = Path(f"/proc/{worker}/task").glob("*/children")
    for child in {int(pid) for task in tasks for pid in task.read_text().split()}:
        if "solverd" in Path(f"/proc/{child}/cmdline").read_text():
            os.kill(child, signal.SIGKILL)
    quiet()
    assert states(patch) == "ssssssss"
    codes = [note.code for note in frames.notes_of(patch)]
    assert codes.count(ProblemCode.DAEMON_RESTARTED) == 1
    assert frames.problems_of(patch) == ()


def test_a_procedure_that_makes_no_sense_is_refused_with_the_event_that_is_wrong(patch: bpy.types.Scene) -> None:
    find_event(patch, "hook_1").points[0].co = (90.0, 0.0, 2.0)
    with pytest.raises(RuntimeError, match="hook_1"):
        bpy.ops.lappet.solve(wait=True)
    problems = frames.problems_of(patch)
    assert any("hook_1" in problem.prim for problem in problems)
    assert bpy.ops.lappet.problem_show(index=0) == {"FINISHED"}
    assert patch.lappet.events[patch.lappet.active_event].name == "hook_1"
    find_event(patch, "hook_1").points[0].co = (0.0, 2.0, 2.0)
    solve(patch)
    assert [each for each in frames.problems_of(patch) if each.severity == "error"] == []


def test_the_skin_follows_a_hook_that_is_dragged(patch: bpy.types.Scene) -> None:
    solve(patch)
    patch.frame_set(6)
    target = bpy.data.objects["target"]
    rest = frames.shown_at(patch, 6).frame.points[:, 2].max()
    assert bpy.ops.lappet.live(hook="hook_1") == {"FINISHED"}
    pump_until(lambda: live_points(patch) is not None, "the first live frame is there")
    assert live_points(patch)[:, 2].max() == pytest.approx(rest, abs=0.02)
    target.location.z += 3.0
    bpy.context.view_layer.update()
    pump_until(lambda: live_points(patch)[:, 2].max() > rest + 0.3, "the skin has followed")
    shown = frames.shown_at(patch, 6)
    np.testing.assert_array_equal(shown.frame.points, live_points(patch))
    assert bpy.ops.lappet.live() == {"FINISHED"}
    quiet()
    assert states(patch) == "sssttttt"
    live_height = shown.frame.points[:, 2].max()
    solve(patch)
    solved_height = frames.shown_at(patch, 6).frame.points[:, 2].max()
    assert solved_height == pytest.approx(live_height, abs=0.1), "what was seen live is what a solve finds"


def test_two_scenes_are_solved_at_once(patch: bpy.types.Scene) -> None:
    bpy.ops.scene.new(type="LINK_COPY")
    other = bpy.context.scene
    other.lappet.tissue.spacing = 2.0
    bpy.ops.lappet.solve()
    with bpy.context.temp_override(scene=patch):
        bpy.ops.lappet.solve()
    assert frames.progress_of(other).running
    assert frames.progress_of(patch).running
    quiet()
    assert states(patch) == states(other) == "ssssssss"
    assert frames.manifest_of(patch).frames[-1].key != frames.manifest_of(other).frames[-1].key
