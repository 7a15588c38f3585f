"""One mesh datablock per epoch and shown skin: topology, texture coordinates and rest positions, set once.

A mesh that no object uses is free for any skin of the same epoch: whoever shows it sets its positions. Two skins that
show one epoch at once (variants side by side) therefore have one each.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from functools import partial

import bpy
import numpy as np
from numpy.typing import NDArray

from lappet.anatomy.tissue_layers import TissueLayers
from lappet.background.manifest import EpochShape
from lappet.drawing.skin_fields import WOUND_WALL

from ..look.layer_image import ROW, layer_rows
from ..look.mesh_edges import MeshEdges, between_kinds, mesh_edges
from ..look.skin_import import build_mesh, set_attribute
from ..look.solid_texture import TILE, lay
from ..model.made_soon import MadeSoon
from .time_slice import TimeSlice

KEY = "lappet_epoch"
_ROWS_FOR = "lappet_layer_rows"


@dataclass(frozen=True, eq=False)
class EpochArrays:
    """What is found out before a mesh is made of an epoch.

    triangles, origin, face: (m, 3), (m,), (m,), of those that are shown. edges, sharp: theirs, (e,). grid, tiles:
    (3m, 2), places on the grid in mm and on its picture.
    """

    triangles: NDArray[np.int32]
    origin: NDArray[np.int32]
    edges: MeshEdges
    sharp: NDArray[np.bool_]
    face: NDArray[np.int32]
    grid: NDArray[np.float32]
    tiles: NDArray[np.float32]


_LARGE = 8000  # triangles from which on arrays are found on a thread where somebody looks on
_MOST_KEPT = 8
_arrays: OrderedDict[tuple[str, bool], MadeSoon[EpochArrays]] = OrderedDict()
_building: dict[tuple[str, bool, float], Iterator[bpy.types.Mesh | None]] = {}


def soon_arrays(shape: EpochShape, walls: bool) -> MadeSoon[EpochArrays]:
    """The arrays of an epoch's mesh, begun on a thread where they are not known."""
    key = (shape.key, walls)
    if key not in _arrays:
        _arrays[key] = MadeSoon(partial(epoch_arrays, shape, walls))
    _arrays.move_to_end(key)
    while len(_arrays) > _MOST_KEPT:
        _arrays.popitem(last=False)
    return _arrays[key]


def is_large(shape: EpochShape) -> bool:
    """Whether somebody who looks on would notice how long its mesh takes."""
    return len(shape.triangles) >= _LARGE


def epoch_arrays(shape: EpochShape, walls: bool = True) -> EpochArrays:
    """Find out what a mesh of an epoch needs; touches nothing of Blender's."""
    kept = np.ones(len(shape.triangles), bool) if walls else shape.origin != WOUND_WALL
    triangles, origin = np.ascontiguousarray(shape.triangles[kept], np.int32), shape.origin[kept].astype(np.int32)
    edges = mesh_edges(triangles, len(shape.rest))
    sharp = between_kinds(edges.of_corner, len(edges.ends), origin)
    face, grid = shape.face[kept].astype(np.int32), shape.grid[kept].reshape(-1, 2)
    return EpochArrays(triangles, origin, edges, sharp, face, grid, (grid / TILE).astype(np.float32))


def take_epoch_mesh(
    shape: EpochShape, walls: bool, units: float, current: bpy.types.Mesh | None, time_slice: TimeSlice
) -> bpy.types.Mesh | None:
    """The mesh of an epoch for an object that now shows `current`: that, a free one, or a new one.

    walls: whether it has the faces of wound walls. units: Blender units per mm, of a new one's positions. None where a
    new one is put off or not finished in this turn.
    """
    found = find_epoch_mesh(shape, walls, current)
    if found is not None:
        return found
    if time_slice.soon and is_large(shape):
        return _built_in_turns(shape, walls, units, time_slice)
    return build_epoch_mesh(shape, walls, units) if time_slice.begins() else None


def _built_in_turns(shape: EpochShape, walls: bool, units: float, time_slice: TimeSlice) -> bpy.types.Mesh | None:
    """The mesh of an epoch once its arrays are found and all its pieces are made; until then None."""
    key = (shape.key, walls, units)
    if key not in _building:
        arrays = soon_arrays(shape, walls)
        if not time_slice.has(arrays):
            return None
        _building.clear()
        _building[key] = _pieces(shape, walls, units, _arrays.pop((shape.key, walls), arrays).take())
    while time_slice.begins():
        try:
            mesh = next(_building[key])
        except ReferenceError:  # undo took it away half made
            del _building[key]
            time_slice.unfinished = True
            return None
        if mesh is not None:
            del _building[key]
            return mesh
    return None


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
    arrays = epoch_arrays(shape, walls)
    return next(mesh for mesh in _pieces(shape, walls, units, arrays) if mesh is not None)


def _pieces(shape: EpochShape, walls: bool, units: float, arrays: EpochArrays) -> Iterator[bpy.types.Mesh | None]:
    """Make the mesh of an epoch a piece at a time: None after each but the last, which gives the mesh."""
    mesh = build_mesh(mesh_name(shape), shape.rest, arrays.triangles, units, arrays.edges)
    mesh[KEY] = ""  # of no epoch yet: `remove_unused` takes one away that is never finished
    yield None
    set_attribute(mesh, "material_index", "INT", "FACE", arrays.origin)
    set_attribute(mesh, "sharp_edge", "BOOLEAN", "EDGE", arrays.sharp)
    set_attribute(mesh, "depth", "FLOAT", "POINT", shape.depth)
    set_attribute(mesh, "quantity", "FLOAT", "POINT", np.zeros(len(shape.rest), np.float32))
    set_attribute(mesh, "origin", "INT", "FACE", arrays.origin)
    yield None
    set_attribute(mesh, "face", "INT", "FACE", arrays.face)
    set_attribute(mesh, "grid", "FLOAT2", "CORNER", arrays.grid)
    yield None
    lay(mesh, arrays.tiles)
    set_attribute(mesh, "rest", "FLOAT_VECTOR", "POINT", shape.rest)
    mesh[KEY] = shape.key if walls else f"{shape.key} without walls"  # now it is whole
    yield mesh


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
