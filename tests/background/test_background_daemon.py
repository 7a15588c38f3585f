"""The background solver with a daemon that runs already: it solves there, with the keys, and starts none of its own."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path

import pytest

from background_owner import SETTINGS, Owner, children
from lappet.background.solver import BackgroundSolver
from lappet.background.worker_events import Refused
from lappet.core.problem_code import ProblemCode
from lappet.daemon.key_files import new_pair
from lappet.daemon.key_writing import new_own
from lappet.daemon.keys_folder import KeysFolder, Role, User
from lappet.daemon.process import SolverDaemon
from lappet.daemon.running_daemon import RunningDaemon
from small_procedure import small_procedure

pytestmark = [pytest.mark.slow, pytest.mark.timeout(120)]


@pytest.fixture
def running(binary: Path, tmp_path: Path) -> Iterator[RunningDaemon]:
    """A daemon with keys, and the key of somebody whom it knows."""
    key, _, own = new_own(tmp_path / "own", "anna")
    with SolverDaemon(binary, listen="tcp://127.0.0.1:0") as daemon:
        assert daemon.keys is not None
        arguments = Path(f"/proc/{daemon.pid}/cmdline").read_text().split("\0")
        KeysFolder(Path(arguments[arguments.index("--keys") + 1])).allow(User("anna", own.public, Role.AUTHOR))
        yield RunningDaemon(daemon.address, daemon.keys.server, str(key))


@contextlib.contextmanager
def owner_with(daemon: RunningDaemon, store: Path) -> Iterator[Owner]:
    solver = BackgroundSolver(store=store, daemon=daemon)
    try:
        yield Owner(solver)
    finally:
        solver.close(wait=15.0)


def test_frames_are_solved_by_the_daemon_that_runs_already(running: RunningDaemon, tmp_path: Path) -> None:
    with owner_with(running, tmp_path / "store") as owner:
        job = owner.solver.solve(small_procedure(), SETTINGS, until=3)
        assert owner.finished(job).frames == 3
        assert owner.manifest(job).manifest.key == owner.solver.key(small_procedure(), SETTINGS)
        worker = owner.solver.worker
        assert worker is not None
        assert not [name for name in children(worker).values() if "solverd" in name]
        assert owner.slowest < 0.5


def test_a_daemon_with_another_key_is_a_problem_of_the_job(running: RunningDaemon, tmp_path: Path) -> None:
    other = RunningDaemon(running.address, new_pair().public, running.key)
    with owner_with(other, tmp_path / "store") as owner:
        job = owner.solver.solve(small_procedure(), SETTINGS, until=1)
        owner.finished(job)
        (refused,) = owner.of(Refused, job)
        assert [each.code for each in refused.problems] == [ProblemCode.DAEMON_OTHER_KEY]
