"""Take in what the worker tells: schedules, frames, refusals, ends of jobs."""

from __future__ import annotations

import math
import time

from lappet.background.worker_events import (
    Finished,
    FrameFailed,
    FrameReady,
    IterationDone,
    LiveFrame,
    Note,
    Refused,
    Scheduled,
    WorkerEvent,
)
from lappet.daemon.solved_frame import SolvedFrame

from .controller import Controller, Failure, Job, frame_at, frame_cache, schedules
from .reconcile import activate_schedule, request_schedule, stop_obsolete
from .speed_estimate import speed_estimate


def handle_worker_events(controller: Controller) -> bool:
    """Apply what has come from the worker since the last call; whether there was anything."""
    if controller.client is None:
        return False
    events = controller.client.poll()
    for event in events:
        _apply(controller, event)
    return bool(events)


def _apply(controller: Controller, event: WorkerEvent) -> None:
    if isinstance(event, Note):
        controller.note(event.sentence)
        return
    job = next((job for job in controller.jobs() if job.number == event.job), None)
    if job is None:
        return  # of a job that nobody waits for any more; its frames are in the store
    match event:
        case Scheduled():
            _scheduled(controller, job, event)
        case Refused():
            schedules.refuse(job.key, event.problems)
            if job.key == controller.key:
                controller.refused = event.problems
            controller.notify()
        case IterationDone():
            if not math.isclose(job.time, event.time):
                job.frame_started = time.monotonic()
            job.time, job.newton, job.residual = event.time, event.newton, event.residual
        case FrameReady():
            _ready(controller, job, event)
        case FrameFailed():
            _failed(controller, job, event)
        case LiveFrame():
            _live(controller, event)
        case Finished():
            _finished(controller, job, event)


def _scheduled(controller: Controller, job: Job, scheduled: Scheduled) -> None:
    schedule = schedules.keep(scheduled.schedule, job.key)
    job.schedule = schedule
    job.total = sum(1 for frame in schedule.frames if job.until is None or frame.time <= job.until)
    controller.known.update(frame.key for frame, there in zip(schedule.frames, scheduled.known, strict=True) if there)
    if job.key == controller.key:
        controller.schedule = schedule
        controller.refused = ()
        activate_schedule(controller)
    controller.notify()


def _ready(controller: Controller, job: Job, ready: FrameReady) -> None:
    job.done += 1
    controller.known.add(ready.key)
    schedules.failures.pop(ready.key, None)
    now = time.monotonic()
    if not ready.looked_up:
        job.solved += 1
        job.frame_seconds.append(now - job.frame_started)
        if ready.frame is not None:
            _learn(controller, ready.frame)
    if ready.frame is not None:
        frame_cache.put(ready.key, ready.frame)
    job.frame_started, job.time, job.newton = now, math.nan, 0
    stop_obsolete(controller)
    controller.notify()


def _learn(controller: Controller, frame: SolvedFrame) -> None:
    cells = 0.0 if frame.lattice is None else float(frame.lattice.cells)
    controller.cells = cells or controller.cells
    speed_estimate().measured(cells, frame.diagnostics.seconds.total)


def _failed(controller: Controller, job: Job, failed: FrameFailed) -> None:
    frame = None if job.schedule is None else frame_at(job.schedule, failed.time)
    if frame is not None:
        schedules.failures[frame.key] = failed.problem
    if job.key == controller.key or frame is None:
        controller.failure = Failure(failed.time, failed.problem)
    controller.notify()


def _live(controller: Controller, frame: LiveFrame) -> None:
    live = controller.live
    if live is not None and live.job == frame.job:
        live.frame, live.seconds, live.converged = frame.frame, frame.seconds, frame.converged
        controller.notify()


def _finished(controller: Controller, job: Job, finished: Finished) -> None:
    if controller.scheduling is job:
        controller.scheduling = None
    if controller.job is job:
        controller.job = None
        if job.kind == "live":
            controller.live = None
        else:
            speed_estimate().keep()
        if job.kind == "solve" and job.schedule is not None:
            controller.recheck_frames(job.schedule)
    request_schedule(controller)  # a solve takes the place of a schedule that was being made
    controller.notify()
