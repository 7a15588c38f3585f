"""A defect marked on the tissue's mesh: selected faces, a vertex group, a group of faces or a face attribute."""

from __future__ import annotations

import bpy
import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.marked_faces import marked_outline
from lappet.procedure import Tissue
from lappet.tissue.surface import skin_faces

from ..model.mesh_values import GROUP, MeshValues, mesh_values
from ..tissue.face_choice import chosen_faces
from ..tissue.tissue_objects import tissue_object

_PAINTED = 0.5  # weight from which a point of a vertex group belongs to it


def marked_outline_of(scene: bpy.types.Scene, selection: bool, region: str) -> NDArray[np.float64] | None:
    """The outline of what is marked on the tissue, (n, 3) in mm; None where nothing is asked for.

    selection: whether the selected faces are meant, else what is called `region`. Raises RefusedError for a choice of
    no face of the skin, of several pieces, and for a name that the mesh does not have.
    """
    if not selection and not region:
        return None
    obj = tissue_object(scene)
    mesh = mesh_values(scene, obj)
    chosen = chosen_faces(scene, obj, "", "SELECTED") if selection else _named_faces(obj, region)
    return marked_outline(
        mesh.points, mesh.counts, mesh.indices, chosen & _skin(scene, mesh), obj.name if selection else region
    )


def _named_faces(obj: bpy.types.Object, name: str) -> NDArray[np.bool_]:
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


def _skin(scene: bpy.types.Scene, mesh: MeshValues) -> NDArray[np.bool_]:
    """The faces (m,) that are outer skin: all of an open surface that is thickened."""
    groups = {} if scene.lappet.tissue.thicken else mesh.groups
    return skin_faces(Tissue(mesh.points, mesh.counts, mesh.indices, subsets=groups))
