"""Solve a file when it is opened, where the file asks for it: a project that was downloaded has no solved frames."""

from __future__ import annotations

import bpy
from bpy.app.handlers import persistent

from lappet.core.problem import RefusedError

from ..interface.said import said
from ..model.tissue_values import tissue_is_ready
from .controller import controller_of, manifests
from .frame_states import count_states
from .frames import progress_of
from .scene_watch import reading
from .solve_jobs import start_solve

_EVERY = 0.5  # seconds
_waiting: set[int] = set()  # session_uids of scenes whose solve is to begin
_begun: set[int] = set()  # ... of which the status bar speaks


def wanting(scenes: bpy.types.bpy_prop_collection) -> list[bpy.types.Scene]:
    """The scenes that ask to be solved when their file is opened."""
    found = [scene for scene in scenes if scene.library is None and scene.lappet.solving.when_opened]
    return [scene for scene in found if scene.lappet.tissue.object is not None]


def begin(scene: bpy.types.Scene) -> bool:
    """Start solving what is not solved yet; whether there was something, and nothing spoke against it.

    Frames that somebody else solved on this computer are there, but perhaps not how far they may be off.
    """
    controller = controller_of(scene)
    unsolved = controller.manifest is None or any(
        count for state, count in count_states(controller).items() if state != "solved"
    )
    if not unsolved and (controller.key in manifests.assessments or not scene.lappet.solving.error_estimate):
        return False
    try:
        with reading():
            start_solve(scene)
    except RefusedError:  # the panel says why
        return False
    return True


@persistent  # type: ignore[untyped-decorator]
def _loaded(*_: object) -> None:
    _waiting.clear()
    _begun.clear()
    _waiting.update(scene.session_uid for scene in wanting(bpy.data.scenes))
    running = bpy.app.timers.is_registered(_step)
    if running:
        bpy.app.timers.unregister(_step)
    if (_waiting or running) and not bpy.app.background:
        # Anew, even where it runs: where a timer has opened the file, those that are due come next, and the status bar
        # is then still that of a workspace which Blender has freed.
        bpy.app.timers.register(_step, first_interval=_EVERY, persistent=True)


def _step() -> float | None:
    """Begin what can begin, and say in the status bar what is under way; a timer's step."""
    line = ""
    for scene in bpy.data.scenes:
        uid = scene.session_uid
        if uid in _waiting and tissue_is_ready(scene):
            _waiting.discard(uid)
            if begin(scene):
                _begun.add(uid)
        if uid in _begun:
            progress = progress_of(scene)
            if progress.running:
                line = said("Solving {scene}: {line}", scene=scene.name, line=progress.line)
            else:
                _begun.discard(uid)
    _say(line or None)
    return _EVERY if _waiting or _begun else None


def _say(line: str | None) -> None:
    manager = bpy.context.window_manager
    for window in manager.windows if manager is not None else ():
        window.workspace.status_text_set(line)


def register() -> None:
    """Listen for files that are opened."""
    bpy.app.handlers.load_post.append(_loaded)


def unregister() -> None:
    """Listen no more, and leave the status bar to Blender."""
    if bpy.app.timers.is_registered(_step):
        bpy.app.timers.unregister(_step)
        _say(None)
    if _loaded in bpy.app.handlers.load_post:
        bpy.app.handlers.load_post.remove(_loaded)
    _waiting.clear()
    _begun.clear()
