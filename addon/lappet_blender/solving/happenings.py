"""Takes in what the worker tells: plans, frames, refusals, ends of jobs."""

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
    Planned,
    Refused,
    WorkerEvent,
)
from lappet.daemon.solved_frame import SolvedFrame

from .controller import Controller, Failure, Job, frame_at, pace, plans, shelf
from .reconcile import ask_for_plan, put_in_force, stop_obsolete


def take_in(controller: Controller) -> bool:
    """Applies what has come from the worker since the last call; whether there was anything."""
    if controller.client is None:
        return False
    happenings = controller.client.poll()
    for happening in happenings:
        _apply(controller, happening)
    return bool(happenings)


def _apply(controller: Controller, happening: WorkerEvent) -> None:
    if isinstance(happening, Note):
        controller.note(happening.sentence)
        return
    job = next((job for job in controller.jobs() if job.number == happening.job), None)
    if job is None:
        return  # of a job that nobody waits for any more; its frames are in the store
    match happening:
        case Planned():
            _planned(controller, job, happening)
        case Refused():
            plans.refuse(job.key, happening.problems)
            if job.key == controller.key:
                controller.refused = happening.problems
            controller.bump()
        case IterationDone():
            if not math.isclose(job.time, happening.time):
                job.frame_started = time.monotonic()
            job.time, job.newton, job.residual = happening.time, happening.newton, happening.residual
        case FrameReady():
            _ready(controller, job, happening)
        case FrameFailed():
            _failed(controller, job, happening)
        case LiveFrame():
            _live(controller, happening)
        case Finished():
            _finished(controller, job, happening)


def _planned(controller: Controller, job: Job, planned: Planned) -> None:
    plan = plans.keep(planned.plan, job.key)
    job.plan = plan
    job.total = sum(1 for frame in plan.frames if job.until is None or frame.time <= job.until)
    controller.known.update(frame.key for frame, there in zip(plan.frames, planned.known, strict=True) if there)
    if job.key == controller.key:
        controller.plan = plan
        controller.refused = ()
        put_in_force(controller)
    controller.bump()


def _ready(controller: Controller, job: Job, ready: FrameReady) -> None:
    job.done += 1
    controller.known.add(ready.key)
    plans.failures.pop(ready.key, None)
    now = time.monotonic()
    if not ready.looked_up:
        job.solved += 1
        job.frame_seconds.append(now - job.frame_started)
        if ready.frame is not None:
            _learn(controller, ready.frame)
    if ready.frame is not None:
        shelf.put(ready.key, ready.frame)
    job.frame_started, job.time, job.newton = now, math.nan, 0
    stop_obsolete(controller)
    controller.bump()


def _learn(controller: Controller, frame: SolvedFrame) -> None:
    cells = 0.0 if frame.lattice is None else float(frame.lattice.cells)
    controller.cells = cells or controller.cells
    pace().measured(cells, frame.diagnostics.seconds.total)


def _failed(controller: Controller, job: Job, failed: FrameFailed) -> None:
    frame = None if job.plan is None else frame_at(job.plan, failed.time)
    if frame is not None:
        plans.failures[frame.key] = str(failed.problem)
    if job.key == controller.key or frame is None:
        controller.failure = Failure(failed.time, str(failed.problem))
    controller.bump()


def _live(controller: Controller, frame: LiveFrame) -> None:
    live = controller.live
    if live is not None and live.job == frame.job:
        live.frame, live.seconds, live.converged = frame.frame, frame.seconds, frame.converged
        controller.bump()


def _finished(controller: Controller, job: Job, finished: Finished) -> None:
    if controller.planning is job:
        controller.planning = None
    if controller.job is job:
        controller.job = None
        if job.kind == "live":
            controller.live = None
        else:
            pace().keep()
        if job.kind == "solve" and job.plan is not None:
            controller.look_again(job.plan)
    ask_for_plan(controller)  # a solve takes the place of a plan that was being made
    controller.bump()
