"""What goes wrong in the background: killed workers and daemons, refusals, full disks, owners that end."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest

from background_owner import (
    SETTINGS,
    Owner,
    alive,
    contents,
    daemon_of,
    is_frame,
    kill,
    long_procedure,
    owner,
    wait_gone,
)
from lappet.background.solver import BackgroundSolver
from lappet.background.worker_events import (
    FrameFailed,
    Listed,
    Refused,
)
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Hook, Incision
from lappet.program.settings import SolverSettings
from small_procedure import TOP, small_procedure

pytestmark = pytest.mark.slow

MISSING = Path("no such folder")


def test_a_killed_worker_is_started_again_and_nothing_is_lost(foreground: Path, tmp_path: Path, binary: Path) -> None:
    with owner(tmp_path) as own:
        job = own.solver.solve(long_procedure(), SETTINGS)
        own.until(is_frame(4))
        worker = own.solver.worker
        assert worker is not None
        daemon = daemon_of(worker)
        kill(worker)
        assert own.finished(job).frames == 24
        wait_gone(daemon)
        assert own.solver.worker != worker
        (note,) = own.notes(job)
        assert (note.code, note.severity) == (ProblemCode.BACKGROUND_RESTARTED, "note")
        assert "SIGKILL" in note.value
        frames = own.frames(job)
        assert own.manifest(job).manifest.frames[3].key == frames[4].key
        keys = [frame.key for frame in frames.values()]
    assert len(keys) == 24
    assert contents(tmp_path, keys) == contents(foreground, keys)


def test_a_killed_daemon_costs_one_note_and_no_frame(foreground: Path, tmp_path: Path, binary: Path) -> None:
    with owner(tmp_path) as own:
        job = own.solver.solve(long_procedure(), SETTINGS)
        own.until(is_frame(4))
        worker = own.solver.worker
        assert worker is not None
        kill(daemon_of(worker))
        assert own.finished(job).frames == 24
        assert own.solver.worker == worker
        (note,) = own.notes(job)
        assert note.code == ProblemCode.DAEMON_RESTARTED
        assert "SIGKILL" in note.message
        keys = [frame.key for frame in own.frames(job).values()]
    assert contents(tmp_path, keys) == contents(foreground, keys)


def test_a_worker_that_dies_three_times_in_a_row_ends_its_jobs_with_a_sentence(tmp_path: Path, binary: Path) -> None:
    (tmp_path / "msgpack.py").write_text("import sys; sys.exit('this is no Lappet')")
    solver = BackgroundSolver(store=tmp_path / "store", path=[str(tmp_path)])
    own = Owner(solver)
    job = solver.manifest(small_procedure(), SETTINGS)
    assert not own.finished(job).cancelled
    (refused,) = own.of(Refused, job)
    assert "3 times in a row" in refused.problems[0].message
    assert "this is no Lappet" in refused.problems[0].message
    assert len(own.notes(job)) == 2
    assert solver.running == ()
    solver.close(wait=5.0)


def test_a_procedure_that_cannot_be_solved_is_refused_with_its_sentences(tmp_path: Path, binary: Path) -> None:
    hook = Hook("hook", (0.0, 90.0, TOP), ((1.0, (0.0, 0.0, 9.0)),), 1.0, 3.0)
    excised = small_procedure(events=(Incision("slit", 2.0, ((50.0, 0.0, TOP), (60.0, 0.0, TOP))),))
    with owner(tmp_path) as own:
        for procedure, path in ((small_procedure(events=(hook,)), "hook"), (excised, "slit")):
            job = own.solver.solve(procedure, SETTINGS)
            assert own.finished(job).frames == 0
            (refused,) = own.of(Refused, job)
            assert f"/Procedure/Timeline/{path}" in [problem.prim for problem in refused.problems]
            assert all(problem.message for problem in refused.problems)
            assert not own.of(Listed, job)
        job = own.solver.solve(small_procedure(), SolverSettings(spacing=-1.0))
        own.finished(job)
        (refused,) = own.of(Refused, job)
        assert "-1" in refused.problems[0].message
        assert own.finished(own.solver.solve(small_procedure(), SETTINGS)).frames == 8


def test_a_frame_that_cannot_converge_fails_with_its_reason(tmp_path: Path, binary: Path) -> None:
    far = Hook("hook", (0.0, 2.0, TOP), ((3.0, (0.0, 2.0, TOP)), (4.0, (0.0, 2.0, 1e6))), 3.0, 7.0)
    with owner(tmp_path) as own:
        job = own.solver.solve(small_procedure(events=(far,)), SETTINGS)
        assert own.finished(job).frames == 3
        (failed,) = own.of(FrameFailed, job)
        assert failed.time == 4
        assert "Frame 4" in str(failed.problem)


def test_without_a_daemon_the_refusal_says_so(tmp_path: Path) -> None:
    with owner(tmp_path, MISSING) as own:
        job = own.solver.manifest(small_procedure(), SETTINGS)
        own.finished(job)
        (refused,) = own.of(Refused, job)
        assert str(MISSING) in refused.problems[0].message


def test_a_store_that_cannot_be_written_costs_a_note_and_no_frame(tmp_path: Path, binary: Path) -> None:
    (tmp_path / "file").write_text("no folder")
    with owner(tmp_path / "file" / "store") as own:
        job = own.solver.solve(small_procedure(), SETTINGS)
        assert own.finished(job).frames == 8
        (note,) = own.notes(job)
        assert (note.code, note.severity) == (ProblemCode.STORE_NOT_WRITABLE, "warning")
        assert all(frame.frame is not None for frame in own.frames(job).values())
        # What is not on the disk the worker remembers, and tells it whole.
        again = own.solver.solve(small_procedure(), SETTINGS)
        own.finished(again)
        frames = own.frames(again)
        assert all(frame.looked_up and frame.frame is not None for frame in frames.values())
        for time_code, frame in own.frames(job).items():
            told = frames[time_code].frame
            assert frame.frame is not None
            assert told is not None
            assert told.points.tobytes() == frame.frame.points.tobytes()


OWNER = """
import json, sys, time
sys.path[:0] = json.loads(sys.argv[1])
from pathlib import Path
from lappet.background.worker_events import FrameReady
from lappet.background.solver import BackgroundSolver
from background_owner import SETTINGS, daemon_of, long_procedure
solver = BackgroundSolver(store=Path(sys.argv[2]))
job = solver.solve(long_procedure(400), SETTINGS)
while not any(isinstance(each, FrameReady) for each in solver.poll()):
    time.sleep(0.005)
print(solver.worker, daemon_of(solver.worker), flush=True)
time.sleep(60)
"""


def test_worker_and_daemon_end_with_their_owner(tmp_path: Path, binary: Path) -> None:
    folders = json.dumps([folder for folder in sys.path if folder])
    with subprocess.Popen(
        [sys.executable, "-c", OWNER, folders, str(tmp_path)], stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        worker, daemon = map(int, process.stdout.readline().split())
        assert alive(worker)
        assert alive(daemon)
        process.kill()
    wait_gone(worker)
    wait_gone(daemon)


def test_closing_ends_worker_and_daemon_in_the_middle_of_a_solve(tmp_path: Path, binary: Path) -> None:
    with owner(tmp_path) as own:
        own.solver.solve(long_procedure(400), SETTINGS)
        own.until(is_frame(2))
        worker = own.solver.worker
        assert worker is not None
        daemon = daemon_of(worker)
        begun = time.perf_counter()
        own.solver.close()
        assert time.perf_counter() - begun < 0.05
        wait_gone(worker)
        wait_gone(daemon)


def test_an_error_of_our_own_ends_the_job_and_not_the_worker(tmp_path: Path, binary: Path) -> None:
    broken = replace(small_procedure(), events=("no event",))
    with owner(tmp_path) as own:
        job = own.solver.manifest(broken, SETTINGS)
        own.finished(job)
        (refused,) = own.of(Refused, job)
        assert "error of Lappet's own" in refused.problems[0].message
        worker = own.solver.worker
        assert own.finished(own.solver.solve(small_procedure(), SETTINGS)).frames == 8
        assert own.solver.worker == worker
