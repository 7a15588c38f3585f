"""An owner of a background solver, as a window is one: asks, polls, and keeps what happened."""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

from lappet.background.solver import BackgroundSolver
from lappet.background.worker_events import Finished, FrameReady, Listed, Note, WorkerEvent
from lappet.core.problem import Problem
from lappet.core.value_codec import pack
from lappet.daemon.frame_diagnostics import Diagnostics
from lappet.daemon.solved_frame import SolvedFrame
from lappet.procedure import Hook, Incision, Procedure
from lappet.program.settings import SolverSettings
from lappet.solve.store import FrameStore
from small_procedure import TOP, small_procedure

Kind = TypeVar("Kind")
SETTINGS = SolverSettings()
WATCHDOG = 90.0


class Owner:
    """happened: everything so far, in order. slowest: seconds of the longest poll."""

    def __init__(self, solver: BackgroundSolver) -> None:
        self.solver = solver
        self.happened: list[WorkerEvent] = []
        self.slowest = 0.0

    def until(self, wanted: Callable[[WorkerEvent], bool]) -> WorkerEvent:
        """Polls until an event is as wanted, and returns it."""
        end = time.monotonic() + WATCHDOG
        while time.monotonic() < end:
            begun = time.perf_counter()
            happened = self.solver.poll()
            self.slowest = max(self.slowest, time.perf_counter() - begun)
            self.happened += happened
            for each in happened:
                if wanted(each):
                    return each
            time.sleep(0.001)
        raise AssertionError(f"it never happened; this did: {[type(each).__name__ for each in self.happened]}")

    def finished(self, job: int) -> Finished:
        """Polls until a job has ended."""
        found = self.until(lambda each: isinstance(each, Finished) and each.job == job)
        assert isinstance(found, Finished)
        return found

    def of(self, kind: type[Kind], job: int) -> list[Kind]:
        """What happened of a kind in a job."""
        return [each for each in self.happened if isinstance(each, kind) and each.job == job]

    def frames(self, job: int) -> dict[int, FrameReady]:
        """The frames of a job by time; each was told once."""
        found = self.of(FrameReady, job)
        times = [frame.time for frame in found]
        assert times == sorted(set(times))
        return {frame.time: frame for frame in found}

    def manifest(self, job: int) -> Listed:
        """What the manifest of a job is; told once."""
        (listed,) = self.of(Listed, job)
        return listed

    def notes(self, job: int) -> list[Problem]:
        """The notes of a job."""
        return [note.problem for note in self.of(Note, job)]


@contextlib.contextmanager
def owner(store: Path, binary: Path | None = None) -> Iterator[Owner]:
    """An owner whose worker and daemons have ended at the end."""
    solver = BackgroundSolver(store=store, solverd=binary)
    try:
        yield Owner(solver)
        worker = solver.worker
    finally:
        solver.close(wait=15.0)
    if worker is not None:
        wait_gone(worker)


def children(parent: int) -> dict[int, str]:
    """The processes that a process started and that live, with their names."""
    found = {}
    for status in Path("/proc").glob("[0-9]*/status"):
        try:
            lines = dict(line.split(":\t", 1) for line in status.read_text().splitlines() if ":\t" in line)
        except OSError:
            continue
        if int(lines["PPid"]) == parent and not lines["State"].startswith("Z"):
            found[int(status.parent.name)] = lines["Name"]
    return found


def daemon_of(worker: int) -> int:
    """The daemon that a worker started, once it has."""
    end = time.monotonic() + WATCHDOG
    while time.monotonic() < end:
        for process, name in children(worker).items():
            if "solverd" in name:
                return process
        time.sleep(0.002)
    raise AssertionError("the worker started no daemon")


def alive(process: int) -> bool:
    """Whether a process runs."""
    try:
        return not Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].startswith(" Z")
    except OSError:
        return False


def wait_gone(process: int, seconds: float = 10.0) -> None:
    """Waits until a process has ended; it must."""
    end = time.monotonic() + seconds
    while alive(process):
        assert time.monotonic() < end, f"process {process} did not end"
        time.sleep(0.01)


def kill(process: int) -> None:
    """kill -9."""
    with contextlib.suppress(ProcessLookupError):
        os.kill(process, 9)


def long_procedure(frames: int = 24) -> Procedure:
    """A slit pulled open by a hook that moves in every frame."""
    samples = tuple((float(t), (0.3 * t * (-1) ** t, 2.0 + 0.1 * t, TOP + 0.1 * t)) for t in range(2, frames + 1))
    return small_procedure(
        events=(
            Incision("slit", 1.0, ((-6.0, 0.0, TOP), (6.0, 0.0, TOP)), kerf=0.1),
            Hook("hook", (0.0, 2.0, TOP), samples, 2.0, 1e6),
        ),
        end_time=float(frames),
    )


def is_frame(time: int) -> Callable[[WorkerEvent], bool]:
    return lambda each: isinstance(each, FrameReady) and each.time == time


def contents(store: Path, keys: list[str]) -> list[bytes]:
    """The frames in a store with their states, but for the times that they took."""
    frames = [FrameStore(store).get(key, SolvedFrame) for key in keys]
    assert all(frame is not None and frame.state is not None for frame in frames)
    plain = Diagnostics(converged=True)
    return [pack(replace(frame, diagnostics=plain, lattice=None)) for frame in frames if frame is not None]
