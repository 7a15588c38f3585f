"""The background solver with the real worker and daemon: the frames of `lappet solve`, whatever dies meanwhile."""

from __future__ import annotations

import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from background_owner import SETTINGS, contents, is_frame, long_procedure, owner
from lappet.background.manifest_store import get_manifest, put_manifest
from lappet.background.solver import BackgroundSolver
from lappet.background.worker_events import (
    Finished,
    FrameFailed,
    FrameReady,
    IterationDone,
    Listed,
)
from lappet.core.problem import problem
from lappet.core.problem_code import ProblemCode
from lappet.core.value_codec import pack
from lappet.output.solve_to_cache import solve_procedure
from lappet.procedure import Suture, pose_at
from lappet.program.settings import SolverSettings
from lappet.solve.store import FrameStore
from small_procedure import TOP, small_procedure

pytestmark = pytest.mark.slow


TOLD = problem(ProblemCode.CURVE_PINNED, "/Procedure/Timeline/slit", "from the store")


def test_a_background_solve_has_the_keys_and_the_bits_of_lappet_solve(tmp_path: Path, binary: Path) -> None:
    result = solve_procedure(
        small_procedure(), tmp_path / "c.usdc", store=FrameStore(tmp_path / "foreground"), error_estimate=False
    )
    with owner(tmp_path / "background") as own:
        job = own.solver.solve(small_procedure(), SETTINGS)
        ended = own.finished(job)
        assert (ended.frames, ended.cancelled) == (8, False)
        frames = own.frames(job)
        assert own.manifest(job).known == (False,) * 8
    keys = [frame.key for frame in result.frames]
    assert [frames[time].key for time in range(1, 9)] == keys
    assert contents(tmp_path / "background", keys) == contents(tmp_path / "foreground", keys)
    for frame, told in zip(result.frames, frames.values(), strict=True):
        assert not told.looked_up
        assert told.frame is not None
        assert pack(told.frame.arrays()) == pack(frame.solved.arrays())
        assert told.frame.state is None


def test_the_other_way_round_lappet_solve_finds_every_frame_of_the_background(tmp_path: Path, binary: Path) -> None:
    with owner(tmp_path / "store") as own:
        own.finished(own.solver.solve(small_procedure(), SETTINGS))
    result = solve_procedure(
        small_procedure(), tmp_path / "c.usdc", store=FrameStore(tmp_path / "store"), error_estimate=False
    )
    assert (result.solved, result.looked_up) == (0, 8)


def test_frames_arrive_while_the_solve_goes_on_and_polling_costs_next_to_nothing(tmp_path: Path, binary: Path) -> None:
    with owner(tmp_path) as own:
        job = own.solver.solve(long_procedure(), SETTINGS)
        own.until(is_frame(1))
        first = time.perf_counter()
        own.finished(job)
        assert time.perf_counter() > first
        kinds = [type(each) for each in own.happened]
        assert kinds.index(Listed) < kinds.index(FrameReady) < len(kinds) - 1
        assert IterationDone in kinds
        assert kinds[-1] is Finished
        assert own.slowest < 0.02


def test_a_cancelled_solve_keeps_what_is_done_and_the_next_one_looks_it_up(
    foreground: Path, tmp_path: Path, binary: Path
) -> None:
    procedure = long_procedure()
    with owner(tmp_path) as own:
        job = own.solver.solve(procedure, SETTINGS)
        own.until(is_frame(3))
        own.solver.cancel(job)
        ended = own.finished(job)
        assert ended.cancelled
        done = own.frames(job)
        assert 3 <= len(done) == ended.frames < 24
        assert not own.of(FrameFailed, job)

        again = own.solver.solve(procedure, SETTINGS)
        assert own.finished(again).frames == 24
        frames = own.frames(again)
        assert [frame.looked_up for frame in frames.values()] == [True] * len(done) + [False] * (24 - len(done))
        assert all(frame.frame is None for frame in frames.values() if frame.looked_up)
        assert sum(own.manifest(again).known) == len(done)
        keys = [frame.key for frame in frames.values()]
    assert contents(tmp_path, keys) == contents(foreground, keys)


def test_an_edit_solves_only_the_frames_after_it_and_an_undo_none(tmp_path: Path, binary: Path) -> None:
    base = small_procedure()
    edited = base.with_events(Suture("second", ((-2.0, -1.0, TOP), (-2.0, 1.0, TOP)), 7.0))
    with owner(tmp_path) as own:
        own.finished(own.solver.solve(base, SETTINGS))
        job = own.solver.solve(edited, SETTINGS)
        own.finished(job)
        assert own.manifest(job).known == (True,) * 6 + (False,) * 2
        assert [frame.looked_up for frame in own.frames(job).values()] == [True] * 6 + [False] * 2
        undone = own.solver.solve(base, SETTINGS)
        own.finished(undone)
        assert own.manifest(undone).known == (True,) * 8
        assert all(frame.looked_up for frame in own.frames(undone).values())


def test_a_solve_ends_at_the_frame_that_is_asked_for(tmp_path: Path, binary: Path) -> None:
    with owner(tmp_path) as own:
        job = own.solver.solve(small_procedure(), SETTINGS, until=3)
        assert own.finished(job).frames == 3
        assert list(own.frames(job)) == [1, 2, 3]
        assert len(own.manifest(job).manifest.frames) == 8
        assert own.finished(own.solver.solve(small_procedure(), SETTINGS, until=0)).frames == 0


def test_a_manifest_is_found_in_the_store_after_a_restart_without_compiling(tmp_path: Path, binary: Path) -> None:
    with owner(tmp_path) as own:
        job = own.solver.manifest(small_procedure(), SETTINGS)
        own.finished(job)
        first = own.manifest(job).manifest
        assert first.key == own.solver.key(small_procedure(), SETTINGS)
    assert get_manifest(FrameStore(tmp_path), first.key) is not None
    # Compiled again the manifest would have notes of its own; that of the store is told as it lies there.
    store = FrameStore(tmp_path)
    put_manifest(store, replace(first, notes=(TOLD,)))
    with owner(tmp_path) as own:
        job = own.solver.manifest(small_procedure(), SETTINGS)
        own.finished(job)
        assert own.manifest(job).manifest.notes == (TOLD,)
        assert own.manifest(job).manifest.frames == first.frames


def test_two_owners_solve_into_one_store_at_once(foreground: Path, tmp_path: Path, binary: Path) -> None:
    with owner(tmp_path) as one, owner(tmp_path) as two:
        jobs = one.solver.solve(long_procedure(), SETTINGS), two.solver.solve(long_procedure(), SETTINGS)
        assert one.finished(jobs[0]).frames == two.finished(jobs[1]).frames == 24
        keys = [frame.key for frame in one.frames(jobs[0]).values()]
        assert keys == [frame.key for frame in two.frames(jobs[1]).values()]
    assert contents(tmp_path, keys) == contents(foreground, keys)


def test_a_manifest_does_not_wait_for_a_solve_and_a_newer_manifest_replaces_those_that_wait(
    tmp_path: Path, binary: Path
) -> None:
    with owner(tmp_path) as own:
        solve = own.solver.solve(long_procedure(), SolverSettings(spacing=0.7))
        own.until(is_frame(1))
        manifests = [
            own.solver.manifest(replace(small_procedure(), fps=float(fps)), SolverSettings(spacing=0.7))
            for fps in range(1, 6)
        ]
        ended = own.finished(manifests[-1])
        assert not ended.cancelled
        assert solve in own.solver.running
        assert own.manifest(manifests[-1]).manifest.key == own.solver.key(
            replace(small_procedure(), fps=5.0), SolverSettings(spacing=0.7)
        )
        assert all(own.of(Finished, manifest) for manifest in manifests)
        assert sum(end.cancelled for manifest in manifests for end in own.of(Finished, manifest)) >= 2
        own.solver.cancel(solve)
        assert own.finished(solve).cancelled


def test_asking_costs_the_window_next_to_nothing_at_twenty_thousand_vertices(tmp_path: Path, binary: Path) -> None:
    from lappet.tissue.patch import flat_patch

    base = small_procedure()
    large = replace(base, tissue=flat_patch((100.0, 100.0, 2.0), resolution=1.0, spacing=2.0))
    assert len(large.tissue.points) > 20_000
    with owner(tmp_path) as own:
        costs = []
        for _ in range(5):
            begun = time.perf_counter()
            job = own.solver.manifest(large, SETTINGS)
            own.solver.cancel(job)
            costs.append(time.perf_counter() - begun)
        own.finished(job)
    assert min(costs) < 0.002


def test_the_worker_imports_neither_usd_nor_blender_nor_the_command_line(binary: Path) -> None:
    program = (
        "import sys, lappet.background.worker, lappet.background.solve_job, lappet.background.live_job\n"
        "import lappet.daemon.daemon_solver\n"
        "print(*sorted({name.partition('.')[0] for name in sys.modules} & {'bpy', 'pxr', 'click', 'rich', 'trimesh'}))"
    )
    from lappet.core.interpreter import child_environment

    done = subprocess.run(
        [sys.executable, "-s", "-P", "-c", program],
        env=child_environment({}, [], None),
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.strip() == ""


def test_what_happened_in_a_closed_or_unknown_job_is_nothing(tmp_path: Path) -> None:
    solver = BackgroundSolver(store=tmp_path)
    solver.cancel(7)
    solver.live_target(7, pose_at((0.0, 0.0, 0.0)))
    assert solver.poll() == []
    solver.close()
    solver.close()
    with pytest.raises(RuntimeError, match="closed"):
        solver.manifest(small_procedure(), SETTINGS)


def test_iterations_that_nobody_polled_for_do_not_pile_up(tmp_path: Path, binary: Path) -> None:
    with owner(tmp_path) as own:
        job = own.solver.solve(long_procedure(6), SETTINGS)
        end = time.monotonic() + 60.0
        while own.solver.running and time.monotonic() < end:
            time.sleep(0.01)
        own.happened += own.solver.poll()
        pairs = zip(own.happened, own.happened[1:], strict=False)
        assert not any(isinstance(a, IterationDone) and isinstance(b, IterationDone) for a, b in pairs)
        assert len(own.frames(job)) == 6


def test_frames_of_a_manifest_fit_the_surface_of_their_epoch(tmp_path: Path, binary: Path) -> None:
    with owner(tmp_path) as own:
        weightless = replace(small_procedure().tissue, gravity=0.0)  # its first frame is at rest
        job = own.solver.solve(small_procedure(tissue=weightless), SETTINGS)
        own.finished(job)
        manifest = own.manifest(job).manifest
        for listed, told in zip(manifest.frames, own.frames(job).values(), strict=True):
            assert told.frame is not None
            assert told.frame.points.shape == manifest.epochs[listed.epoch].rest.shape
            assert tuple(told.frame.hook_index) == listed.hooks
            assert tuple(told.frame.suture_index) == listed.sutures
            assert tuple(told.frame.landmark_index) == manifest.landmarks_at[listed.epoch]
        rest = manifest.epochs[0].rest
        whole = own.frames(job)[1].frame
        assert whole is not None
        np.testing.assert_allclose(whole.points, rest, atol=1e-4)
