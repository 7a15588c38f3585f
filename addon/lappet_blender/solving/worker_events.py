"""Take in what the worker tells: manifests, frames, refusals, ends of jobs."""

from __future__ import annotations

import math
import time

from lappet.background.worker_events import (
    Assessed,
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
from lappet.daemon.solved_frame import SolvedFrame

from .controller import Controller, Failure, Job, frame_at, frame_cache, manifests
from .reconcile import activate_manifest, request_manifest, stop_obsolete
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
        controller.note(event.problem)
        return
    job = next((job for job in controller.jobs() if job.number == event.job), None)
    if job is None:
        return  # of a job that nobody waits for any more; its frames are in the store
    match event:
        case Listed():
            _listed(controller, job, event)
        case Refused():
            manifests.refuse(job.key, event.problems)
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
        case Assessed():
            manifests.assessments[job.key] = event.assessment
            controller.notify()
        case LiveFrame():
            _live(controller, job, event)
        case Finished():
            _finished(controller, job, event)


def _listed(controller: Controller, job: Job, listed: Listed) -> None:
    manifest = manifests.keep(listed.manifest, job.key)
    job.manifest = manifest
    job.total = sum(1 for frame in manifest.frames if job.until is None or frame.time <= job.until)
    controller.known.update(frame.key for frame, there in zip(manifest.frames, listed.known, strict=True) if there)
    if job.key == controller.key:
        controller.manifest = manifest
        controller.refused = ()
        activate_manifest(controller)
    controller.notify()


def _ready(controller: Controller, job: Job, ready: FrameReady) -> None:
    job.done += 1
    controller.known.add(ready.key)
    manifests.failures.pop(ready.key, None)
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
    frame = None if job.manifest is None else frame_at(job.manifest, failed.time)
    if frame is not None:
        manifests.failures[frame.key] = failed.problem
    if job.key == controller.key or frame is None:
        controller.failure = Failure(failed.time, failed.problem)
    controller.notify()


def _live(controller: Controller, job: Job, frame: LiveFrame) -> None:
    live = controller.live
    if live is None or live.job != frame.job:
        return
    shown = frame.frame
    if live.placing and job.manifest is not None and live.held in job.manifest.hooks:
        shown = shown.without_hook(job.manifest.hooks.index(live.held))
    live.frame, live.seconds, live.converged = shown, frame.seconds, frame.converged
    live.stirred_at = time.monotonic()
    controller.notify()


def _finished(controller: Controller, job: Job, finished: Finished) -> None:
    if controller.listing is job:
        controller.listing = None
    if controller.job is job:
        controller.job = None
        if job.kind == "live":
            controller.live = None
        else:
            speed_estimate().keep()
        if job.kind == "solve" and job.manifest is not None:
            controller.recheck_frames(job.manifest)
    request_manifest(controller)  # a solve takes the place of a manifest that was being made
    controller.notify()
