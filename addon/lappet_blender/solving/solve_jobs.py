"""Start and stop the jobs of a scene; what is refused is a RefusedError with its problems."""

from __future__ import annotations

from pathlib import Path

import bpy

from lappet.core.problem import Problem, RefusedError, problem, refused
from lappet.core.problem_code import ProblemCode

from .chosen_daemon import ask_again
from .controller import Job, controller_of, controllers, frame_cache, manifests
from .frames import problems_of
from .reconcile import reconcile, request_manifest


def start_solve(scene: bpy.types.Scene, until: int | None = None) -> Job:
    """Read the scene as it is now and have the worker solve it up to the frame `until` (None: all)."""
    controller = controller_of(scene)
    if controller.job is not None and not controller.job.cancelled:
        raise refused(ProblemCode.SOLVE_LIVE if controller.job.kind == "live" else ProblemCode.SOLVE_RUNNING)
    ask_again()
    reconcile(scene, controller, ask=False)
    refuse_problems(controller.problems)
    procedure = controller.procedure
    if procedure is None or not controller.key:
        raise RefusedError(worst_first(problems_of(scene)))
    controller.refused = ()  # what was refused once is asked again: the disk or the installation may be repaired
    frames = procedure.frames()
    if until is not None and until not in frames:
        raise refused(ProblemCode.SOLVE_UNTIL, "", until, first=frames[0], last=frames[-1])
    if controller.manifest is not None:
        for frame in controller.manifest.frames:
            manifests.failures.pop(frame.key, None)
    controller.failure = None
    controller.notes.clear()
    try:
        number = controller.solver().solve(procedure, controller.settings, until)
    except (RuntimeError, OSError) as error:
        raise refused(ProblemCode.SOLVER_NOT_STARTED, "", error) from error
    job = Job(
        number, "solve", controller.key, procedure, controller.settings, manifest=controller.manifest, until=until
    )
    job.total = len(frames) if until is None else until - frames[0] + 1
    controller.job = job
    controller.listing = None  # a solve cancels it, and tells the manifest itself
    controller.notify()
    return job


def cancel_solve(scene: bpy.types.Scene) -> bool:
    """Stop the scene's job at the solver's next iteration; False where there is none."""
    controller = controller_of(scene)
    job = controller.job
    if job is None or controller.client is None:
        return False
    controller.client.cancel(job.number)
    job.cancelled = True
    controller.notify()
    return True


def start_manifest(scene: bpy.types.Scene) -> None:
    """Read the scene now and have its manifest made where it is not known."""
    controller = controller_of(scene)
    if controller.key and controller.refused:
        manifests.drop(controller.key)
    ask_again()
    reconcile(scene, controller, ask=False)
    refuse_problems(controller.problems)
    if controller.procedure is None or not controller.key:
        raise RefusedError(worst_first(problems_of(scene)))
    controller.refused = ()
    request_manifest(controller)
    refuse_problems(controller.refused)


def clear_frames(scene: bpy.types.Scene) -> int:
    """Remove the solved frames of the scene's manifests from memory and from the store; how many there were.

    Frames belong to what was solved, not to a scene: a copy of the scene that shares them loses them as well.
    """
    controller = controller_of(scene)
    if controller.job is not None:
        raise refused(ProblemCode.SOLVE_RUNNING)
    every = [*([controller.manifest] if controller.manifest else []), *controller.past]
    keys = {frame.key for manifest in every for frame in manifest.frames}
    there = [key for key in keys if controller.holds(key)]
    for key in keys:
        frame_cache.drop(key)
        manifests.failures.pop(key, None)
        _remove(controller.store.path(key))
    controller.past.clear()
    controller.failure = None
    recheck_all_scenes()
    return len(there)


def reload_frames(scene: bpy.types.Scene) -> None:
    """Drop the frames in memory and look into the store again: another program may have solved meanwhile."""
    controller = controller_of(scene)
    frame_cache.clear()
    if controller.key:
        manifests.drop(controller.key)
    reconcile(scene, controller)
    recheck_all_scenes()


def recheck_all_scenes() -> None:
    """Have every scene ask the store anew which frames there are."""
    for each in controllers():
        each.recheck_frames(*([each.manifest] if each.manifest else []), *each.past)


def refuse_problems(problems: tuple[Problem, ...]) -> None:
    """Raise RefusedError with the errors among the problems, if there are any."""
    errors = [each for each in problems if each.severity == "error"]
    if errors:
        raise RefusedError(errors)


def worst_first(problems: tuple[Problem, ...]) -> list[Problem]:
    """Return the problems, errors first; where there are none, that there is no tissue."""
    return sorted(problems, key=lambda each: each.severity != "error") or [problem(ProblemCode.TISSUE_NONE)]


def _remove(path: Path) -> None:
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        raise refused(ProblemCode.FRAME_NOT_REMOVED, path, error.strerror or error) from error
