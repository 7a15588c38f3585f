"""Blender stays responsive: what the solving side does on the main thread at 20 000 vertices, call by call.

What must hold is 50 ms; the bounds here are three times that. What counts is the processor's time of the main thread:
a machine that does other work meanwhile proves nothing.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest

from lappet.daemon.process import DaemonMissing, find_daemon
from lappet.tissue.patch import flat_patch
from lappet_blender.model.event_list import add_event, find_event
from lappet_blender.model.scene_procedure import read_scene
from lappet_blender.model.tissue_values import tissue_value
from lappet_blender.solving import controller, frames, scene_watch
from lappet_blender.solving.frames import FrameRun
from lappet_blender.solving.solve_timer import run_timer
from patch_scene import put_tissue

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
    begun = time.thread_time()
    call()
    return time.thread_time() - begun


def longest_pump() -> float:
    """Lets the timer run until nothing is under way, and says how long its longest call took."""
    end, longest, busy = time.monotonic() + PATIENCE, 0.0, True
    while busy and time.monotonic() < end:
        begun = time.thread_time()
        busy = run_timer()
        longest = max(longest, time.thread_time() - begun)
        time.sleep(0.01)
    assert not busy, "something is still under way"
    return longest


def test_nothing_that_solving_does_stalls_blender_at_20_000_vertices(sheet: bpy.types.Scene) -> None:
    took = {"listing": longest_pump()}
    took["pressing Solve"] = seconds(bpy.ops.lappet.solve)
    took["frames that come in"] = longest_pump()
    assert frames.frame_runs(sheet) == (FrameRun("solved", 1, 6),)

    bpy.ops.ed.undo_push(message="solved")
    find_event(sheet, "hook_1").stiffness = 50.0
    bpy.ops.ed.undo_push(message="softer")
    took["reading an edit, and its manifest"] = longest_pump()
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


def test_editing_an_open_surface_that_is_thickened_does_not_stall(scene: bpy.types.Scene, own_store: Path) -> None:
    scene.unit_settings.scale_length = 0.001
    scene.frame_start, scene.frame_end = 1, 2
    scene.lappet.materials.add().name = "skin"
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=144, y_subdivisions=144, size=120.0)
    tissue = bpy.context.object
    lappet = scene.lappet.tissue
    lappet.object, lappet.thicken, lappet.thickness, lappet.spacing = tissue, True, 3.0, 3.0
    assert len(tissue.data.vertices) > 20_000
    took = {"the first reading": longest_pump()}
    before = tissue_value(scene)[0]
    tissue.data.vertices[0].co.z += 0.5
    tissue.data.update()
    bpy.context.view_layer.update()
    took["an edit"] = longest_pump()
    assert tissue_value(scene)[0] is not before
    assert read_scene(scene).problems == ()
    tissue.data.vertices[0].co.z -= 0.5
    tissue.data.update()
    bpy.context.view_layer.update()
    took["the edit taken back"] = seconds(lambda: tissue_value(scene))
    np.testing.assert_array_equal(tissue_value(scene)[0].points, before.points)
    assert max(took.values()) < STALL, took


def test_what_is_shown_is_found_in_a_third_of_a_millisecond_once_it_is_in_memory(sheet: bpy.types.Scene) -> None:
    bpy.ops.lappet.solve(wait=True)
    controller.frame_cache.clear()
    frames.shown_at(sheet, 3)  # from the store; its neighbors are read ahead
    end = time.monotonic() + 20.0
    keys = [frame.key for frame in frames.manifest_of(sheet).frames]
    while not all(key in controller.frame_cache for key in keys):
        assert time.monotonic() < end, "the neighbors of a frame are read before they are asked for"
        time.sleep(0.01)
    times = sorted(seconds(lambda t=t: frames.shown_at(sheet, t)) for _ in range(50) for t in range(1, 7))
    assert times[len(times) // 2] < SHOWN
    runs = sorted(seconds(lambda: frames.frame_runs(sheet)) for _ in range(50))
    assert runs[25] < SHOWN
