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
from ..model.tissue_values import tissue_is_ready
from . import workers
from .chosen_daemon import answer_state
from .controller import Controller, controller_of, controllers, drop_all, find_controller, manifests, scene_of
from .frames import notify_listeners
from .live_drag import stop_live
from .reconcile import reconcile
from .solve_settings import frame_folder_choice

_reading = False
_updating = False  # while Blender tells of a dependency graph that was updated


@contextlib.contextmanager
def reading() -> Iterator[None]:
    """While a scene is read, what the reading itself moves is no change."""
    global _reading
    before, _reading = _reading, True
    try:
        yield
    finally:
        _reading = before


def read_now(scene: bpy.types.Scene, *, ask: bool = True, notify: bool = True) -> Controller:
    """Read a scene at once and notify the listeners; notify: off where they are notified later."""
    controller = controller_of(scene)
    with reading():
        reconcile(scene, controller, ask=ask)
    if notify:
        notify_listeners(scene, controller)
    return controller


def check_polled_state(scene: bpy.types.Scene, controller: Controller) -> None:
    """Compare what Blender does not tell about."""
    tissue = scene.lappet.tissue.object
    polled_state = (
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
        *frame_folder_choice(scene),
        *answer_state(),
    )
    if polled_state != controller.polled_state:
        controller.polled_state = polled_state
        controller.mark_dirty()


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
    controller = controller_of(scene)
    if controller.live is not None and not _updating:  # else it is a target that moved
        controller.live.needs_check = True
    target_samples.mark_dirty()
    controller.mark_dirty()


def _update_begins(*_: object) -> None:
    """The first of all handlers of an update; `_depsgraph_updated` comes after those that call `changed`."""
    global _updating
    _updating = True


def _depsgraph_updated(_scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    """Going to another frame is no update: what is animated moves without being named here."""
    global _updating
    _updating = False
    if _reading or not depsgraph.updates:
        return
    ids = set()
    for update in depsgraph.updates:
        item = update.id.original
        if isinstance(item, bpy.types.Object):
            if not (update.is_updated_transform or update.is_updated_geometry):
                continue
        elif isinstance(item, bpy.types.Mesh):
            if not update.is_updated_geometry:
                continue
        elif not isinstance(item, bpy.types.Action):
            continue
        ids.add(item.session_uid)
    if not ids:
        return
    for each in bpy.data.scenes:
        other = find_controller(each)
        if other is None:
            continue
        if not relevant(each).isdisjoint(ids):
            target_samples.mark_dirty()
            other.mark_dirty()


def _undone(*_: object) -> None:
    """Undo and redo point back to manifests and frames that are known: no timer, no worker."""
    target_samples.mark_dirty()
    read = []
    for scene in bpy.data.scenes:
        controller = find_controller(scene)
        if controller is not None:
            stop_live(scene, controller, may_key=False)
            if _waits(scene):
                controller.mark_dirty()
                continue
            with reading():
                reconcile(scene, controller)
            read.append((scene, controller))
    for scene, controller in read:
        notify_listeners(scene, controller)


def _waits(scene: bpy.types.Scene) -> bool:
    """Whether the tissue is made on a thread now, and the timer reads the scene when it is there."""
    return not bpy.app.background and not tissue_is_ready(scene)


def _before_load(*_: object) -> None:
    drop_all()


def _loaded(*_: object) -> None:
    target_samples.mark_dirty()
    for scene in bpy.data.scenes:
        migrate(scene)
        if scene.lappet.tissue.object is None:
            continue
        if scene.library is None:
            scene.lappet.solving.live = False
        controller = controller_of(scene)
        last = scene.lappet.solving.last_plan
        manifest = manifests.find(last, controller.store) if last else None
        if manifest is not None:
            controller.past = [manifest]
            controller.recheck_frames(manifest)
        if not _waits(scene):
            read_now(scene, ask=False)  # a manifest waits for the timer, or for somebody who solves
        if controller.manifest is None:
            controller.mark_dirty()


def _before_save(*_: object) -> None:
    """The file remembers its manifest, so that stale frames are shown when it is opened."""
    for controller in controllers():
        scene = scene_of(controller)
        newest = controller.newest()
        if scene is not None and scene.library is None and newest is not None:
            scene.lappet.solving.last_plan = newest.key


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
    """Add the handlers."""
    for name, handler in _HANDLERS:
        getattr(bpy.app.handlers, name).append(persistent(handler))
    bpy.app.handlers.depsgraph_update_post.insert(0, persistent(_update_begins))
    changes.subscribe(_changed)


def unregister() -> None:
    """Take the handlers away and end the workers."""
    changes.unsubscribe(_changed)
    for name, handler in (*_HANDLERS, ("depsgraph_update_post", _update_begins)):
        handlers = getattr(bpy.app.handlers, name)
        if handler in handlers:
            handlers.remove(handler)
    drop_all()
    workers.close_all()
