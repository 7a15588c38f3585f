"""Show the solved skin of a scene: swap the epoch's mesh, set positions and colors, and decorate it.

Everything happens in the scene itself, before Blender evaluates a frame, so that viewports and renders agree.
"""

from __future__ import annotations

import logging

import bpy
import numpy as np
from numpy.typing import NDArray

from lappet.background.manifest import Manifest

from ..look.skin_import import set_attribute
from ..look.skin_material import TRANSLUCENT
from ..model.made_soon import MadeSoon
from ..model.units import mm_per_unit
from ..solving import frames
from ..solving.shown_frame import Shown
from . import hidden_objects
from .color_scale import highest_of, peak_of, scan_frames
from .display_collection import (
    ROLE,
    drop_foreign,
    find_collection,
    find_object,
    has_figure_setup,
    make_collection,
    make_object,
    place,
    set_visible,
)
from .epoch_mesh import find_epoch_mesh, is_large, remove_unused, set_layer_rows, take_epoch_mesh
from .legend import show_legend
from .look_materials import (
    dress,
    keep_own_materials,
    part_material,
    quantity_of,
    skin_materials,
)
from .manifest_source import ManifestSource, fitting
from .skin_colors import color_vertices, soon_flesh
from .skin_decorations import SkinDecorations, Where
from .solid_shading import suit_shading
from .time_slice import TimeSlice

_log = logging.getLogger(__name__)
_said: set[str] = set()
_decorations: dict[int, SkinDecorations] = {}
_boxes: dict[str, NDArray[np.float64]] = {}
_rendering: set[int] = set()
_unfinished: dict[int, TimeSlice] = {}
_making: dict[int, tuple[str, MadeSoon[SkinDecorations]]] = {}
LABEL_SIZE, LABEL_GAP = 5.0, 4.0  # mm


def skin_object(scene: bpy.types.Scene) -> bpy.types.Object | None:
    """The object that shows the solved skin of a scene; None where none is shown."""
    collection = find_collection(scene)
    if collection is None or collection.hide_viewport:
        return None
    skin = find_object(collection, "skin")
    return None if skin is None or skin.hide_viewport else skin


def show(scene: bpy.types.Scene, time: float, soon: bool | None = None) -> None:
    """Show what is known at a time; never raises: what goes wrong is logged once, in one line.

    soon: what takes long is left to `continue_drawing`; None: in a window, unless it renders.
    """
    if scene.library is not None:
        return
    if soon is None:
        soon = not bpy.app.background and not _rendering
    time_slice = TimeSlice(soon)
    _unfinished.pop(scene.session_uid, None)
    try:
        _show(scene, time, time_slice)
        if time_slice.unfinished:
            _unfinished[scene.session_uid] = time_slice
    except Exception as error:  # a handler that raises would stop a render
        line = f"The solved skin of {scene.name} cannot be shown at frame {time:g}: {type(error).__name__}: {error}"
        if line not in _said:
            _said.add(line)
            _log.warning("%s", line, exc_info=_log.isEnabledFor(logging.DEBUG))


def continue_drawing() -> bool:
    """Do a turn of what was put off; whether some is left."""
    scenes = {scene.session_uid: scene for scene in bpy.data.scenes}
    for uid, time_slice in list(_unfinished.items()):
        if uid not in scenes:
            del _unfinished[uid]
        elif all(each.done for each in time_slice.waits_for):
            show(scenes[uid], scenes[uid].frame_current, soon=True)
    return bool(_unfinished)


def refresh_soon(scene: bpy.types.Scene) -> None:
    """`refresh`, and leave to `continue_drawing` what takes long."""
    refresh(scene, soon=True)


def refresh(scene: bpy.types.Scene, soon: bool | None = None) -> None:
    """What is known has changed, or how it is to look: show the current frame anew, here and where it is compared."""
    if scene.library is not None:
        return
    drop_foreign(scene)
    _frames_changed(scene)
    _scan(scene)
    show(scene, scene.frame_current, soon)
    suit_shading(scene, find_collection(scene))
    for other in bpy.data.scenes:
        if other != scene and other.lappet.compare_with == scene and other.library is None:
            _scan(other)
            show(other, other.frame_current, soon)


def refresh_all() -> None:
    """`refresh` every scene (after loading, undo or redo), and let go of meshes that no manifest needs."""
    for scene in bpy.data.scenes:
        refresh(scene)
    tidy()


def tidy() -> None:
    """Remove epoch meshes that no object shows and no known manifest holds."""
    remove_unused({e.key for decorations in _decorations.values() for e in decorations.source.manifest.epochs})


def clear_all() -> None:
    """Before another file is loaded: nothing that is kept here belongs to it."""
    _decorations.clear()
    _making.clear()
    _said.clear()
    _unfinished.clear()


def stop() -> None:
    """The extension is taken away: nothing of it runs on."""
    if bpy.app.timers.is_registered(_scan_on):
        bpy.app.timers.unregister(_scan_on)
    clear_all()


def events_changed(scene: bpy.types.Scene) -> None:
    """The events of a scene may have changed; marks on the skin follow."""
    decorations = _decorations.get(scene.session_uid)
    if decorations is not None:
        decorations.events_changed(scene)


def prepare_render(scene: bpy.types.Scene) -> None:
    """Before a render: the scale knows all frames, and the objects are there; from now on nothing is put off."""
    if scene.library is None:
        _rendering.add(scene.session_uid)
        _scan(scene, patient=True)
        show(scene, scene.frame_current)


def render_ended(scene: bpy.types.Scene) -> None:
    """After a render, finished or cancelled."""
    _rendering.discard(scene.session_uid)


def is_decorated(scene: bpy.types.Scene, shown: Shown) -> bool:
    """Whether what the skin of a scene wears was made for the manifest of what is shown."""
    before = _decorations.get(scene.session_uid)
    return before is not None and before.source.manifest.key == shown.manifest.key


def decorations_of(scene: bpy.types.Scene, shown: Shown) -> SkinDecorations:
    """What the skin of a scene wears, for the manifest of what is shown."""
    before = _decorations.get(scene.session_uid)
    if before is not None and before.source.manifest.key == shown.manifest.key:
        return before

    key, soon = _making.pop(scene.session_uid, ("", None))
    made = soon.take() if soon is not None and key == shown.manifest.key else None
    if made is None:
        made = SkinDecorations(_source_of(scene, shown), before)
    else:
        made.source.read_events(scene)
    _decorations[scene.session_uid] = made
    return made


def _is_made(scene: bpy.types.Scene, shown: Shown, time_slice: TimeSlice) -> bool:
    """Whether `decorations_of` answers at once; what it waits for is begun on a thread where somebody looks on."""
    before = _decorations.get(scene.session_uid)
    if not time_slice.soon or not is_large(shown.epoch):
        return True
    if before is not None and before.fits(shown.manifest):
        return True
    making = _making.get(scene.session_uid)
    if making is None or making[0] != shown.manifest.key:
        source = _source_of(scene, shown)
        making = shown.manifest.key, MadeSoon(lambda: SkinDecorations(source))
        _making[scene.session_uid] = making
    return time_slice.has(making[1])


def _source_of(scene: bpy.types.Scene, shown: Shown) -> ManifestSource:
    uid = scene.session_uid  # undo replaces the scene's data: it is looked for anew each time

    def lookup(time: int) -> object:
        scene = next((each for each in bpy.data.scenes if each.session_uid == uid), None)
        if scene is None:
            return None
        if frames.frame_state(scene, time) != "solved":
            return None
        found = frames.shown_at(scene, time)
        same = found is not None and found.manifest.key == shown.manifest.key and found.time == time and not found.stale
        return found.frame if found is not None and same else None

    return ManifestSource(shown.manifest, scene, lookup)  # type: ignore[arg-type]


def shown_of(scene: bpy.types.Scene, time: float) -> Shown | None:
    """What the scene's look wants shown at a time: None where the tissue itself is to be seen."""
    tissue = scene.lappet.tissue.object
    if not scene.lappet.look.show_solved or tissue is None or tissue.mode != "OBJECT":
        return None
    return frames.shown_at(scene, time)


def _show(scene: bpy.types.Scene, time: float, time_slice: TimeSlice) -> None:
    shown = shown_of(scene, time)
    collection = find_collection(scene) if shown is None else make_collection(scene)
    if collection is None or shown is None:
        _show_tissue(scene, collection)
        return
    set_visible(collection, True)
    units, look = 1.0 / mm_per_unit(scene), scene.lappet.look
    other = _compared(scene, time)
    quantity = quantity_of(look)
    manifests = [shown.manifest] if other is None else [shown.manifest, other[1].manifest]
    if quantity is not None:
        _take_peak(scene, shown, quantity)
        if other is not None:
            _take_peak(other[0], other[1], quantity)
    highest = highest_of(manifests, quantity) if quantity else 1.0
    skin = _draw_skin(scene, Where(collection, "", units, (0.0, 0.0, 0.0)), shown, look, highest, time_slice)
    if skin is None:
        return
    if scene.lappet.skin != skin:
        scene.lappet.skin = skin
    box = rest_box(shown.manifest)
    if other is None:
        _hide_others(collection)
    else:
        beside = rest_box(other[1].manifest)
        gap = offset_of(scene, box, beside)
        where = Where(collection, "other ", units, (gap * units, 0.0, 0.0))
        _draw_skin(other[0], where, other[1], look, highest, time_slice)
        beside = beside + np.array([gap, 0.0, 0.0])
        paper = has_figure_setup(scene)
        _label(collection, "label", scene.name, box, units, paper)
        _label(collection, "other label", other[0].name, beside, units, paper)
        box = np.stack([np.minimum(box[0], beside[0]), np.maximum(box[1], beside[1])])
    show_legend(scene, collection, quantity if look.show_legend else None, highest, box * units)
    _hide_tissue(scene)
    if not scene.render.use_lock_interface:
        scene.render.use_lock_interface = True


def _draw_skin(
    source_scene: bpy.types.Scene,
    where: Where,
    shown: Shown,
    look: bpy.types.PropertyGroup,
    highest: float,
    time_slice: TimeSlice,
) -> bpy.types.Object | None:
    """Show a skin; source_scene: whose procedure it is. None where its first picture was put off."""
    role = f"{where.prefix}skin"
    before = find_object(where.collection, role)
    if before is not None and before.mode != "OBJECT":
        return before  # somebody edits it: what they do is lost at the next frame, but not under their hands
    if before is not None and before.type == "MESH":
        keep_own_materials(where.collection, before.data)
    layers = shown.manifest.layers
    opacity = TRANSLUCENT if look.show_through else 1.0
    materials = skin_materials(
        where.collection, look.color, highest, where.units, layers, opacity, where.prefix, time_slice
    )
    if materials is None:
        return before
    shape, frame = shown.epoch, fitting(shown.frame, shown.epoch)
    current = before.data if before is not None and before.type == "MESH" else None
    known = find_epoch_mesh(shape, look.show_walls, current)
    colors = soon_flesh(shape, layers) if known is None and time_slice.soon and is_large(shape) else None
    mesh = take_epoch_mesh(shape, look.show_walls, where.units, current, time_slice)
    if mesh is None or not (colors is None or time_slice.has(colors)):
        return before
    skin = make_object(where.collection, role, "Lappet skin" if not where.prefix else "Lappet skin beside")
    if skin.data != mesh:
        old, skin.data = skin.data, mesh
        if old is not None and old.users == 0 and len(old.vertices) == 0:
            bpy.data.meshes.remove(old)
    points = shape.rest if frame is None else frame.points
    moved = (points * np.float32(where.units)).astype(np.float32)
    mesh.attributes["position"].data.foreach_set("vector", moved.ravel())
    quantity = quantity_of(look)
    values = None
    if quantity is not None:
        found = None if frame is None else frame.scalar(quantity)
        values = np.zeros(len(points), np.float32) if found is None else found
        set_attribute(mesh, "quantity", "FLOAT", "POINT", values.astype(np.float32, copy=False))
    set_layer_rows(mesh, shape, layers)
    color_vertices(mesh, shape, layers, values, highest)
    if dress(mesh, materials, look.color, where.prefix):
        set_attribute(mesh, "material_index", "INT", "FACE", _origins(mesh))
    mesh.update()
    place(skin, where.offset)
    set_visible(skin, True)
    if skin.hide_select:
        skin.hide_select = False
    made = known is None and is_large(shape)  # its colors too are a costly piece
    decorated = is_decorated(source_scene, shown) or _is_made(source_scene, shown, time_slice)
    if decorated and time_slice.begins(made or not is_decorated(source_scene, shown)):
        decorations = decorations_of(source_scene, shown)
        decorations.source.at(float(shown.time), shape, shown.frame)
        decorations.draw(where, float(shown.time), look, time_slice)
    return skin


def _origins(mesh: bpy.types.Mesh) -> NDArray[np.int32]:
    origin = np.empty(len(mesh.polygons), np.int32)
    mesh.attributes["origin"].data.foreach_get("value", origin)
    return origin


def _compared(scene: bpy.types.Scene, time: float) -> tuple[bpy.types.Scene, Shown] | None:
    other = scene.lappet.compare_with
    if other is None or other == scene:
        return None
    shown = frames.shown_at(other, time)
    return None if shown is None else (other, shown)


def _take_peak(scene: bpy.types.Scene, shown: Shown, quantity: str) -> None:
    if shown.stale or shown.frame is None or frames.progress_of(scene).live:
        return
    key = next((f.key for f in shown.manifest.frames if f.time == shown.time), None)
    if key is not None:
        peak_of(key, quantity, shown.frame)


def rest_box(manifest: Manifest) -> NDArray[np.float64]:
    """Lowest and highest corner (2, 3) of the tissue at rest, mm; of the first epoch, so that nothing jumps."""
    shape = manifest.epochs[0]
    if shape.key not in _boxes:
        if len(_boxes) > 64:
            _boxes.clear()
        _boxes[shape.key] = np.stack([shape.rest.min(axis=0), shape.rest.max(axis=0)]).astype(np.float64)
    return _boxes[shape.key].copy()


def offset_of(scene: bpy.types.Scene, own: NDArray[np.float64], theirs: NDArray[np.float64]) -> float:
    """How far along x the other skin is moved to lie beside a scene's own, mm; boxes (2, 3) at rest."""
    return float(own[1][0] - theirs[0][0]) + float(scene.lappet.compare_gap)


def _label(
    collection: bpy.types.Collection, role: str, words: str, box: NDArray[np.float64], units: float, paper: bool
) -> None:
    """paper: it is read before the light paper of a figure, not before a dark viewport."""
    text = make_object(collection, role, "Lappet label", "FONT")
    if text.data.body != words:
        text.data.body = words
    if text.data.align_x != "CENTER":
        text.data.align_x, text.data.align_y = "CENTER", "BOTTOM"
        text.data.materials.append(None)
        text.hide_select = True
    ink = part_material(collection, "legend ink" if paper else "label", 1.0)
    if text.data.materials[0] != ink:
        text.data.materials[0] = ink
    if text.data.size != np.float32(LABEL_SIZE * units):
        text.data.size = LABEL_SIZE * units
    low, high = box * units
    place(text, (float(0.5 * (low[0] + high[0])), float(high[1] + LABEL_GAP * units), float(high[2])))
    set_visible(text, True)


def _hide_others(collection: bpy.types.Collection) -> None:
    for each in collection.objects:
        if str(each.get(ROLE, "")).startswith("other ") or each.get(ROLE) == "label":
            set_visible(each, False)


def _show_tissue(scene: bpy.types.Scene, collection: bpy.types.Collection | None) -> None:
    if collection is not None:
        set_visible(collection, False)
    if scene.lappet.tissue.object is not None:
        hidden_objects.bring_back(scene.lappet.tissue.object)
    _show_bones(scene)


def _hide_tissue(scene: bpy.types.Scene) -> None:
    hidden_objects.hide(scene.lappet.tissue.object)
    _show_bones(scene)


def _show_bones(scene: bpy.types.Scene) -> None:
    for bone in scene.lappet.bones:
        if bone.object is not None:
            (hidden_objects.bring_back if scene.lappet.look.show_bone else hidden_objects.hide)(bone.object)


def _frames_changed(scene: bpy.types.Scene) -> None:
    decorations = _decorations.get(scene.session_uid)
    if decorations is not None and not frames.progress_of(scene).running:
        decorations.frames_changed()


def _scan(scene: bpy.types.Scene, patient: bool | None = None) -> None:
    """Read what frames ask of the color scale; in a window only a few at a time, and the rest soon."""
    quantity = quantity_of(scene.lappet.look)
    if quantity is None:
        return
    if patient is None:
        patient = bpy.app.background
    done = True
    for each in (scene, scene.lappet.compare_with):
        manifest = None if each is None else frames.manifest_of(each)
        if manifest is not None:
            done &= scan_frames(each, manifest, quantity, patient)
    if not done and not bpy.app.timers.is_registered(_scan_on):
        bpy.app.timers.register(_scan_on, first_interval=0.05)


def _scan_on() -> None:
    for scene in bpy.data.scenes:
        if scene.library is None and quantity_of(scene.lappet.look) is not None:
            _scan(scene)
            show(scene, scene.frame_current)
