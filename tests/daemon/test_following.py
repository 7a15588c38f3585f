"""Others follow what an author solves with a shared daemon: the same bits, from where they came in, by role."""

from __future__ import annotations

import re
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from keyed_daemon import until
from lappet.commands.cli import cli
from lappet.core.problem import RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.core.value_codec import pack
from lappet.daemon.client import DaemonRefuses, SolverClient, SolverRefused
from lappet.daemon.key_files import new_pair
from lappet.daemon.running_daemon import ClientKeys, RunningDaemon
from lappet.output.follow_to_cache import follow_procedure
from lappet.output.solve_to_cache import SolveResult, solve_procedure
from lappet.program.settings import SolverSettings
from lappet.solve.solve_frames import FrameResult, SolveObserver
from lappet.solve.store import FrameStore
from lappet.tissue.patch import flat_patch
from lappet.usd.stage import write_procedure
from shared_daemon import SharedDaemon
from small_procedure import TOP, small_procedure

pytestmark = [pytest.mark.slow, pytest.mark.timeout(180)]
KNOWN_BYTES = 65_536  # what a follower may send; they are sent more


@pytest.fixture
def shared(binary: Path, tmp_path: Path) -> Iterator[SharedDaemon]:
    with SharedDaemon(binary, tmp_path) as daemon:
        yield daemon


@pytest.fixture
def procedure(tmp_path: Path) -> Path:
    """A skin so fine that one frame is more than a follower may send."""
    path = tmp_path / "flap.usda"
    write_procedure(small_procedure(tissue=flat_patch((24.0, 16.0, TOP), resolution=0.5, spacing=1.0)), path)
    return path


class Author(SolveObserver):
    """Solves on a thread of its own, and before one of its frames waits until somebody follows."""

    def __init__(self, daemon: SharedDaemon, user: RunningDaemon, procedure: Path, **options: Any) -> None:
        self.daemon, self.user, self.procedure = daemon, user, procedure
        self.options = {"share": 0.0, "error_estimate": False, "waits_at": 1, **options}
        self.waits_at = self.options.pop("waits_at")
        self.session = 0
        self.has_shared = threading.Event()
        self.result: SolveResult | None = None
        self.done = 0
        self.thread = threading.Thread(target=self._solve)

    def _solve(self) -> None:
        folder = self.procedure.parent
        store = FrameStore(folder / "store")
        self.result = solve_procedure(
            self.procedure, folder / "a.usdc", daemon=self.user, store=store, observer=self, **self.options
        )

    def shared(self, session: int) -> None:
        self.session = session
        if self.waits_at == 1:
            self._wait()

    def frame(self, frame: FrameResult) -> None:
        self.done += 1
        if self.done + 1 == self.waits_at:
            self._wait()

    def _wait(self) -> None:
        self.has_shared.set()
        assert until(lambda: f" follows session {self.session}" in self.daemon.log.read_text(), 60.0)

    def __enter__(self) -> Author:
        self.thread.start()
        assert self.has_shared.wait(60.0)
        return self

    def __exit__(self, *_: object) -> None:
        self.thread.join(120.0)

    def frames(self) -> list[FrameResult]:
        assert self.result is not None
        assert self.result.reason is None
        return list(self.result.frames)


def bits(frames: list[FrameResult]) -> list[tuple[bytes, str]]:
    return [(pack(frame.solved), frame.key) for frame in frames]


def test_a_follower_gets_every_bit_of_what_an_author_solves(shared: SharedDaemon, procedure: Path) -> None:
    anna, fred = shared.user("anna", "author"), shared.user("fred", "follower")
    cache = procedure.with_name("f.usdc")
    with Author(shared, anna, procedure) as author:
        followed = follow_procedure(procedure, cache, fred, author.session)
    assert followed.complete
    assert len(followed.frames) == 8
    assert sum(array.nbytes for array in followed.frames[-1].solved.arrays().values()) > KNOWN_BYTES
    assert bits(list(followed.frames)) == bits(author.frames())
    assert cache.read_bytes() == procedure.with_name("a.usdc").read_bytes()


def test_a_follower_who_comes_late_gets_the_rest_and_is_told_so(shared: SharedDaemon, procedure: Path) -> None:
    """The estimate's coarse solve, a session of its own, is not seen."""
    anna, fred = shared.user("anna", "author"), shared.user("fred", "follower")
    with Author(shared, anna, procedure, waits_at=5, error_estimate=True) as author:
        followed = follow_procedure(procedure, procedure.with_name("f.usdc"), fred, author.session)
    assert [frame.constraints.time for frame in followed.frames] == [5.0, 6.0, 7.0, 8.0]
    assert not followed.complete
    assert followed.reason is not None
    assert (followed.reason.code, followed.reason.value) == (ProblemCode.FOLLOWED_PART, "4")
    for mine, theirs in zip(followed.frames, author.frames()[4:], strict=True):
        assert mine.solved.points.tobytes() == theirs.solved.points.tobytes()
        assert mine.solved.suture_forces.tobytes() == theirs.solved.suture_forces.tobytes()


def test_without_sharing_a_session_is_its_author_s_alone(shared: SharedDaemon, procedure: Path) -> None:
    anna, fred = shared.user("anna", "author"), shared.user("fred", "follower")
    with SolverClient(anna.address, keys=anna.keys()) as client:
        session = client.open(SolverSettings(spacing=1.0, threads=1))
        for number in (session, session + 1):  # one that is not hers to know of, and one that is not there, look alike
            with pytest.raises(SolverRefused) as error:
                follow_procedure(procedure, procedure.with_name("f.usdc"), fred, number)
            assert error.value.problems[0].code == ProblemCode.SOLVER_OUT_OF_ORDER
            assert f"no session {number} that fred may follow" in str(error.value)
    assert not procedure.with_name("f.usdc").exists()


def test_who_is_no_user_follows_nobody_and_a_follower_shares_nothing(shared: SharedDaemon, procedure: Path) -> None:
    fred = shared.user("fred", "follower")
    keys = fred.keys()
    assert keys is not None
    with (
        pytest.raises(DaemonRefuses) as error,
        SolverClient(fred.address, keys=ClientKeys(keys.server, new_pair())),
    ):
        pass
    assert error.value.problems[0].code == ProblemCode.DAEMON_KEY_UNKNOWN
    with pytest.raises(RefusedError) as refused:
        solve_procedure(procedure, procedure.with_name("f.usdc"), daemon=fred, share=0.0, store=store_beside(procedure))
    assert refused.value.problems[0].code == ProblemCode.SOLVER_UNAUTHORIZED
    assert "author" in str(refused.value)


def test_a_session_of_another_procedure_is_refused(shared: SharedDaemon, procedure: Path) -> None:
    anna, fred = shared.user("anna", "author"), shared.user("fred", "follower")
    other = procedure.with_name("other.usda")
    write_procedure(small_procedure(), other)
    with Author(shared, anna, procedure) as author, pytest.raises(RefusedError) as error:
        follow_procedure(other, procedure.with_name("f.usdc"), fred, author.session)
    assert error.value.problems[0].code == ProblemCode.FOLLOWED_OTHER
    assert len(author.frames()) == 8  # whoever leaves holds up nobody


def test_the_command_line_shares_and_follows(shared: SharedDaemon, procedure: Path) -> None:
    anna, fred = shared.user("anna", "author"), shared.user("fred", "follower")
    mine, theirs = procedure.with_name("a.usdc"), procedure.with_name("f.usdc")
    options = ["--no-error-estimate", "--share", "5", "--store", procedure.with_name("store")]
    with command("solve", procedure, "-o", mine, *options, daemon=anna) as author:
        assert author.stderr is not None
        lines = []
        while "is shared" not in "".join(lines):
            lines.append(author.stderr.readline())
            assert lines[-1], lines
        told = re.fullmatch(r"session (\d+) is shared: lappet follow PROCEDURE \1\n", lines[-1])
        assert told is not None, lines
        with command("follow", procedure, told[1], "-o", theirs, daemon=fred) as follower:
            said, errors = follower.communicate(timeout=120.0)
        assert author.communicate(timeout=120.0)[0].startswith("8 frames done")
    assert (author.returncode, follower.returncode) == (0, 0), errors
    assert said.startswith("8 frames followed")
    assert theirs.read_bytes() == mine.read_bytes()


def test_sharing_and_following_need_somebody_s_daemon(procedure: Path) -> None:
    for command in (["solve", str(procedure), "--share", "0"], ["follow", str(procedure), "1"]):
        done = CliRunner().invoke(cli, command)
        assert done.exit_code == 2
        assert "--daemon" in done.output


def command(*arguments: object, daemon: RunningDaemon) -> subprocess.Popen[str]:
    options = ["--daemon", daemon.address, "--server-key", daemon.server_key, "--key", daemon.key]
    return subprocess.Popen(
        [sys.executable, "-m", "lappet", *map(str, arguments), *options],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def store_beside(procedure: Path) -> FrameStore:
    return FrameStore(procedure.with_name("store"))
