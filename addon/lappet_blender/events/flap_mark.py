"""A defect marked on the tissue's mesh: selected faces, a vertex group, a group of faces or a face attribute."""

from __future__ import annotations

import bpy
import numpy as np
from numpy.typing import NDArray

from lappet.designs.marked_faces import marked_outline
from lappet.procedure import Tissue
from lappet.tissue.surface import skin_faces

from ..model.mesh_values import MeshValues, mesh_values
from ..tissue.face_choice import chosen_faces, named_faces
from ..tissue.tissue_objects import tissue_object


def marked_outline_of(scene: bpy.types.Scene, selection: bool, region: str) -> NDArray[np.float64] | None:
    """The outline of what is marked on the tissue, (n, 3) in mm; None where nothing is asked for.

    selection: whether the selected faces are meant, else what is called `region`. Raises RefusedError for a choice of
    no face of the skin, of several pieces, and for a name that the mesh does not have.
    """
    if not selection and not region:
        return None
    obj = tissue_object(scene)
    mesh = mesh_values(scene, obj)
    chosen = chosen_faces(scene, obj, "", "SELECTED") if selection else named_faces(obj, region)
    return marked_outline(
        mesh.points, mesh.counts, mesh.indices, chosen & _skin(scene, mesh), obj.name if selection else region
    )


def _skin(scene: bpy.types.Scene, mesh: MeshValues) -> NDArray[np.bool_]:
    """The faces (m,) that are outer skin: all of an open surface that is thickened."""
    groups = {} if scene.lappet.tissue.thicken else mesh.groups
    return skin_faces(Tissue(mesh.points, mesh.counts, mesh.indices, subsets=groups))
