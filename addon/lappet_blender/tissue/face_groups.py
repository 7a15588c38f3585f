"""Groups of the tissue's faces: Boolean face attributes "lappet_" + name."""

from __future__ import annotations

import bpy
import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode

from ..model.mesh_values import GROUP, group_faces, group_names
from .edited_mesh import edited_mesh
from .tissue_objects import changeable_mesh


def check_name(name: str) -> None:
    """Raise RefusedError for a name that no face subset of a procedure may have."""
    if not (name.isidentifier() and name.isascii()):
        raise refused(ProblemCode.GROUP_NAME, "", name)


def check_group(obj: bpy.types.Object, name: str) -> None:
    """Raise RefusedError where the object has no such group."""
    if name not in group_names(obj.data):
        known = ", ".join(group_names(obj.data)) or "none"
        raise refused(ProblemCode.GROUP_UNKNOWN, obj.name, name, known=known)


def change_group(obj: bpy.types.Object, name: str, faces: NDArray[np.bool_], action: str) -> int:
    """Add faces (m,) to a group, remove them from it, or make them the group; return how many it has then.

    action: "ADD", "REMOVE" or "SET". Raises RefusedError for a name that cannot be, or a mesh that cannot be changed.
    """
    check_name(name)
    changeable_mesh(obj)
    taken = obj.data.attributes.get(GROUP + name)
    if taken is not None and (taken.domain, taken.data_type) != ("FACE", "BOOLEAN"):
        raise refused(ProblemCode.GROUP_ATTRIBUTE, obj.name, GROUP + name)
    count = 0
    if obj.mode == "EDIT":
        with edited_mesh(obj) as work:
            layer = work.faces.layers.bool.get(GROUP + name) or work.faces.layers.bool.new(GROUP + name)
            for face, chosen in zip(work.faces, faces.tolist(), strict=True):
                face[layer] = _after(bool(face[layer]), chosen, action)
                count += face[layer]
        obj.update_from_editmode()
        return count
    attribute = taken or obj.data.attributes.new(GROUP + name, "BOOLEAN", "FACE")
    inside = np.zeros(len(faces), bool)
    attribute.data.foreach_get("value", inside)
    inside = {"ADD": inside | faces, "REMOVE": inside & ~faces, "SET": faces}[action]
    attribute.data.foreach_set("value", np.ascontiguousarray(inside))
    obj.data.update()
    return int(inside.sum())


def _after(before: bool, chosen: bool, action: str) -> bool:
    return {"ADD": before or chosen, "REMOVE": before and not chosen, "SET": chosen}[action]


def remove_group(obj: bpy.types.Object, name: str) -> None:
    """Take a group away; its faces stay. Raises RefusedError where there is none of that name."""
    changeable_mesh(obj)
    check_group(obj, name)
    if obj.mode == "EDIT":
        with edited_mesh(obj) as work:
            work.faces.layers.bool.remove(work.faces.layers.bool[GROUP + name])
        obj.update_from_editmode()
        return
    obj.data.attributes.remove(obj.data.attributes[GROUP + name])
    obj.data.update()


def select_group(obj: bpy.types.Object, name: str, extend: bool) -> int:
    """Select the faces of a group; return how many. Raises RefusedError where there is none of that name."""
    check_group(obj, name)
    if obj.mode == "EDIT":
        with edited_mesh(obj) as work:
            layer = work.faces.layers.bool[GROUP + name]
            faces = list(work.faces)
            if not extend:
                for face in faces:
                    face.select_set(False)
            for face in faces:
                if face[layer]:
                    face.select_set(True)
            work.select_flush_mode()
            return sum(bool(face[layer]) for face in faces)
    count = len(obj.data.polygons)
    inside, selected = np.zeros(count, bool), np.zeros(count, bool)
    obj.data.attributes[GROUP + name].data.foreach_get("value", inside)
    if extend:
        obj.data.polygons.foreach_get("select", selected)
    obj.data.polygons.foreach_set("select", inside | selected)
    obj.data.update()
    return int(inside.sum())


def group_counts(obj: bpy.types.Object) -> list[tuple[str, int]]:
    """The groups and how many faces each has."""
    return [(name, int(group_faces(obj, name).sum())) for name in group_names(obj.data)]
