"""A mesh to change, in edit mode or not, as one bmesh."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import bmesh
import bpy

from .tissue_objects import changeable_mesh


@contextmanager
def edited_mesh(obj: bpy.types.Object) -> Iterator[bmesh.types.BMesh]:
    """The object's mesh as a bmesh that is written back at the end. Raises RefusedError for a linked mesh."""
    mesh = changeable_mesh(obj)
    if obj.mode == "EDIT":
        work = bmesh.from_edit_mesh(mesh)
        yield work
        bmesh.update_edit_mesh(mesh)
        return
    work = bmesh.new()
    try:
        work.from_mesh(mesh)
        yield work
        work.to_mesh(mesh)
        mesh.update()
    finally:
        work.free()
