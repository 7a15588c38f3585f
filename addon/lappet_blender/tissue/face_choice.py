"""Which faces of a mesh are meant: a list, the selection, or those on one side."""

from __future__ import annotations

import bpy
import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode

from ..model.mesh_values import GROUP, mesh_values
from ..model.surface_border import directed_edges
from ..model.world_matrix import world_matrix

_PAINTED = 0.5  # weight from which a point of a vertex group belongs to it
_STEEP = 0.5  # of a normal's height: below this a face is a side

WHICH = (
    ("SELECTED", "Selected", "The selected faces"),
    ("ALL", "All", "Every face"),
    ("TOP", "Top", "Faces that point up"),
    ("BOTTOM", "Bottom", "Faces that point down"),
    ("SIDES", "Sides", "Faces that point sideways"),
    ("BOUNDARY", "Border", "Faces at the border of an open surface"),
)
_CHOSEN = {
    "SELECTED": "is selected",
    "ALL": "is there",
    "TOP": "faces up",
    "BOTTOM": "faces down",
    "SIDES": "faces sideways",
    "BOUNDARY": "lies at a border: the surface is closed",
}


def chosen_faces(scene: bpy.types.Scene, obj: bpy.types.Object, faces: str, which: str) -> NDArray[np.bool_]:
    """The faces, (m,), that a list of indices ("0,1,5-9") names, or where that is empty those that `which` says.

    Raises RefusedError for what is no list, a face that is not there, and a choice of none.
    """
    if obj.mode == "EDIT":
        obj.update_from_editmode()
    count = len(obj.data.polygons)
    if faces.strip():
        return _listed(obj.name, count, faces)
    chosen = np.zeros(count, bool)
    if which == "SELECTED":
        obj.data.polygons.foreach_get("select", chosen)
    elif which == "ALL":
        chosen[:] = True
    elif which == "BOUNDARY":
        chosen = _at_border(scene, obj)
    else:
        height = _heights(obj)
        chosen = {"TOP": height >= _STEEP, "BOTTOM": height <= -_STEEP, "SIDES": np.abs(height) < _STEEP}[which]
    if not chosen.any():
        raise refused(ProblemCode.FACES_NONE, obj.name, _CHOSEN[which], count=count)
    return chosen


def named_faces(obj: bpy.types.Object, name: str) -> NDArray[np.bool_]:
    """The faces (m,) of a vertex group, a group of faces or a face attribute: where it is not 0."""
    if obj.mode == "EDIT":
        obj.update_from_editmode()
    mesh = obj.data
    group = obj.vertex_groups.get(name)
    if group is not None:
        inside = np.array(
            [any(g.group == group.index and g.weight >= _PAINTED for g in v.groups) for v in mesh.vertices]
        )
        return np.array([all(inside[k] for k in face.vertices) for face in mesh.polygons], bool)
    attribute = mesh.attributes.get(GROUP + name) or mesh.attributes.get(name)
    if (
        attribute is None
        or attribute.domain != "FACE"
        or attribute.data_type not in ("BOOLEAN", "INT", "INT8", "FLOAT")
    ):
        known = [each.name for each in obj.vertex_groups]
        known += [each.name.removeprefix(GROUP) for each in mesh.attributes if each.domain == "FACE"]
        raise refused(ProblemCode.DESIGN_REGION_UNKNOWN, obj.name, name, known=", ".join(known) or "none")
    values = np.zeros(len(mesh.polygons), {"BOOLEAN": bool, "FLOAT": np.float32}.get(attribute.data_type, np.int32))
    attribute.data.foreach_get("value", values)
    return np.asarray(values != 0)


def _listed(name: str, count: int, faces: str) -> NDArray[np.bool_]:
    chosen = np.zeros(count, bool)
    for part in faces.replace(" ", "").split(","):
        first, _, last = part.partition("-")
        if not first.isdigit() or not (last or first).isdigit():
            raise refused(ProblemCode.FACES_TEXT, name, part)
        low, high = int(first), int(last or first)
        if not low <= high < count:
            raise refused(ProblemCode.FACES_RANGE, name, part, count=count, last=count - 1)
        chosen[low : high + 1] = True
    return chosen


def _heights(obj: bpy.types.Object) -> NDArray[np.float64]:
    """How far up (1) or down (-1) each face looks in the world."""
    normals = np.empty(3 * len(obj.data.polygons), np.float32)
    obj.data.polygons.foreach_get("normal", normals)
    turn = np.array(world_matrix(obj).to_3x3().inverted_safe().transposed())
    world = normals.reshape(-1, 3) @ turn.T
    return np.asarray(world[:, 2] / np.maximum(np.linalg.norm(world, axis=1), 1e-30))


def _at_border(scene: bpy.types.Scene, obj: bpy.types.Object) -> NDArray[np.bool_]:
    mesh = mesh_values(scene, obj)
    edges = np.sort(directed_edges(mesh), axis=1)
    _, inverse, uses = np.unique(edges, axis=0, return_inverse=True, return_counts=True)
    face = np.repeat(np.arange(len(mesh.counts)), mesh.counts)
    chosen = np.zeros(len(mesh.counts), bool)
    chosen[face[uses[inverse.reshape(-1)] == 1]] = True
    return chosen
