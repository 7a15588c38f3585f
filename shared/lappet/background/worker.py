"""The worker's process, which `BackgroundSolver` starts: `python -m lappet.background.worker REQUESTS EVENTS [STORE]`.

Requests come through one inherited pipe, events go out through another (`pipes.py`). A thread reads requests; the jobs
to list, solve and follow live each have a thread of their own. The process ends, and its daemons with it, when the
pipe of requests ends.
"""

from __future__ import annotations

import contextlib
import os
import queue
import sys
import threading
import traceback
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from lappet.background.job import Job
from lappet.background.pipes import MAX_BYTES, inherited
from lappet.background.worker_events import Finished, Refused, WorkerEvent
from lappet.background.worker_requests import Aim, Ask, Cancel, WorkerRequest
from lappet.core.array_codec import CodecError
from lappet.core.problem import ProblemsError, problem
from lappet.core.problem_code import ProblemCode
from lappet.core.value_codec import pack, unpack

_PATIENCE = 3.0  # seconds for jobs to close their daemons when the owner is gone
_NICENESS = 5  # so that the window stays lively while all cores solve


def main(arguments: list[str]) -> None:
    """Serve requests until standard input ends; never return.

    Parameters
    ----------
    arguments
        Arguments of the process.
    """
    requests, events = inherited(arguments[0], arguments[1])
    with contextlib.suppress(OSError, AttributeError):
        os.nice(_NICENESS)
    worker = Worker(Path(arguments[2]) if len(arguments) > 2 else None, events)
    with contextlib.suppress(OSError, EOFError, CodecError):
        while True:
            worker.take(unpack(requests.recv_bytes(MAX_BYTES), WorkerRequest))
    worker.end()


class Worker:
    """A worker that takes requests and hands each to the thread of its kind.

    Parameters
    ----------
    store
        Folder of the frames, or None for the user's.
    events
        Pipe to the owner.
    """

    def __init__(self, store: Path | None, events: Connection) -> None:
        self._folder = store
        self._events = events
        self._writing = threading.Lock()
        self._jobs: dict[int, Job] = {}
        self._guard = threading.Lock()
        self._services: tuple[Any, Any] | None = None
        self._serving = threading.Lock()
        self._lanes = {kind: _Lane(kind, self._run) for kind in ("manifest", "solve", "live")}

    def take(self, request: WorkerRequest) -> None:
        """Do what a request asks, without waiting for any job.

        Parameters
        ----------
        request
            The request.
        """
        if isinstance(request, Ask):
            self._begin(Job(request))
            return
        with self._guard:
            job = self._jobs.get(request.job)
        if job is not None and isinstance(request, Cancel):
            job.cancel()
        elif job is not None and isinstance(request, Aim):
            job.aim(request.target)

    def _begin(self, job: Job) -> None:
        with self._guard:
            for other in self._jobs.values():
                # A manifest that is overtaken before it began is of no use; a solve makes its own.
                overtaken = other.kind == "manifest" and (
                    job.kind == "solve" or (job.kind == "manifest" and not other.running)
                )
                if overtaken or other.kind == job.kind == "live":
                    other.cancel()
            self._jobs[job.number] = job
        self._lanes[job.kind].put(job)

    def _run(self, job: Job) -> None:
        job.running = True
        try:
            solves, lives = self._serve(job.ask)
            (lives if job.kind == "live" else solves).run(job)
        except _Gone:
            pass
        except Exception as error:  # there is nobody to run it: no daemon, or parts that cannot be imported
            traceback.print_exception(error)
            with contextlib.suppress(_Gone):
                own = problem(ProblemCode.BACKGROUND_INTERNAL, "/Procedure", f"{type(error).__name__}: {error}")
                self.tell(Refused(job.number, error.problems if isinstance(error, ProblemsError) else (own,)))
                self.tell(Finished(job.number, 0, 0.0, job.cancelled))
        finally:
            with self._guard:
                self._jobs.pop(job.number, None)

    def _serve(self, ask: Ask) -> tuple[Any, Any]:
        """What runs jobs, loaded at the first one: the process answers at once and imports meanwhile."""
        with self._serving:
            if self._services is None:
                from lappet.background.compilation import Compilation
                from lappet.background.kept_frames import KeptFrames
                from lappet.background.live_job import LiveJobs
                from lappet.background.solve_job import SolveJobs
                from lappet.daemon.daemon_solver import connect_to, solver_identity

                store = KeptFrames(self._folder)
                compilation = Compilation(ask.identity or solver_identity(ask.daemon), store)
                parts = compilation, store, connect_to(ask.daemon), self.tell
                self._services = SolveJobs(*parts), LiveJobs(*parts)
            return self._services

    def tell(self, event: WorkerEvent) -> None:
        """Send an event to the owner.

        Parameters
        ----------
        event
            The event.
        """
        data = pack(event)
        try:
            with self._writing:
                self._events.send_bytes(data)
        except OSError:
            raise _Gone from None

    def end(self) -> None:
        """End all jobs, which end their daemons, and the process; a daemon that is left over sees that it is alone."""
        with self._guard:
            for job in self._jobs.values():
                job.cancel()
        for lane in self._lanes.values():
            lane.end()
        for lane in self._lanes.values():
            lane.join(_PATIENCE)
        os._exit(0)


class _Gone(BaseException):
    """The owner does not read any more."""


class _Lane:
    """A thread that runs jobs one after another."""

    def __init__(self, name: str, run: Callable[[Job], None]) -> None:
        self._run = run
        self._queue: queue.SimpleQueue[Job | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._work, name=f"lappet-{name}", daemon=True)
        self._thread.start()

    def put(self, job: Job) -> None:
        self._queue.put(job)

    def end(self) -> None:
        self._queue.put(None)

    def join(self, seconds: float) -> None:
        self._thread.join(seconds)

    def _work(self) -> None:
        while (job := self._queue.get()) is not None:
            self._run(job)


if __name__ == "__main__":
    main(sys.argv[1:])
