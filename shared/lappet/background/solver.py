"""Solving in the background, as a window uses it: ask, and poll now and then for what has happened."""

from __future__ import annotations

import itertools
import queue
import threading
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

from lappet.background.manifest_key import manifest_key
from lappet.background.worker_events import (
    Finished,
    FrameFailed,
    FrameReady,
    IterationDone,
    Listed,
    LiveFrame,
    Note,
    Refused,
    WorkerEvent,
)
from lappet.background.worker_process import WorkerProcess
from lappet.background.worker_requests import Aim, Ask, Cancel, JobKind
from lappet.core.array_codec import CodecError
from lappet.core.problem import Problem, RefusedError, file_problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.daemon.daemon_solver import solver_identity
from lappet.daemon.process import daemon_identity
from lappet.daemon.running_daemon import RunningDaemon
from lappet.procedure import Pose, Procedure
from lappet.program.settings import SolverSettings

_DEATHS = 3  # in a row, then the jobs that were running are given up
_PATIENCE = 5.0

_Work = tuple[Literal["job", "target", "cancel", "restart"], int]


@dataclass(eq=False)
class _Job:
    """A job that has not ended yet. done: times of the frames that were told of."""

    ask: Ask
    begun: float = field(default_factory=time.perf_counter)
    target: Pose | None = None
    target_waits: bool = False
    cancelled: bool = False
    sent: bool = False
    listed: Listed | None = None
    done: dict[int, str] = field(default_factory=dict)


class BackgroundSolver:
    """One worker process; started at the first request, and again when it dies (a Note says so).

    Thread-safe. Every method returns at once: threads of its own start the process, write to it and read from it.

    Parameters
    ----------
    store
        Folder of the frames; None for the user's.
    solverd
        The daemon's program; None to find it.
    path
        What the worker's `sys.path` needs besides its interpreter's own folders.
    daemon
        A daemon that runs already; None to start one where it is needed.
    """

    def __init__(
        self,
        store: Path | None = None,
        solverd: Path | None = None,
        path: Sequence[str] = (),
        daemon: RunningDaemon | None = None,
    ) -> None:
        self._store = None if store is None else Path(store)
        self._solverd = None if solverd is None else Path(solverd)
        self._path = tuple(path)
        self._daemon = daemon
        self._numbers = itertools.count(1)
        self._lock = threading.Lock()
        self._events: list[WorkerEvent] = []
        self._jobs: dict[int, _Job] = {}
        self._process: WorkerProcess | None = None
        self._deaths = 0
        self._closed = False
        self._work: queue.SimpleQueue[_Work | None] = queue.SimpleQueue()
        self._sender: threading.Thread | None = None

    def manifest(self, procedure: Procedure, settings: SolverSettings) -> int:
        """Compile a procedure; `Listed` or `Refused` follows, then `Finished`.

        A newer manifest replaces one that has not begun.

        Parameters
        ----------
        procedure
            The procedure.
        settings
            How to solve.

        Returns
        -------
        int
            Number of the job.
        """
        return self._begin_job("manifest", procedure, settings)

    def solve(self, procedure: Procedure, settings: SolverSettings, until: int | None = None) -> int:
        """Get frames; `Listed` follows, then `FrameReady` for each, then `Finished`.

        Parameters
        ----------
        procedure
            The procedure.
        settings
            How to solve.
        until
            Last time code; None for all.

        Returns
        -------
        int
            Number of the job.
        """
        return self._begin_job("solve", procedure, settings, until=until)

    def live(
        self,
        procedure: Procedure,
        settings: SolverSettings,
        time: int,
        held: str,
        before: Procedure | None = None,
    ) -> int:
        """Open the tissue at a frame for live mode.

        `Listed` follows, then `LiveFrame` until the job is cancelled, then `Finished`. The first `LiveFrame` is for
        the own target of what is held.

        Parameters
        ----------
        procedure
            The procedure.
        settings
            How to solve.
        time
            Time code of the frame.
        held
            Name of the hook or retractor that pulls.
        before
            The procedure without it, where a tool still places it; its frames are where the tissue begins.

        Returns
        -------
        int
            Number of the job.
        """
        return self._begin_job("live", procedure, settings, time=time, held=held, before=before)

    def live_target(self, job: int, target: Pose) -> None:
        """Move what a live job holds; only the latest target counts.

        Parameters
        ----------
        job
            Number of the job.
        target
            Where it is, mm, and how it is turned.
        """
        with self._lock:
            found = self._jobs.get(job)
            if found is None:
                return
            found.target = tuple(float(value) for value in target)
            waits, found.target_waits = found.target_waits, True
        if not waits:
            self._work.put(("target", job))

    def cancel(self, job: int) -> None:
        """End a job at its next Newton iteration; what is done is kept.

        Parameters
        ----------
        job
            Number of the job.
        """
        with self._lock:
            found = self._jobs.get(job)
            if found is None or found.cancelled:
                return
            found.cancelled = True
        self._work.put(("cancel", job))

    def poll(self) -> list[WorkerEvent]:
        """Take what has happened since the last call, without waiting.

        Returns
        -------
        list[WorkerEvent]
            What happened, in order; of iterations and live frames in a row only the last.
        """
        with self._lock:
            happened, self._events = self._events, []
        return happened

    def close(self, wait: float = 0.0) -> None:
        """End the worker and its daemons.

        Parameters
        ----------
        wait
            Seconds until they must have ended; 0: they end by themselves.
        """
        with self._lock:
            self._closed = True
            sender = self._sender
        self._work.put(None)
        if wait > 0.0 and sender is not None:
            sender.join(wait)

    @property
    def running(self) -> tuple[int, ...]:
        """The jobs that have not ended."""
        with self._lock:
            return tuple(self._jobs)

    @property
    def worker(self) -> int | None:
        """The process id of the worker, or None when none runs."""
        with self._lock:
            return None if self._process is None else self._process.pid

    @property
    def identity(self) -> str:
        """What tells this solver from another (`manifest_key`); a daemon that runs already is asked."""
        return daemon_identity(self._solverd) if self._daemon is None else solver_identity(self._daemon)

    def key(self, procedure: Procedure, settings: SolverSettings) -> str:
        """Compute the key of the manifest that this solver makes of a procedure.

        Parameters
        ----------
        procedure
            The procedure.
        settings
            How to solve.

        Returns
        -------
        str
            The key.
        """
        return manifest_key(procedure, settings, self.identity)

    def _begin_job(self, kind: JobKind, procedure: Procedure, settings: SolverSettings, **more: Any) -> int:
        with self._lock:
            if self._closed:
                raise RuntimeError("The background solver is closed; make another one.")
            number = next(self._numbers)
            self._jobs[number] = _Job(Ask(number, kind, procedure, settings, **more))
            if self._sender is None:
                self._sender = threading.Thread(target=self._send_all, name="lappet-worker-sender", daemon=True)
                self._sender.start()
        self._work.put(("job", number))
        return number

    # On the sending thread: it alone starts the process and writes to it.

    def _send_all(self) -> None:
        while (work := self._work.get()) is not None:
            try:
                self._send(*work)
            except CodecError as error:
                self._give_up(error.problems[0], (work[1],))
            except RefusedError as error:
                self._give_up(error.problems[0])
            except OSError as error:
                self._give_up(file_problem(error))
        with self._lock:
            process, self._process = self._process, None
        if process is not None:
            process.stop(_PATIENCE)

    def _send(self, kind: str, number: int) -> None:
        with self._lock:
            job = self._jobs.get(number)
            process = self._process
            if job is None and kind != "restart":
                return
            if process is None and not self._closed:
                waiting = [each for each in self._jobs.values() if each.sent or each is job]
            else:
                waiting = [job] if kind == "job" and job is not None and not job.sent else []
        if process is None:
            if not waiting:
                return
            process = WorkerProcess(self._store, self._solverd, self._path, self._hear, self._ended)
            with self._lock:
                self._process = process
        for each in waiting:
            self._begin(process, each)
        if job is not None and kind == "cancel":
            process.send(Cancel(number))
        elif job is not None and kind == "target":
            self._aim(process, job)

    def _begin(self, process: WorkerProcess, job: _Job) -> None:
        identity = None
        if self._daemon is None:  # else the worker asks it, which may take long
            with suppress(RefusedError, OSError):  # the worker says what is wrong
                identity = self.identity
        with self._lock:
            job.sent = True
        process.send(replace(job.ask, identity=identity, daemon=self._daemon))
        if job.target is not None:
            self._aim(process, job)
        if job.cancelled:
            process.send(Cancel(job.ask.job))

    def _aim(self, process: WorkerProcess, job: _Job) -> None:
        with self._lock:
            target, job.target_waits = job.target, False
        if target is not None:
            process.send(Aim(job.ask.job, target))

    # On the thread that reads from the process.

    def _hear(self, event: WorkerEvent) -> None:
        with self._lock:
            job = self._jobs.get(event.job)
            if job is None:
                return
            if isinstance(event, Listed):
                if job.listed is not None:
                    return  # said again after the worker died
                job.listed = event
            elif isinstance(event, FrameReady):
                self._deaths = 0
                if job.done.get(event.time) == event.key:
                    return
                job.done[event.time] = event.key
            elif isinstance(event, LiveFrame):
                self._deaths = 0
            elif isinstance(event, Finished):
                self._deaths = 0
                del self._jobs[event.job]
            self._tell(event)

    def _tell(self, event: WorkerEvent) -> None:
        last = self._events[-1] if self._events else None
        if isinstance(event, IterationDone | LiveFrame) and type(last) is type(event) and (last.job == event.job):
            self._events[-1] = event
        else:
            self._events.append(event)

    def _ended(self, process: WorkerProcess) -> None:
        how = process.death()
        with self._lock:
            if self._process is not process:
                return
            self._process = None
            if self._closed or not any(job.sent for job in self._jobs.values()):
                return
            self._deaths += 1
            if self._deaths < _DEATHS:
                first = min(number for number, job in self._jobs.items() if job.sent)
                self._tell(Note(first, problem(ProblemCode.BACKGROUND_RESTARTED, "", how)))
        if self._deaths < _DEATHS:
            self._work.put(("restart", 0))
        else:
            self._give_up(problem(ProblemCode.BACKGROUND_DIES, "", _DEATHS, how=how))

    def _give_up(self, why: Problem, numbers: Sequence[int] | None = None) -> None:
        """End these jobs, or all of them, with what is wrong."""
        with self._lock:
            self._deaths = 0
            for job in [job for number, job in self._jobs.items() if numbers is None or number in numbers]:
                if job.cancelled:
                    pass
                elif job.listed is None:
                    self._tell(Refused(job.ask.job, (why,)))
                else:
                    self._tell(FrameFailed(job.ask.job, _next_time(job), why))
                seconds = time.perf_counter() - job.begun
                self._tell(Finished(job.ask.job, len(job.done), seconds, job.cancelled))
                del self._jobs[job.ask.job]


def _next_time(job: _Job) -> int:
    """The frame that a job was at."""
    if job.ask.kind == "live":
        return job.ask.time
    assert job.listed is not None
    times = [frame.time for frame in job.listed.manifest.frames]
    return next((time for time in times if time not in job.done), times[-1])
