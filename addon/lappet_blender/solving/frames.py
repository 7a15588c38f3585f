"""What other parts of the add-on ask the solving side: manifests, states of frames, what is shown, progress."""

from __future__ import annotations

import math
from collections.abc import Callable

import bpy

from lappet.background.assessment import Assessment, Pull
from lappet.background.manifest import Manifest
from lappet.core.problem import Problem
from lappet.solve.error_estimate import FrameErrorEstimate

from .controller import Controller, Failure, controller_of, find_controller, frame_at, manifests
from .frame_states import FrameRun, State, frame_runs_of, frame_states
from .shown_frame import Shown, find_shown, read_neighbors
from .solve_progress import Progress, progress

__all__ = ["Failure", "FrameRun", "Progress", "Shown"]

Listener = Callable[[bpy.types.Scene], None]
FollowUp = Callable[[], bool]
_listeners: list[Listener] = []
_follow_ups: list[FollowUp] = []


def manifest_of(scene: bpy.types.Scene) -> Manifest | None:
    """The manifest of the procedure as it is now; None while it is not known."""
    return controller_of(scene).manifest


def frame_state(scene: bpy.types.Scene, time: float) -> State:
    """Return "solved", "stale" (an older solve is shown), "failed" or "missing"."""
    return frame_states(controller_of(scene)).get(math.floor(time + 1e-6), "missing")


def frame_runs(scene: bpy.types.Scene) -> tuple[FrameRun, ...]:
    """The states of all frames as stretches of equal state, in order; cheap enough for every redraw."""
    return frame_runs_of(controller_of(scene))


def frame_problem(scene: bpy.types.Scene, time: float) -> Problem | None:
    """Why the frame at a time failed; None where it did not."""
    manifest = controller_of(scene).newest()
    frame = None if manifest is None else frame_at(manifest, time)
    return None if frame is None else manifests.failures.get(frame.key)


def shown_at(scene: bpy.types.Scene, time: float) -> Shown | None:
    """What to show at a time: the frame, an older one in its place (stale), the epoch at rest; None = not listed."""
    controller = find_controller(scene)
    if controller is None:
        controller_of(scene)  # from now on it is read when the timer next comes by
        return None
    shown = find_shown(controller, time)
    read_neighbors(controller, time)
    return shown


def progress_of(scene: bpy.types.Scene) -> Progress:
    """How the solving of a scene stands."""
    return progress(controller_of(scene))


def problems_of(scene: bpy.types.Scene) -> tuple[Problem, ...]:
    """What is wrong with the scene's procedure, seen while reading it and by the solver, and what is suspicious."""
    controller = controller_of(scene)
    suspicious = (each for each in _told(controller) if each.severity != "note")
    return tuple(dict.fromkeys([*controller.problems, *controller.refused, *suspicious]))


def notes_of(scene: bpy.types.Scene) -> tuple[Problem, ...]:
    """What the user should know besides: of the manifest, its frames, and what happened since the last solve began."""
    return tuple(each for each in _told(controller_of(scene)) if each.severity == "note")


def error_of(scene: bpy.types.Scene, time: float) -> FrameErrorEstimate | None:
    """The estimated error of the frame at a time; None where it was not estimated."""
    assessment, index = _assessed(scene, time)
    errors = () if assessment is None else assessment.errors
    return errors[index] if index < len(errors) else None


def is_assessed(scene: bpy.types.Scene) -> bool:
    """Whether anybody has looked at the frames as a whole: how far they may be off, and what is suspicious."""
    return controller_of(scene).key in manifests.assessments


def pull_of(scene: bpy.types.Scene, time: float, event: str) -> Pull | None:
    """What a suture or hook pulls with in the frame at a time; None where it does not, or where that is not known."""
    assessment, index = _assessed(scene, time)
    pulls = () if assessment is None else assessment.pulls
    own = pulls[index] if index < len(pulls) else ()
    return next((each for each in own if each.event == event), None)


def pulls_of_run(scene: bpy.types.Scene, time: float, run: str) -> list[Pull]:
    """What the stitches of a suture run pull with in the frame at a time, of those that the lattice resolves."""
    assessment, index = _assessed(scene, time)
    pulls = () if assessment is None else assessment.pulls
    own = pulls[index] if index < len(pulls) else ()
    return [each for each in own if each.event.startswith(f"{run}/") and each.resolved]


def _assessed(scene: bpy.types.Scene, time: float) -> tuple[Assessment | None, int]:
    """What is known of the frames, and the place among them of the one at a time; None where it is not listed."""
    controller = controller_of(scene)
    assessment, manifest = manifests.assessments.get(controller.key), controller.manifest
    if assessment is None or manifest is None or frame_at(manifest, time) is None:
        return None, 0
    return assessment, math.floor(time + 1e-6) - manifest.frames[0].time


def _told(controller: Controller) -> tuple[Problem, ...]:
    manifest, assessment = controller.manifest, manifests.assessments.get(controller.key)
    of_manifest = manifest.notes if manifest is not None else ()
    of_frames = assessment.notes if assessment is not None else ()
    return tuple(dict.fromkeys([*of_manifest, *of_frames, *controller.notes]))


def failure_of(scene: bpy.types.Scene) -> Failure | None:
    """Why the last solve stopped, or the first frame that failed when it was solved; None where all is well."""
    controller = controller_of(scene)
    if controller.failure is not None:
        return controller.failure
    failed = (time for time, state in frame_states(controller).items() if state == "failed")
    found = ((time, frame_problem(scene, time)) for time in failed)
    return next((Failure(time, problem) for time, problem in found if problem is not None), None)


def subscribe(listener: Listener) -> None:
    """Call `listener(scene)` on the main thread when what is shown, or a state, may have changed."""
    if listener not in _listeners:
        _listeners.append(listener)


def unsubscribe(listener: Listener) -> None:
    """Take a listener off; one that is not there is no error."""
    if listener in _listeners:
        _listeners.remove(listener)


def add_follow_up(step: FollowUp) -> None:
    """Call `step()` when the timer comes by, for what a listener puts off; it does a little, True = there is more."""
    if step not in _follow_ups:
        _follow_ups.append(step)


def remove_follow_up(step: FollowUp) -> None:
    """Take it off; one that is not there is no error."""
    if step in _follow_ups:
        _follow_ups.remove(step)


def follow_up() -> bool:
    """Do a little of what listeners put off; whether there is more."""
    more = [step() for step in list(_follow_ups)]  # every one gets its turn
    return any(more)


def notify_listeners(scene: bpy.types.Scene, controller: Controller) -> None:
    """Notify the listeners if anything has changed since they were last notified.

    An error of one does not stop the others.
    """
    if controller.notified == controller.revision:
        return
    controller.notified = controller.revision
    errors = []
    for listener in list(_listeners):
        try:
            listener(scene)
        except Exception as error:
            errors.append(error)
    if errors:
        raise errors[0]
