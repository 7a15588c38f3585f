"""Waiting for a job, for scripts: prints a line per frame and lets Ctrl-C cancel."""

from __future__ import annotations

import time
from dataclasses import replace

import bpy

from lappet.core.problem import Problem, RefusedError, refused
from lappet.core.problem_code import ProblemCode

from .controller import Failure, controller_of
from .frame_states import count_states
from .frames import follow_up, notify_listeners
from .solve_jobs import cancel_solve
from .worker_events import handle_worker_events

_NAP = 0.01


def wait_for_solve(scene: bpy.types.Scene) -> bool:
    """Wait until the scene's job has ended; True where it ran to its end, False where it was cancelled.

    Prints a line per frame. Ctrl-C cancels. Raises RefusedError where the procedure was refused or a frame
    failed.
    """
    controller = controller_of(scene)
    job, printed = controller.job, 0
    assert job is not None
    while controller.job is job:
        try:
            if not handle_worker_events(controller):
                time.sleep(_NAP)
            notify_listeners(scene, controller)
            if job.done != printed:
                printed = job.done
                print(f"Lappet: {printed} of {job.total} frames, {job.solved} of them solved now", flush=True)
        except KeyboardInterrupt:
            print("Lappet: cancelling", flush=True)
            cancel_solve(scene)
    _finish_pictures()
    if controller.refused:
        raise RefusedError(controller.refused)
    if controller.failure is not None:
        raise RefusedError([_with_frame(controller.failure)])
    if not job.cancelled:
        counts = count_states(controller)
        print(f"Lappet: {counts['solved']} frames solved in {time.monotonic() - job.started:.1f} s", flush=True)
    return not job.cancelled


def wait_for_manifest(scene: bpy.types.Scene) -> None:
    """Wait until the scene's manifest is known; Ctrl-C stops waiting. Raises RefusedError where it is refused."""
    controller = controller_of(scene)
    while controller.listing is not None or (controller.manifest is None and controller.job is not None):
        if not handle_worker_events(controller):
            time.sleep(_NAP)
    notify_listeners(scene, controller)
    _finish_pictures()
    if controller.refused:
        raise RefusedError(controller.refused)
    if controller.manifest is None:
        raise refused(ProblemCode.PLAN_FAILED)


def _with_frame(failure: Failure) -> Problem:
    """The problem, about the frame at which it arose where it is about nothing else."""
    if failure.time is None or failure.problem.prim:
        return failure.problem
    return replace(failure.problem, prim=f"Frame {failure.time}")


def _finish_pictures() -> None:
    while follow_up():
        pass
