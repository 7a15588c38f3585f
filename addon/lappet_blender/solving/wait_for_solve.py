"""Waiting for a job, for scripts: prints a line per frame and lets Ctrl-C cancel."""

from __future__ import annotations

import time

import bpy

from lappet.core.problem import RefusedError

from .controller import controller_of
from .frame_states import count_states
from .frames import follow_up, notify_listeners
from .solve_jobs import cancel_solve, first_sentence
from .worker_events import handle_worker_events

_NAP = 0.01


class SolveFailedError(RuntimeError):
    """A solve ended before its last frame; the message is the sentence that the user reads."""


def wait_for_solve(scene: bpy.types.Scene) -> bool:
    """Waits until the scene's job has ended; True where it ran to its end, False where it was cancelled.

    Prints a line per frame. Ctrl-C cancels. Raises RefusedError where the procedure was refused and SolveFailedError
    where a frame failed.
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
        raise RefusedError(first_sentence(controller.refused))
    if controller.failure is not None:
        at = "" if controller.failure.time is None else f"Frame {controller.failure.time} failed: "
        raise SolveFailedError(f"{at}{controller.failure.sentence}")
    if not job.cancelled:
        counts = count_states(controller)
        print(f"Lappet: {counts['solved']} frames solved in {time.monotonic() - job.started:.1f} s", flush=True)
    return not job.cancelled


def wait_for_plan(scene: bpy.types.Scene) -> None:
    """Waits until the scene's procedure is planned; Ctrl-C stops waiting. Raises RefusedError where it is refused."""
    controller = controller_of(scene)
    while controller.planning is not None or (controller.plan is None and controller.job is not None):
        if not handle_worker_events(controller):
            time.sleep(_NAP)
    notify_listeners(scene, controller)
    _finish_pictures()
    if controller.refused:
        raise RefusedError(first_sentence(controller.refused))
    if controller.plan is None:
        raise SolveFailedError("The procedure could not be planned; the notes in the Solve panel say why.")


def _finish_pictures() -> None:
    while follow_up():
        pass
