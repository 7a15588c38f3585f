"""Notices that a scene may have changed: properties, objects and animation, undo, files.

Blender tells of some changes through handlers; what it keeps to itself (the frame range, a deleted object) is compared
whenever the timer comes by.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

import bpy
from bpy.app.handlers import persistent

from ..model import changes, target_samples
from ..model.migrate import migrate
from . import workers
from .controller import Controller, controller_of, controllers, find_controller, forget_all, plans, scene_of
from .frames import announce
from .live_hook import stop_live
from .reconcile import reconcile
from .solve_settings import frame_folder

_reading = False


@contextlib.contextmanager
def reading() -> Iterator[None]:
    """While a scene is read, what the reading itself moves is no change."""
    global _reading
    before, _reading = _reading, True
    try:
        yield
    finally:
        _reading = before


def read_now(scene: bpy.types.Scene, *, ask: bool = True) -> Controller:
    """Reads a scene at once and tells who listens."""
    controller = controller_of(scene)
    with reading():
        reconcile(scene, controller, ask=ask)
    announce(scene, controller)
    return controller


def check_vitals(scene: bpy.types.Scene, controller: Controller) -> None:
    """Compares what Blender does not tell about."""
    tissue = scene.lappet.tissue.object
    vitals = (
        scene.frame_start,
        scene.frame_end,
        scene.render.fps,
        scene.render.fps_base,
        scene.unit_settings.scale_length,
        0 if tissue is None else tissue.session_uid,
        tissue is not None and scene.objects.get(tissue.name) == tissue,
        len(scene.lappet.events),
        len(scene.lappet.bones),
        len(scene.lappet.materials),
        len(scene.lappet.regions),
        frame_folder(scene),
    )
    if vitals != controller.vitals:
        controller.vitals = vitals
        controller.touch()


def relevant(scene: bpy.types.Scene) -> set[int]:
    """The session_uids of what the procedure is read from: objects, their meshes and actions, what they hang on."""
    found: set[int] = set()
    todo = [scene.lappet.tissue.object, *(entry.object for entry in scene.lappet.bones)]
    todo += [event.target for event in scene.lappet.events]
    while todo:
        obj = todo.pop()
        if obj is None or obj.session_uid in found:
            continue
        found.add(obj.session_uid)
        if obj.data is not None:
            found.add(obj.data.session_uid)
        found.update(_action(obj))
        todo.append(obj.parent)
        todo += [getattr(constraint, "target", None) for constraint in obj.constraints]
    found.update(_action(scene))
    return found


def _action(owner: bpy.types.ID) -> Iterator[int]:
    data = owner.animation_data
    if data is not None and data.action is not None:
        yield data.action.session_uid


def _changed(scene: bpy.types.Scene) -> None:
    if _reading:
        return
    controller = find_controller(scene)
    if controller is None:
        controller = controller_of(scene)
    if controller.live is not None:
        stop_live(scene, controller)
    target_samples.forget()
    controller.touch()


@persistent
def _depsgraph_updated(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    if _reading or not depsgraph.updates:
        return
    controller = find_controller(scene)
    stepped = controller is not None and controller.seen_frame != scene.frame_current
    if controller is not None:
        controller.seen_frame = scene.frame_current
    ids = {}
    for update in depsgraph.updates:
        item = update.id.original
        if isinstance(item, bpy.types.Object):
            if not (update.is_updated_transform or update.is_updated_geometry):
                continue
            if stepped and not update.is_updated_geometry and _moves(item):
                continue  # the frame went on and took it along
        elif not (
            isinstance(item, bpy.types.Action) or (isinstance(item, bpy.types.Mesh) and update.is_updated_geometry)
        ):
            continue
        ids[item.session_uid] = item
    if not ids:
        return
    for each in bpy.data.scenes:
        other = find_controller(each)
        if other is None:
            continue
        touched = relevant(each) & ids.keys()
        if other.live is not None:
            touched -= _dragged(each, other)
        if touched:
            target_samples.forget()
            other.touch()


def _moves(obj: bpy.types.Object) -> bool:
    """Whether an object goes somewhere by itself when the frame changes."""
    return obj.animation_data is not None or obj.parent is not None or len(obj.constraints) > 0


def _dragged(scene: bpy.types.Scene, controller: Controller) -> set[int]:
    """The target that is dragged live, and its action: read when the dragging has ended."""
    assert controller.live is not None
    target = next((e.target for e in scene.lappet.events if e.uid == controller.live.event_uid), None)
    return set() if target is None else {target.session_uid, *_action(target)}


@persistent
def _undone(*_: object) -> None:
    """Undo and redo point back to plans and frames that are known: no timer, no worker."""
    target_samples.forget()
    for scene in bpy.data.scenes:
        controller = find_controller(scene)
        if controller is not None:
            stop_live(scene, controller, may_key=False)
            read_now(scene)


@persistent
def _before_load(*_: object) -> None:
    forget_all()


@persistent
def _loaded(*_: object) -> None:
    target_samples.forget()
    for scene in bpy.data.scenes:
        migrate(scene)
        if scene.lappet.tissue.object is None:
            continue
        scene.lappet.solving.live = False
        controller = controller_of(scene)
        last = scene.lappet.solving.last_plan
        plan = plans.find(last, controller.store) if last else None
        if plan is not None:
            controller.past = [plan]
            controller.look_again(plan)
        read_now(scene, ask=False)  # planning waits for the timer, or for somebody who solves
        if controller.plan is None:
            controller.touch()


@persistent
def _before_save(*_: object) -> None:
    """The file remembers its plan, so that stale frames are shown when it is opened."""
    for controller in controllers():
        scene = scene_of(controller)
        newest = controller.newest()
        if scene is not None and scene.library is None and newest is not None:
            scene.lappet.solving.last_plan = newest.key


@persistent
def _before_render(scene: bpy.types.Scene, *_: object) -> None:
    """A render started by a script finds the scene as it is now."""
    controller = find_controller(scene)
    if controller is not None and controller.dirty_since is not None and bpy.app.background:
        read_now(scene, ask=False)


_HANDLERS = (
    ("depsgraph_update_post", _depsgraph_updated),
    ("undo_post", _undone),
    ("redo_post", _undone),
    ("load_pre", _before_load),
    ("load_post", _loaded),
    ("save_pre", _before_save),
    ("render_init", _before_render),
)


def register() -> None:
    """Adds the handlers."""
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)
    changes.subscribe(_changed)


def unregister() -> None:
    """Takes the handlers away and ends the workers."""
    changes.unsubscribe(_changed)
    for name, handler in _HANDLERS:
        handlers = getattr(bpy.app.handlers, name)
        if handler in handlers:
            handlers.remove(handler)
    forget_all()
    workers.close_all()
