"""What Blender shows of a mesh in edit mode through its bmesh alone: layers of faces and corners."""

from __future__ import annotations

import bmesh
import bpy
import numpy as np
from numpy.typing import NDArray


def edited_group(mesh: bpy.types.Mesh, name: str) -> NDArray[np.bool_]:
    """A Boolean face attribute, (m,), of a mesh in edit mode."""
    work = bmesh.from_edit_mesh(mesh)
    layer = work.faces.layers.bool.get(name)
    if layer is None:
        return np.zeros(len(work.faces), bool)
    return np.fromiter((face[layer] for face in work.faces), bool, len(work.faces))


def edited_uv(mesh: bpy.types.Mesh) -> NDArray[np.float32]:
    """The active texture coordinates, (2k,), of a mesh in edit mode. About 50 ms at 80 000 corners."""
    work = bmesh.from_edit_mesh(mesh)
    layer = work.loops.layers.uv.active
    values = [loop[layer].uv for face in work.faces for loop in face.loops]
    return np.array(values, np.float32).reshape(-1)
