"""What the solving side remembers: frames within a bound of bytes, manifests by key, the speed of this machine."""

from __future__ import annotations

import time
from pathlib import Path

import bpy
import numpy as np
import pytest

from fake_worker import make_manifest
from lappet.background.manifest_store import put_manifest
from lappet.core.problem import Problem
from lappet.core.problem_code import ProblemCode
from lappet.daemon.solved_frame import SolvedFrame
from lappet.daemon.solver_state import SolverState
from lappet.procedure import Incision, Procedure
from lappet.program.settings import SolverSettings
from lappet.solve.store import FrameStore
from lappet.tissue.patch import flat_patch
from lappet_blender.interface.duration_text import duration_text
from lappet_blender.model.tissue_size import cell_count
from lappet_blender.solving.frame_cache import FrameCache
from lappet_blender.solving.frame_copy import FrameCopy
from lappet_blender.solving.manifest_memory import ManifestMemory
from lappet_blender.solving.speed_estimate import SpeedEstimate

assert bpy  # the parts above need Blender's module, not a scene


def key(number: int) -> str:
    return f"{number:064x}"


def frame(points: int = 100) -> SolvedFrame:
    return SolvedFrame(0.0, np.zeros((points, 3), np.float32))


@pytest.fixture
def store(tmp_path: Path) -> FrameStore:
    return FrameStore(tmp_path / "store")


@pytest.fixture
def procedure() -> Procedure:
    cut = Incision("cut", 3.0, ((-6.0, 0.0, 2.0), (6.0, 0.0, 2.0)))
    return Procedure(flat_patch((24.0, 16.0, 2.0), resolution=2.0, spacing=1.0), events=(cut,), end_time=5.0)


def test_the_frames_used_longest_ago_leave_memory_when_its_bound_is_passed(store: FrameStore) -> None:
    frame_cache = FrameCache(limit=3 * 1200)
    for number in range(3):
        frame_cache.put(key(number), frame())
    frame_cache.get(key(0), store)
    frame_cache.put(key(3), frame())
    assert [number for number in range(4) if key(number) in frame_cache] == [0, 2, 3]
    assert frame_cache.bytes == 3 * 1200
    frame_cache.put(key(3), frame(200))
    assert frame_cache.bytes == 2400 + 1200
    assert [number for number in range(4) if key(number) in frame_cache] == [0, 3]
    frame_cache.put(key(9), frame(10_000))
    assert key(9) in frame_cache, "one that is larger than the bound is still shown"
    frame_cache.drop(key(9))
    assert frame_cache.bytes == 0


def test_a_frame_comes_from_the_store_where_memory_has_it_not(store: FrameStore) -> None:
    frame_cache = FrameCache()
    assert frame_cache.get(key(1), store) is None
    points = np.arange(12, dtype=np.float32).reshape(4, 3)
    state = SolverState("float", np.zeros((2, 3), np.float32), *(np.zeros((0, 3)),) * 2, *(np.zeros(0),) * 2)
    store.put(key(1), SolvedFrame(1.0, points, state=state))
    found = frame_cache.get(key(1), store)
    np.testing.assert_array_equal(found.points, points)
    assert found.state is None, "the state is of no use to a window"
    store.path(key(1)).unlink()
    assert frame_cache.get(key(1), store) is found


def test_reading_ahead_fills_memory_and_goes_on_after_it_was_closed(store: FrameStore) -> None:
    frame_cache = FrameCache()
    for number in range(6):
        store.put(key(number), SolvedFrame(0.0, np.full((4, 3), number, np.float32)))
    for wanted in ((0, 1, 2), (3, 4, 5)):
        frame_cache.read_ahead([key(number) for number in wanted], store)
        end = time.monotonic() + 10.0
        while not all(key(number) in frame_cache for number in wanted):
            assert time.monotonic() < end
            time.sleep(0.005)
        frame_cache.close()


def test_plans_share_their_surfaces_and_are_found_in_the_store(store: FrameStore, procedure: Procedure) -> None:
    memory = ManifestMemory(limit=2)
    made = [make_manifest(procedure, SolverSettings(tolerance=10.0**-n)) for n in (2, 3, 4)]
    kept = [memory.keep(manifest) for manifest in made]
    assert kept[0].epochs[1] is kept[2].epochs[1]
    assert memory.find(made[0].key, store) is None, "only so many are kept"
    put_manifest(store, made[0])
    found = memory.find(made[0].key, store)
    assert found.frames == made[0].frames
    assert found.epochs[1] is kept[2].epochs[1]
    memory.refuse(key(7), (Problem(ProblemCode.TIMELINE_NO_FRAME, "/Procedure", "", "No.", "Yes."),))
    assert memory.refused(key(7))
    memory.keep(made[1], key(7))
    assert memory.refused(key(7)) is None
    assert memory.find(key(7), store).key == made[1].key


def test_an_epoch_of_equal_shape_at_another_time_keeps_its_time(store: FrameStore, procedure: Procedure) -> None:
    memory = ManifestMemory()
    early = memory.keep(make_manifest(procedure, SolverSettings()))
    moved = procedure.events[0]
    later = Procedure(procedure.tissue, events=(Incision("cut", 4.0, moved.points),), end_time=5.0)
    manifest = make_manifest(later, SolverSettings())
    assert manifest.epochs[1].key == early.epochs[1].key
    assert memory.keep(manifest).epochs[1].start_time == 4.0


def test_the_speed_of_this_machine_is_remembered_and_follows_what_is_measured(tmp_path: Path) -> None:
    estimate = SpeedEstimate(tmp_path / "store")
    assert not estimate.known
    assert estimate.seconds(1000.0) is None
    estimate.measured(1000.0, 2.0)
    assert estimate.seconds(500.0) == pytest.approx(1.0)
    for _ in range(60):
        estimate.measured(1000.0, 4.0)
    assert estimate.seconds(1000.0) == pytest.approx(4.0, rel=1e-3)
    estimate.keep()
    assert SpeedEstimate(tmp_path / "store").seconds(1000.0) == pytest.approx(4.0, rel=1e-3)
    (tmp_path / "store" / "speed_estimate.json").write_text("[")
    assert not SpeedEstimate(tmp_path / "store").known


def test_durations_are_said_as_people_say_them() -> None:
    said = [duration_text(seconds) for seconds in (0.2, 12.4, 89.0, 240.0, 9000.0)]
    assert said == ["about 1 s", "about 12 s", "about 89 s", "about 4 min", "about 2.5 h"]


def test_the_cells_of_a_box_are_its_volume_over_that_of_a_cell_and_those_its_surface_cuts() -> None:
    box = flat_patch((24.0, 16.0, 8.0), resolution=2.0, spacing=0.5)
    inside = 24.0 * 16.0 * 8.0 / 0.5**3
    surface = 2.0 * (24.0 * 16.0 + 24.0 * 8.0 + 16.0 * 8.0) / 0.5**2
    assert inside < cell_count(box) < inside + surface
    coarse = flat_patch((24.0, 16.0, 8.0), resolution=2.0, spacing=1.0)
    assert 4.0 < cell_count(box) / cell_count(coarse) < 8.0


def test_what_is_copied_to_another_folder_is_all_that_a_manifest_needs(
    store: FrameStore, procedure: Procedure, tmp_path: Path
) -> None:
    manifest = make_manifest(procedure, SolverSettings())
    put_manifest(store, manifest)
    for listed in manifest.frames[:3]:
        store.put(listed.key, SolvedFrame(0.0, np.zeros((4, 3), np.float32)))
    other = FrameStore(tmp_path / "other")
    copying = FrameCopy([manifest], store, other)
    end = time.monotonic() + 10.0
    while not copying.done:
        assert time.monotonic() < end
        time.sleep(0.005)
    assert copying.problem is None
    assert ManifestMemory().find(manifest.key, other).frames == manifest.frames
    assert [frame.key in other for frame in manifest.frames] == [True] * 3 + [False] * 2
