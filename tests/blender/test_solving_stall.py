"""Blender stays responsive: what the solving side does on the main thread at 20 000 vertices, call by call.

What must hold is 50 ms; the bounds here are three times that, for machines that do other work meanwhile.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import bpy
import pytest
from patch_scene import put_tissue

from lappet.daemon import DaemonMissing, find_daemon
from lappet.patch import flat_patch
from lappet_blender.model.event_list import add_event, find_event
from lappet_blender.solving import controller, frames, scene_watch
from lappet_blender.solving.frames import FrameRun
from lappet_blender.solving.pump import pump

pytest_plugins = ("solving_fixtures",)
STALL = 3 * 0.050
SHOWN = 0.0003
PATIENCE = 200.0


@pytest.fixture
def sheet(scene: bpy.types.Scene, own_store: Path) -> bpy.types.Scene:
    """A sheet of 20 802 vertices, slit at 3 and hooked from 4; frames 1 to 6."""
    try:
        find_daemon()
    except DaemonMissing as reason:
        pytest.skip(str(reason))
    scene.unit_settings.scale_length = 0.001
    scene.frame_start, scene.frame_end = 1, 6
    scene.lappet.materials.add().name = "skin"
    tissue = put_tissue(scene, flat_patch((100.0, 100.0, 2.0), resolution=1.0, spacing=2.0))
    assert len(tissue.data.vertices) >= 20_000
    add_event(scene, "INCISION", start=3, points=[(-6, 0, 2), (6, 0, 2)], kerf=0.1)
    empty = bpy.data.objects.new("target", None)
    scene.collection.objects.link(empty)
    empty.location = (0.0, 3.0, 4.0)
    add_event(scene, "HOOK", start=4, end=6, points=[(0, 2, 2)], target=empty, stiffness=100.0)
    return scene


def seconds(call: Callable[[], object]) -> float:
    begun = time.perf_counter()
    call()
    return time.perf_counter() - begun


def longest_pump() -> float:
    """Lets the timer run until nothing is under way, and says how long its longest call took."""
    end, longest, busy = time.monotonic() + PATIENCE, 0.0, True
    while busy and time.monotonic() < end:
        begun = time.perf_counter()
        busy = pump()
        longest = max(longest, time.perf_counter() - begun)
        time.sleep(0.01)
    assert not busy, "something is still under way"
    return longest


def test_nothing_that_solving_does_stalls_blender_at_20_000_vertices(sheet: bpy.types.Scene) -> None:
    took = {"planning": longest_pump()}
    took["pressing Solve"] = seconds(bpy.ops.lappet.solve)
    took["frames that come in"] = longest_pump()
    assert frames.frame_runs(sheet) == (FrameRun("solved", 1, 6),)

    bpy.ops.ed.undo_push(message="solved")
    find_event(sheet, "hook_1").stiffness = 50.0
    bpy.ops.ed.undo_push(message="softer")
    took["reading an edit, and its plan"] = longest_pump()
    assert frames.frame_runs(sheet) == (FrameRun("solved", 1, 3), FrameRun("stale", 4, 6))
    took["undo"] = seconds(scene_watch._undone)

    mesh = sheet.lappet.tissue.object.data
    mesh.vertices[0].co.z += 0.01
    mesh.update()
    took["telling of an edited mesh"] = seconds(bpy.context.view_layer.update)
    took["reading an edited mesh"] = longest_pump()
    assert frames.frame_runs(sheet) == (FrameRun("stale", 1, 6),)
    took["what a panel asks"] = seconds(lambda: frames.progress_of(sheet))
    assert max(took.values()) < STALL, took


def test_what_is_shown_is_found_in_a_third_of_a_millisecond_once_it_is_in_memory(sheet: bpy.types.Scene) -> None:
    bpy.ops.lappet.solve(wait=True)
    controller.shelf.clear()
    frames.shown_at(sheet, 3)  # from the store; its neighbours are read ahead
    end = time.monotonic() + 20.0
    keys = [frame.key for frame in frames.plan_of(sheet).frames]
    while not all(key in controller.shelf for key in keys):
        assert time.monotonic() < end, "the neighbours of a frame are read before they are asked for"
        time.sleep(0.01)
    times = sorted(seconds(lambda t=t: frames.shown_at(sheet, t)) for _ in range(50) for t in range(1, 7))
    assert times[len(times) // 2] < SHOWN
    runs = sorted(seconds(lambda: frames.frame_runs(sheet)) for _ in range(50))
    assert runs[25] < SHOWN
