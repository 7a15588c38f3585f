"""The collection in which a scene's display lies: one per scene, made when first needed.

It never holds what cannot be made again. Objects are found by their role and materials by pointers on the collection,
so that renaming is harmless and an undo, a deletion or a copied scene costs no more than making them anew.

Frames arrive when they like, so all of it is made outside of undo steps. Blender takes what two steps have in common as
it is in memory, with its pointers to what was made in between and is freed: it crashes on a collection with such an
object. So the display is taken away before an undo, and made again after it.
"""

from __future__ import annotations

import bpy

OWNER = "lappet_scene"
ROLE = "lappet_role"
STAGE_OWNER = "lappet_stage"
NAME = "Lappet display"
# What was set on the collections that were taken away, by scene: values, and the names of the user's own materials.
_taken: dict[int, dict[str, float | str]] = {}
_worn: dict[int, dict[str, str]] = {}


def find_collection(scene: bpy.types.Scene) -> bpy.types.Collection | None:
    """The display collection that belongs to a scene, or None."""
    for child in scene.collection.children:
        if OWNER in child and child[OWNER] == scene:
            return child
    return None


def has_figure_setup(scene: bpy.types.Scene) -> bool:
    """Whether the scene has the paper, light and camera of a figure."""
    return any(STAGE_OWNER in child and child[STAGE_OWNER] == scene for child in scene.collection.children)


def make_collection(scene: bpy.types.Scene) -> bpy.types.Collection:
    """The display collection of a scene, made if it is missing; one that a copied scene brought along is let go."""
    collection = find_collection(scene)
    if collection is None:
        drop_foreign(scene)
        collection = bpy.data.collections.new(NAME)
        collection[OWNER] = scene
        for key, value in _taken.pop(scene.session_uid, {}).items():
            collection[key] = value
        for key, name in _worn.pop(scene.session_uid, {}).items():
            if name in bpy.data.materials:
                collection[key] = bpy.data.materials[name]
        scene.collection.children.link(collection)
    return collection


def take_away(scene: bpy.types.Scene) -> None:
    """Delete the display of a scene before an undo or redo; one that is edited stays, for that undoes the edit."""
    collection = find_collection(scene)
    if collection is None or any(each.mode != "OBJECT" for each in collection.objects):
        return
    values = {key: value for key, value in collection.items() if key != OWNER}
    _taken[scene.session_uid] = {key: value for key, value in values.items() if isinstance(value, float | str)}
    _worn[scene.session_uid] = {
        key: value.name
        for key, value in values.items()
        if key.startswith("own ") and isinstance(value, bpy.types.Material)
    }
    bpy.data.batch_remove([*collection.objects, collection])


def drop_foreign(scene: bpy.types.Scene) -> None:
    """Unlink display collections that belong to other scenes (a linked copy of a scene has them)."""
    for child in list(scene.collection.children):
        if OWNER in child and child[OWNER] != scene:
            scene.collection.children.unlink(child)


def find_object(collection: bpy.types.Collection, role: str) -> bpy.types.Object | None:
    """The object of a role, or None."""
    for each in collection.objects:
        if each.get(ROLE) == role:
            return each
    return None


def make_object(collection: bpy.types.Collection, role: str, name: str, kind: str = "MESH") -> bpy.types.Object:
    """The object of a role, made if it is missing or is of another kind (MESH or FONT)."""
    found = find_object(collection, role)
    if found is not None and found.type == kind:
        return found
    if found is not None:
        bpy.data.objects.remove(found)
    data = bpy.data.meshes.new(name) if kind == "MESH" else bpy.data.curves.new(name, "FONT")
    made = bpy.data.objects.new(name, data)
    made[ROLE] = role
    collection.objects.link(made)
    return made


def remove_object(collection: bpy.types.Collection, role: str) -> None:
    """Delete the object of a role and its data; none is no error."""
    found = find_object(collection, role)
    if found is not None:
        data = found.data
        bpy.data.objects.remove(found)
        if data is not None and data.users == 0:
            bpy.data.batch_remove([data])


def set_visible(each: bpy.types.Object | bpy.types.Collection, visible: bool) -> None:
    """Show or hide in viewports and renders; what is so already is not touched."""
    if each.hide_viewport == visible:
        each.hide_viewport = not visible
    if each.hide_render == visible:
        each.hide_render = not visible


def place(each: bpy.types.Object, location: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> None:
    """Put an object where the display wants it, whatever was done to it.

    It then has no parent and is neither turned nor scaled.
    """
    if each.parent is not None:
        each.parent = None
    if tuple(each.location) != location:
        each.location = location
    if each.rotation_mode != "XYZ":
        each.rotation_mode = "XYZ"
    if any(each.rotation_euler):
        each.rotation_euler = (0.0, 0.0, 0.0)
    if tuple(each.scale) != (1.0, 1.0, 1.0):
        each.scale = (1.0, 1.0, 1.0)
    if any(each.delta_location):
        each.delta_location = (0.0, 0.0, 0.0)
