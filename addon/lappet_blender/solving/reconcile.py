"""Bring what is known about a scene's solving up to what the scene holds now.

Reads the scene, names its manifest by key and looks it up; only what is nowhere is asked of the worker. An undo finds
its frames at once, and a file that is opened again finds those of the day before.
"""

from __future__ import annotations

import contextlib
import math
import threading
import time
from collections.abc import Iterator

import bpy

from lappet.background.assessment import Assessment, assessment_key
from lappet.core.problem import Problem, RefusedError, problem
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Procedure
from lappet.program.settings import SolverSettings
from lappet.solve.store import FrameStore

from ..model.migrate import from_newer_version
from ..model.scene_procedure import read_scene
from .chosen_daemon import chosen_daemon, identity_of
from .controller import PAST_MANIFESTS, Controller, Job, manifests
from .first_change import first_change
from .frame_copy import FrameCopy
from .solve_settings import frame_store, solve_settings

QUIET = 0.1  # seconds without a change before the scene is read
LONGEST_WAIT = 0.5  # ... while changes keep coming
LEAST_GAP = 0.2  # between two readings
_REST = 8.0  # a reading that took s seconds is followed by that many times s without one
_warming: threading.Thread | None = None


def due(controller: Controller) -> bool:
    """Whether the scene has changed and it is time to read it."""
    if controller.dirty_since is None:
        return False
    now = time.monotonic()
    waited = now - controller.changed_at >= QUIET or now - controller.dirty_since >= LONGEST_WAIT
    return waited and now - controller.read_at >= max(LEAST_GAP, _REST * controller.read_seconds)


def reconcile(scene: bpy.types.Scene, controller: Controller, *, ask: bool = True) -> None:
    """Read the scene now. ask: have the worker make a manifest that is not known."""
    started = time.monotonic()
    controller.dirty_since = None
    reading = read_scene(scene)
    settings = solve_settings(scene)
    store = frame_store(scene)
    if store is not controller.store:
        _move(controller, store)
    daemon = chosen_daemon()
    if daemon != controller.daemon:  # a worker is bound to its daemon, as it is to its folder
        controller.release()
        controller.daemon, controller.key = daemon, ""
    _take(controller, reading.procedure, settings, (*reading.problems, *_newer(scene)))
    if ask:
        request_manifest(controller)
    controller.read_at = time.monotonic()
    controller.read_seconds = controller.read_at - started


def _newer(scene: bpy.types.Scene) -> tuple[Problem, ...]:
    if not from_newer_version(scene):
        return ()
    return (problem(ProblemCode.SCENE_NEWER, scene.name, scene.lappet.version),)


def request_manifest(controller: Controller) -> None:
    """Have the worker make the manifest in the background, where it is neither known nor refused."""
    if controller.procedure is None or not controller.key or controller.manifest is not None or controller.refused:
        return
    if any(job.key == controller.key and not job.cancelled for job in controller.jobs()):
        return
    with reporting(controller):
        number = controller.solver().manifest(controller.procedure, controller.settings)
        controller.listing = Job(number, "manifest", controller.key, controller.procedure, controller.settings)
        controller.notify()


@contextlib.contextmanager
def reporting(controller: Controller) -> Iterator[None]:
    """What the worker cannot do becomes a problem of the scene instead of an exception."""
    try:
        yield
    except RefusedError as refused:
        controller.refused = refused.problems
        controller.notify()
    except (RuntimeError, OSError) as error:
        controller.refused = (problem(ProblemCode.SOLVER_NOT_STARTED, "", error),)
        controller.notify()


def identity() -> str:
    """What identifies the solver in keys; raises RefusedError or OSError where there is none that can be read."""
    if _warming is not None:
        _warming.join()
    daemon = chosen_daemon()
    return _own_identity() if daemon is None else identity_of(daemon)


def _own_identity() -> str:
    from lappet.daemon.process import daemon_identity

    return daemon_identity()


def warm_up() -> None:
    """Import what solving needs and read the solver's program, on a thread: the first reading would stall for it."""
    global _warming

    def import_all() -> None:
        with contextlib.suppress(Exception):  # whoever needs it says what is wrong
            import lappet.background.manifest_key
            import lappet.background.manifest_store
            import lappet.background.solver  # noqa: F401

            _own_identity()

    _warming = threading.Thread(target=import_all, name="lappet imports", daemon=True)
    _warming.start()


def stop_obsolete(controller: Controller) -> None:
    """Cancel a solve that has reached what the procedure no longer asks for; what it solved is kept."""
    job = controller.job
    if job is None or job.kind != "solve" or job.cancelled or job.key == controller.key or job.manifest is None:
        return
    if controller.procedure is None or controller.settings != job.settings:
        valid = -math.inf
    else:
        valid = first_change(job.procedure, controller.procedure)
    following = job.manifest.frames[0].time + job.done if job.manifest.frames else math.inf
    if following >= valid and job.done < job.total:
        controller.solver().cancel(job.number)
        job.cancelled = True
        controller.note(problem(ProblemCode.PROCEDURE_CHANGED, "", f"{following:g}"))


def _take(
    controller: Controller, procedure: Procedure | None, settings: SolverSettings, problems: tuple[Problem, ...]
) -> None:
    if problems != controller.problems:
        controller.problems = problems
        controller.notify()
    if procedure is None or any(problem.severity == "error" for problem in problems):
        _retire(controller)
        controller.procedure, controller.key, controller.refused = procedure, "", ()
        controller.changed_from = _still_holds(controller, procedure, settings)
        stop_obsolete(controller)
        controller.notify()
        return
    same = controller.key and settings == controller.settings and procedure == controller.procedure
    if same and (controller.manifest is not None or manifests.refused(controller.key) is not None):
        return
    try:
        from lappet.background.manifest_key import manifest_key

        key = manifest_key(procedure, settings, identity())
    except (RefusedError, OSError) as error:
        _retire(controller)
        controller.procedure, controller.settings, controller.key = procedure, settings, ""
        unreadable = (problem(ProblemCode.SOLVER_UNREADABLE, "", error),)
        controller.refused = error.problems if isinstance(error, RefusedError) else unreadable
        controller.notify()
        return
    if key != controller.key:
        _retire(controller)
        controller.failure = None
    if controller.procedure is None or controller.procedure.tissue is not procedure.tissue:
        controller.cells = 0.0
    controller.procedure, controller.settings, controller.key = procedure, settings, key
    controller.refused = manifests.refused(key) or ()
    controller.manifest = manifests.find(key, controller.store)
    if controller.manifest is not None:
        activate_manifest(controller)
    else:
        controller.changed_from = _still_holds(controller, procedure, settings)
    stop_obsolete(controller)
    controller.notify()


def activate_manifest(controller: Controller) -> None:
    """The manifest of the key is known now: looks which of its frames are there."""
    assert controller.manifest is not None
    if controller.procedure is not None:
        controller.past_of = (controller.procedure, controller.settings)
    controller.recheck_frames(controller.manifest)
    if controller.procedure is not None and controller.key not in manifests.assessments:
        keys = [frame.key for frame in controller.manifest.frames]
        key = assessment_key(keys, controller.settings.correction, controller.procedure)
        found = controller.store.get(key, Assessment)
        if found is not None:
            manifests.assessments[controller.key] = found


def _retire(controller: Controller) -> None:
    """The manifest in force becomes the newest of the past ones."""
    manifest, controller.manifest = controller.manifest, None
    if manifest is None:
        return
    others = [each for each in controller.past if each.key != manifest.key]
    controller.past = [manifest, *others][:PAST_MANIFESTS]


def _still_holds(controller: Controller, procedure: Procedure | None, settings: SolverSettings) -> float:
    """The time before which the newest past manifest holds for this procedure."""
    if procedure is None or not controller.past or controller.past_of is None:
        return -math.inf
    before, with_settings = controller.past_of
    return first_change(before, procedure) if settings == with_settings else -math.inf


def _move(controller: Controller, store: FrameStore) -> None:
    """Keep frames in another folder from now on, those that are there too.

    A worker is bound to its folder, so this scene gets another.
    """
    if controller.job is not None:
        controller.note(problem(ProblemCode.STORE_MOVED, "", store.folder))
    controller.release()
    every = [*([controller.manifest] if controller.manifest else []), *controller.past]
    if every:
        controller.copying = FrameCopy(every, controller.store, store)
    controller.store = store
    controller.recheck_frames(*every)


def finish_copying(controller: Controller) -> None:
    """Frames that were copied to another folder are there now."""
    copying = controller.copying
    if copying is None or not copying.done:
        return
    controller.copying = None
    if copying.problem:
        controller.note(copying.problem)
    controller.recheck_frames(*([controller.manifest] if controller.manifest else []), *controller.past)
