"""A background solver without a process: it lists and solves frames by formulas, a step at a poll, as tests want it.

A frame's key hashes the frame before it and the events that have begun, as the keys of real frames do; its points are
its epoch's, lifted by the number of frames before it plus that of the events.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from lappet.background.assessment import Assessment
from lappet.background.manifest import EpochShape, ListedFrame, Manifest
from lappet.background.manifest_key import digest, manifest_key
from lappet.background.manifest_store import put_manifest
from lappet.background.worker_events import (
    Assessed,
    Finished,
    FrameFailed,
    FrameReady,
    IterationDone,
    Listed,
    LiveFrame,
    Refused,
    WorkerEvent,
)
from lappet.core.problem import Problem
from lappet.core.problem_code import ProblemCode
from lappet.daemon.frame_diagnostics import Diagnostics, StageSeconds
from lappet.daemon.lattice_counts import LatticeCounts
from lappet.daemon.running_daemon import RunningDaemon
from lappet.daemon.solved_frame import SolvedFrame
from lappet.procedure import CUTS, Event, Hook, Landmark, Pose, Procedure, place_of, pose_at
from lappet.program.settings import SolverSettings
from lappet.solve.store import FrameStore

IDENTITY = "fake"


@dataclass
class Script:
    """What all fake workers of a test do. asked: (kind, manifest key) of every request. held: nothing goes on. refusal:
    of every procedure. failing: frames that fail, with the reason."""

    asked: list[tuple[str, str]] = field(default_factory=list)
    held: bool = False
    refusal: tuple[Problem, ...] = ()
    suspicious: tuple[Problem, ...] = ()
    assessment: Assessment | None = None
    failing: dict[int, str] = field(default_factory=dict)
    workers: list[FakeWorker] = field(default_factory=list)
    points: int = 4

    def create(self, store: Path, daemon: RunningDaemon | None = None) -> FakeWorker:
        """In place of `lappet_blender.solving.workers.create`."""
        worker = FakeWorker(self, FrameStore(store))
        worker.daemon = daemon
        self.workers.append(worker)
        return worker

    def count(self, kind: str) -> int:
        """How many requests of a kind there were."""
        return sum(1 for asked, _ in self.asked if asked == kind)


class FakeWorker:
    """The methods of `lappet.background.solver.BackgroundSolver`."""

    def __init__(self, script: Script, store: FrameStore) -> None:
        self.script = script
        self.store = store
        self.closed = False
        self.daemon: RunningDaemon | None = None
        self.targets: list[Pose] = []
        self.cancelled: set[int] = set()
        self._number = 0
        self._jobs: dict[int, Iterator[WorkerEvent]] = {}

    def manifest(self, procedure: Procedure, settings: SolverSettings) -> int:
        return self._ask("manifest", procedure, settings, self._listing)

    def solve(self, procedure: Procedure, settings: SolverSettings, until: int | None = None) -> int:
        return self._ask("solve", procedure, settings, lambda job, p, s: self._solving(job, p, s, until))

    def live(
        self, procedure: Procedure, settings: SolverSettings, time: int, held: str, before: Procedure | None = None
    ) -> int:
        self.targets.clear()
        return self._ask("live", procedure, settings, lambda job, p, s: self._pulling(job, p, s, time))

    def live_target(self, job: int, target: Pose) -> None:
        self.targets.append(target)

    def cancel(self, job: int) -> None:
        self.cancelled.add(job)

    def close(self, wait: float = 0.0) -> None:
        self.closed = True
        self._jobs.clear()

    def poll(self) -> list[WorkerEvent]:
        """The next step of every job."""
        if self.script.held:
            return []
        happened = []
        for number, steps in list(self._jobs.items()):
            event = next(steps)
            happened.append(event)
            if isinstance(event, Finished):
                del self._jobs[number]
        return happened

    def _ask(self, kind, procedure, settings, steps) -> int:  # type: ignore[no-untyped-def]
        assert not self.closed, "a closed worker was asked"
        self._number += 1
        self.script.asked.append((kind, manifest_key(procedure, settings, IDENTITY)))
        self._jobs[self._number] = self._guarded(self._number, steps(self._number, procedure, settings))
        return self._number

    def _guarded(self, job: int, steps: Iterator[WorkerEvent]) -> Iterator[WorkerEvent]:
        frames = 0
        for step in steps:
            if job in self.cancelled:
                break
            frames += isinstance(step, FrameReady)
            yield step
        yield Finished(job, frames, 0.1, job in self.cancelled)

    def _listing(self, job: int, procedure: Procedure, settings: SolverSettings) -> Iterator[WorkerEvent]:
        if self.script.refusal:
            yield Refused(job, self.script.refusal)
            return
        manifest = replace(make_manifest(procedure, settings, self.script.points), notes=self.script.suspicious)
        put_manifest(self.store, manifest)
        yield Listed(job, manifest, tuple(frame.key in self.store for frame in manifest.frames))

    def _solving(
        self, job: int, procedure: Procedure, settings: SolverSettings, until: int | None
    ) -> Iterator[WorkerEvent]:
        yield from self._listing(job, procedure, settings)
        if self.script.refusal:
            return
        manifest = make_manifest(procedure, settings, self.script.points)
        for index, frame in enumerate(manifest.frames):
            if until is not None and frame.time > until:
                return
            if frame.key in self.store:
                yield FrameReady(job, frame.time, frame.key, True, None)
                continue
            yield IterationDone(job, frame.time, 1, 1e-2, 0.0)
            if frame.time in self.script.failing:
                reason = self.script.failing[frame.time]
                yield FrameFailed(job, frame.time, Problem(ProblemCode.FRAME_NOT_CONVERGED, "", "", reason, ""))
                return
            shown = solved(manifest, index, len(procedure.events))
            self.store.put(frame.key, shown)
            yield FrameReady(job, frame.time, frame.key, False, shown)
        if self.script.assessment is not None:
            yield Assessed(job, self.script.assessment)

    def _pulling(self, job: int, procedure: Procedure, settings: SolverSettings, time: int) -> Iterator[WorkerEvent]:
        yield from self._listing(job, procedure, settings)
        manifest = make_manifest(procedure, settings, self.script.points)
        rest = manifest.epochs[manifest.frames[time - manifest.frames[0].time].epoch].rest
        target = pose_at(next(e for e in procedure.events if isinstance(e, Hook)).targets[0][1])
        while True:
            target = self.targets[-1] if self.targets else target
            yield LiveFrame(
                job, time, target, SolvedFrame(float(time), rest + np.float32(place_of(target))), None, 0.05
            )


def make_manifest(procedure: Procedure, settings: SolverSettings, points: int = 4) -> Manifest:
    """A manifest whose keys depend on what the frames of a real one depend on."""
    start = procedure.start_time
    cuts = sorted({max(e.time, start) for e in procedure.events if isinstance(e, CUTS)} | {start})
    epochs = tuple(_epoch(time, index, points) for index, time in enumerate(cuts))
    frames, previous = [], repr((settings.tolerance, settings.precision, digest(procedure.tissue)))
    for time in procedure.frames():
        begun = sorted(repr(replace(e, name="")) for e in procedure.events if _begins(e) <= time)
        previous = hashlib.blake2b(f"{previous}{begun}{time}".encode(), digest_size=32).hexdigest()
        frames.append(ListedFrame(time, sum(cut <= time for cut in cuts) - 1, previous))
    return Manifest(
        manifest_key(procedure, settings, IDENTITY), epochs, tuple(frames), landmarks_at=((),) * len(epochs)
    )


def solved(manifest: Manifest, index: int, events: int) -> SolvedFrame:
    """The frame that the fake solver finds."""
    rest = manifest.epochs[manifest.frames[index].epoch].rest
    said = Diagnostics(converged=True, newton=2, seconds=StageSeconds(total=0.6))
    lattice = LatticeCounts(64_000, 1000, 1000, 0, 1331, 1, 125, 0, 0, 1000.0, 1e6, 0.1)
    points = rest + np.float32((0.0, 0.0, index + events))
    return SolvedFrame(float(manifest.frames[index].time), points, diagnostics=said, lattice=lattice)


def _begins(event: Event) -> float:
    if isinstance(event, Landmark):
        return -np.inf
    return event.time if isinstance(event, CUTS) else event.start


def _epoch(time: float, index: int, points: int) -> EpochShape:
    rest = np.zeros((points, 3), np.float32)
    rest[:, 0] = np.arange(points)
    triangles = np.array([(0, 1, 2), (0, 2, 3)], np.int32)
    key = hashlib.blake2b(f"epoch {index} {points}".encode(), digest_size=32).hexdigest()
    n, m = len(rest), len(triangles)
    return EpochShape(
        key,
        time,
        rest,
        triangles,
        np.zeros(m, np.uint8),
        np.zeros((m, 3, 2), np.float32),
        np.zeros(n, np.float32),
        np.zeros(m, np.int32),
    )
