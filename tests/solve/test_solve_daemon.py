"""The solve against the real daemon: resumed, killed and interrupted solves give the very frames of an undisturbed
one."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lappet.core.problem import Problem
from lappet.core.problem_code import ProblemCode
from lappet.core.value_codec import pack
from lappet.daemon.frame_diagnostics import Diagnostics
from lappet.daemon.frame_solver import Iteration
from lappet.daemon.solved_frame import SolvedFrame
from lappet.output.solve_to_cache import SolveResult, solve_procedure
from lappet.solve.solve_frames import SolveObserver
from lappet.solve.store import FrameStore
from lappet.usd.stage import write_procedure
from small_procedure import small_procedure

pytestmark = pytest.mark.slow


def daemons() -> list[int]:
    """The processes of daemons that this process started."""
    found = []
    for status in Path("/proc").glob("[0-9]*/status"):
        try:
            lines = dict(line.split(":\t", 1) for line in status.read_text().splitlines() if ":\t" in line)
        except OSError:
            continue
        if int(lines["PPid"]) == os.getpid() and "solverd" in lines["Name"] and not lines["State"].startswith("Z"):
            found.append(int(status.parent.name))
    return found


class DuringFrame(SolveObserver):
    """Does something once, at the first Newton iteration of a frame that the daemon tells of."""

    def __init__(self, time: float, signal_daemon: int | None) -> None:
        self._time = time
        self._signal = signal_daemon
        self.notes: list[Problem] = []
        self.done = False

    def iteration(self, iteration: Iteration) -> None:
        if self.done or iteration.time != self._time:
            return
        self.done = True
        if self._signal is None:
            raise KeyboardInterrupt
        for process in daemons():
            os.kill(process, self._signal)

    def note(self, note: Problem) -> None:
        self.notes.append(note)


def solved(folder: Path, store: Path, observer: SolveObserver | None = None) -> SolveResult:
    return solve_procedure(small_procedure(), folder / "c.usdc", store=FrameStore(store), observer=observer)


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> tuple[SolveResult, Path]:
    folder = tmp_path_factory.mktemp("undisturbed")
    result = solved(folder, folder / "store")
    assert result.reason is None
    return result, folder / "store"


def stored(result: SolveResult, store: Path) -> list[SolvedFrame]:
    frames = [FrameStore(store).get(frame.key, SolvedFrame) for frame in result.frames]
    assert None not in frames
    return [frame for frame in frames if frame is not None]


def bit_for_bit(a: list[SolvedFrame], b: list[SolvedFrame]) -> bool:
    def content(frame: SolvedFrame) -> bytes:
        return pack(replace(frame, diagnostics=Diagnostics(converged=True), lattice=None))  # without times

    return [content(frame) for frame in a] == [content(frame) for frame in b]


def test_every_frame_converges_and_the_suture_closes_the_slit(undisturbed: tuple[SolveResult, Path]) -> None:
    result, _ = undisturbed
    assert result.solved == 8
    for frame in result.frames:
        assert frame.solved.diagnostics.residual <= 1e-3
        assert frame.solved.diagnostics.inverted_cells == 0
        assert frame.solved.suture_gaps.max(initial=0.0) <= 1e-3 + 1e-6
    ends = result.frames[-1].solved.suture_points[0]
    assert np.linalg.norm(ends[0] - ends[1]) <= 2e-3
    pulled = result.frames[5].solved.points
    assert pulled[:, 2].max() > 2.1


def test_a_resumed_solve_gives_the_very_same_bits(undisturbed: tuple[SolveResult, Path], tmp_path: Path) -> None:
    result, store = undisturbed
    copy = FrameStore(tmp_path / "store")
    before = stored(result, store)
    for frame, content in zip(result.frames[:5], before[:5], strict=True):
        copy.put(frame.key, content)
    again = solved(tmp_path, copy.folder)
    assert (again.solved, again.looked_up) == (3, 5)
    assert bit_for_bit(stored(again, copy.folder), before)


def test_a_killed_daemon_is_replaced_and_the_frames_are_the_very_same(
    undisturbed: tuple[SolveResult, Path], tmp_path: Path
) -> None:
    result, store = undisturbed
    killer = DuringFrame(6.0, signal.SIGKILL)
    again = solved(tmp_path, tmp_path / "store", killer)
    assert killer.done
    assert again.complete
    # On a busy machine frame 6 may be on its way already when the signal comes.
    (note,) = killer.notes
    assert note.code == ProblemCode.DAEMON_RESTARTED
    assert "SIGKILL" in note.message
    assert note.value in ("6", "7")
    assert bit_for_bit(stored(again, tmp_path / "store"), stored(result, store))
    assert daemons() == []


def test_an_interrupted_solve_keeps_its_frames_and_leaves_no_daemon(
    undisturbed: tuple[SolveResult, Path], tmp_path: Path
) -> None:
    result, store = undisturbed
    stopped = solved(tmp_path, tmp_path / "store", DuringFrame(6.0, None))
    assert stopped.interrupted
    assert [frame.constraints.time for frame in stopped.frames] == [1, 2, 3, 4, 5]
    assert (tmp_path / "c.usdc").is_file()
    assert daemons() == []
    finished = solved(tmp_path, tmp_path / "store")
    assert (finished.solved, finished.looked_up) == (3, 5)
    assert bit_for_bit(stored(finished, tmp_path / "store"), stored(result, store))


def test_ctrl_c_at_the_command_line_writes_the_cache_and_exits_with_1(tmp_path: Path) -> None:
    from pxr import Usd

    write_procedure(small_procedure(), tmp_path / "p.usda")
    process = subprocess.Popen(
        [sys.executable, "-m", "lappet", "solve", "p.usda", "-o", "c.usdc", "--spacing", "0.5", "--store", "store"],
        cwd=tmp_path,
        stderr=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )
    with process:
        assert process.stderr is not None
        lines = []
        for line in process.stderr:
            lines.append(line)
            if line.startswith("frame 4"):
                process.send_signal(signal.SIGINT)
    assert process.returncode == 1, "".join(lines)
    assert "Traceback" not in "".join(lines)
    stopped = re.search(r"Stopped: ([4-7]) of 8 frames are done\.", "".join(lines))  # a busy machine hears it late
    assert stopped, "".join(lines)
    assert Usd.Stage.Open(str(tmp_path / "c.usdc")).GetEndTimeCode() == int(stopped[1])
