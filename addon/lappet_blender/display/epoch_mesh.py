"""One mesh datablock per epoch and shown skin: topology, texture coordinates and rest positions, set once.

A mesh that no object uses is free for any skin of the same epoch: whoever shows it sets its positions. Two skins that
show one epoch at once (variants side by side) therefore have one each.
"""

from __future__ import annotations

from collections.abc import Collection

import bpy
import numpy as np

from lappet.anatomy.tissue_layers import TissueLayers
from lappet.background.manifest import EpochShape
from lappet.drawing.skin_fields import WOUND_WALL

from ..look.layer_image import ROW, layer_rows
from ..look.skin_import import build_mesh, mark_sharp_borders, set_attribute
from ..look.solid_texture import TILE, lay

KEY = "lappet_epoch"
_ROWS_FOR = "lappet_layer_rows"


def take_epoch_mesh(shape: EpochShape, walls: bool, units: float, current: bpy.types.Mesh | None) -> bpy.types.Mesh:
    """The mesh of an epoch for an object that now shows `current`: that, a free one, or a new one.

    walls: whether it has the faces of wound walls. units: Blender units per mm, of a new one's positions.
    """
    found = find_epoch_mesh(shape, walls, current)
    return build_epoch_mesh(shape, walls, units) if found is None else found


def find_epoch_mesh(shape: EpochShape, walls: bool, current: bpy.types.Mesh | None) -> bpy.types.Mesh | None:
    """The mesh that `take_epoch_mesh` takes, None where it must make one."""
    key = shape.key if walls else f"{shape.key} without walls"
    if current is not None and current.get(KEY) == key and current.users == 1 and _whole(current, shape):
        return current
    name = mesh_name(shape)
    for mesh in bpy.data.meshes:
        if mesh.users == 0 and mesh.name.startswith(name) and mesh.get(KEY) == key and _whole(mesh, shape):
            return mesh
    return None


def mesh_name(shape: EpochShape) -> str:
    """What the meshes of an epoch are called."""
    return f"Lappet {shape.key[:12]}"


def _whole(mesh: bpy.types.Mesh, shape: EpochShape) -> bool:
    """Whether nobody edited the mesh."""
    return len(mesh.vertices) == len(shape.rest) and not mesh.is_editmode and "rest" in mesh.attributes


def build_epoch_mesh(shape: EpochShape, walls: bool = True, units: float = 0.001) -> bpy.types.Mesh:
    """Make the mesh of an epoch at rest.

    Its attributes are `rest`, `origin`, `face`, `grid`, `depth` and `quantity`, and `UVMap` in tiles of `TILE` mm.
    """
    kept = slice(None) if walls else shape.origin != WOUND_WALL
    triangles, origin, grid = shape.triangles[kept], shape.origin[kept], shape.grid[kept]
    mesh = build_mesh(mesh_name(shape), shape.rest, triangles, units)
    mesh[KEY] = shape.key if walls else f"{shape.key} without walls"
    set_attribute(mesh, "material_index", "INT", "FACE", origin.astype(np.int32))
    mark_sharp_borders(mesh, origin)
    set_attribute(mesh, "rest", "FLOAT_VECTOR", "POINT", shape.rest)
    set_attribute(mesh, "depth", "FLOAT", "POINT", shape.depth)
    set_attribute(mesh, "quantity", "FLOAT", "POINT", np.zeros(len(shape.rest), np.float32))
    set_attribute(mesh, "origin", "INT", "FACE", origin.astype(np.int32))
    set_attribute(mesh, "face", "INT", "FACE", shape.face[kept].astype(np.int32))
    set_attribute(mesh, "grid", "FLOAT2", "CORNER", grid)
    lay(mesh, grid.reshape(-1, 2) / TILE)
    return mesh


def set_layer_rows(mesh: bpy.types.Mesh, shape: EpochShape, layers: TissueLayers) -> None:
    """Set where each face's column of layers lies in the picture of the layers that its materials look up."""
    made_for = f"{layers.columns}"
    if mesh.get(_ROWS_FOR) == made_for:
        return
    column = shape.column if len(shape.column) else np.zeros(len(shape.triangles), np.int32)
    if len(mesh.polygons) != len(column):
        column = column[shape.origin != WOUND_WALL]
    set_attribute(mesh, ROW, "FLOAT", "FACE", layer_rows(layers, column))
    mesh[_ROWS_FOR] = made_for


def remove_unused(keys: Collection[str]) -> None:
    """Remove free epoch meshes, but for those of the given epochs (`EpochShape.key`)."""
    free = [m for m in bpy.data.meshes if m.users == 0 and KEY in m and str(m[KEY]).split(" ")[0] not in keys]
    if free:
        bpy.data.batch_remove(free)
