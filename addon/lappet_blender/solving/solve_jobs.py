"""Starts and stops the jobs of a scene; every refusal is one sentence in a RefusedError."""

from __future__ import annotations

from pathlib import Path

import bpy

from lappet.core.problem import Problem, RefusedError

from .controller import Job, controller_of, controllers, frame_cache, plans
from .frames import problems_of
from .reconcile import reconcile, request_plan


def start_solve(scene: bpy.types.Scene, until: int | None = None) -> Job:
    """Reads the scene as it is now and has the worker solve it up to the frame `until` (None: all)."""
    controller = controller_of(scene)
    if controller.job is not None and not controller.job.cancelled:
        what = "A hook is being dragged" if controller.job.kind == "live" else "This scene is being solved"
        raise RefusedError(f"{what} already; wait for it, or cancel it first.")
    reconcile(scene, controller, ask=False)
    refuse_problems(controller.problems)
    procedure = controller.procedure
    if procedure is None or not controller.key:
        raise RefusedError(first_sentence(problems_of(scene)))
    controller.refused = ()  # what was refused once is asked again: the disk or the installation may be repaired
    frames = procedure.frames()
    if until is not None and until not in frames:
        raise RefusedError(
            f"Frame {until} is not in the timeline, which runs from {frames[0]} to {frames[-1]}; give one inside it."
        )
    if controller.plan is not None:
        for frame in controller.plan.frames:
            plans.failures.pop(frame.key, None)
    controller.failure = None
    controller.notes.clear()
    try:
        number = controller.solver().solve(procedure, controller.settings, until)
    except (RuntimeError, OSError) as error:
        raise RefusedError(f"The solver could not be started: {error}") from error
    job = Job(number, "solve", controller.key, procedure, controller.settings, plan=controller.plan, until=until)
    job.total = len(frames) if until is None else until - frames[0] + 1
    controller.job = job
    controller.planning = None  # a solve cancels it, and tells the plan itself
    controller.notify()
    return job


def cancel_solve(scene: bpy.types.Scene) -> bool:
    """Stops the scene's job at the solver's next iteration; False where there is none."""
    controller = controller_of(scene)
    job = controller.job
    if job is None or controller.client is None:
        return False
    controller.client.cancel(job.number)
    job.cancelled = True
    controller.notify()
    return True


def start_plan(scene: bpy.types.Scene) -> None:
    """Reads the scene now and has it planned where its plan is not known."""
    controller = controller_of(scene)
    if controller.key and controller.refused:
        plans.forget(controller.key)
    reconcile(scene, controller, ask=False)
    refuse_problems(controller.problems)
    if controller.procedure is None or not controller.key:
        raise RefusedError(first_sentence(problems_of(scene)))
    controller.refused = ()
    request_plan(controller)
    refuse_problems(controller.refused)


def clear_frames(scene: bpy.types.Scene) -> int:
    """Removes the solved frames of the scene's plans from memory and from the store; how many there were.

    Frames belong to what was solved, not to a scene: a copy of the scene that shares them loses them as well.
    """
    controller = controller_of(scene)
    if controller.job is not None:
        raise RefusedError("The scene is being solved; cancel that before its frames are cleared.")
    every = [*([controller.plan] if controller.plan else []), *controller.past]
    keys = {frame.key for plan in every for frame in plan.frames}
    there = [key for key in keys if controller.holds(key)]
    for key in keys:
        frame_cache.drop(key)
        plans.failures.pop(key, None)
        _remove(controller.store.path(key))
    controller.past.clear()
    controller.failure = None
    recheck_all_scenes()
    return len(there)


def reload_frames(scene: bpy.types.Scene) -> None:
    """Forgets what is in memory and looks into the store again: another program may have solved meanwhile."""
    controller = controller_of(scene)
    frame_cache.clear()
    if controller.key:
        plans.forget(controller.key)
    reconcile(scene, controller)
    recheck_all_scenes()


def recheck_all_scenes() -> None:
    """Has every scene ask the store anew which frames there are."""
    for each in controllers():
        each.recheck_frames(*([each.plan] if each.plan else []), *each.past)


def refuse_problems(problems: tuple[Problem, ...]) -> None:
    """Raises the first error with its remedy, if there is one."""
    errors = tuple(problem for problem in problems if problem.severity == "error")
    if errors:
        raise RefusedError(first_sentence(errors))


def first_sentence(problems: tuple[Problem, ...]) -> str:
    """The first problem as people read it, and how many more there are."""
    if not problems:
        return "There is no tissue to solve; make a mesh the tissue first."
    more = len(problems) - 1
    tail = f" ({more} more in the Solve panel.)" if more else ""
    worst = next((problem for problem in problems if problem.severity == "error"), problems[0])
    return f"{worst}{tail}"


def _remove(path: Path) -> None:
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        raise RefusedError(
            f"The solved frame {path} cannot be removed ({error.strerror or error}); make its folder writable."
        ) from error
