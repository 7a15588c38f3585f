"""Bring a skin cache into Blender: one mesh datablock per epoch, positions set for every frame with foreach_set."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from lappet.drawing.deep_bed import DeepBed
from lappet.drawing.skin_fields import SKIN
from lappet.drawing.skin_read import SkinCache
from lappet.drawing.skin_source import SkinEpoch
from lappet.geometry.skin_shape import uv_scale

from .layer_image import ROW, layer_rows
from .mesh_edges import MeshEdges, between_kinds
from .solid_texture import TILE, lay

SCALE = 0.1  # Blender units per mm: 1 unit is 1 cm


def build_mesh(
    name: str,
    points: NDArray[np.float32],
    triangles: NDArray[np.int32],
    scale: float = SCALE,
    edges: MeshEdges | None = None,
) -> bpy.types.Mesh:
    """A mesh datablock from points (n, 3) in mm and triangles (m, 3), smooth shaded. scale: Blender units per mm."""
    mesh = bpy.data.meshes.new(name)
    fill_mesh(mesh, points * scale, triangles, edges)
    return mesh


def fill_mesh(
    mesh: bpy.types.Mesh, points: NDArray[Any], triangles: NDArray[np.int32], edges: MeshEdges | None = None
) -> None:
    """Give an empty mesh points (n, 3) in Blender units and triangles (m, 3).

    edges: those of the triangles where they are known; Blender finds them otherwise, and takes 70 ms for it at 200 000
    vertices.
    """
    mesh.vertices.add(len(points))
    if edges is not None:
        mesh.edges.add(len(edges.ends))
        mesh.attributes[".edge_verts"].data.foreach_set("value", edges.ends.ravel())
    mesh.loops.add(3 * len(triangles))
    mesh.polygons.add(len(triangles))
    if len(triangles):
        # By attribute: several times as fast as by vertex, corner and face.
        mesh.attributes[".corner_vert"].data.foreach_set("value", np.ascontiguousarray(triangles, np.int32).ravel())
        mesh.polygons.foreach_set("loop_start", np.arange(0, 3 * len(triangles), 3, dtype=np.int32))
    if edges is not None and len(triangles):
        mesh.attributes[".corner_edge"].data.foreach_set("value", edges.of_corner)
    mesh.attributes["position"].data.foreach_set("vector", points.astype(np.float32).ravel())
    mesh.update(calc_edges=edges is None)


_FIELDS = {
    "FLOAT": "value",
    "INT": "value",
    "BOOLEAN": "value",
    "FLOAT2": "vector",
    "FLOAT_VECTOR": "vector",
    "FLOAT_COLOR": "color",
}


def set_attribute(mesh: bpy.types.Mesh, name: str, kind: str, domain: str, values: NDArray[Any]) -> None:
    """Set an attribute of a mesh, made where it is missing. values: one row per element of the domain."""
    attribute = mesh.attributes.get(name)
    if attribute is None or attribute.data_type != kind or attribute.domain != domain:
        if attribute is not None:
            mesh.attributes.remove(attribute)
        attribute = mesh.attributes.new(name, kind, domain)
    attribute.data.foreach_set(_FIELDS[kind], np.ascontiguousarray(values).ravel())


def mark_sharp_borders(mesh: bpy.types.Mesh, origin: NDArray[np.uint8]) -> None:
    """Mark the edges between faces of different origin sharp, so that the wound has a crisp edge on smooth skin."""
    edges = np.empty(len(mesh.loops), np.int32)
    mesh.attributes[".corner_edge"].data.foreach_get("value", edges)
    set_attribute(mesh, "sharp_edge", "BOOLEAN", "EDGE", between_kinds(edges, len(mesh.edges), origin))


class SkinObject:
    """The skin in the scene: one object that shows the mesh of the epoch of the current frame."""

    def __init__(
        self, cache: SkinCache, materials: list[bpy.types.Material], scalar: str | None = None, highest: float = 1.0
    ) -> None:
        """materials: one per face origin, in the order of `ORIGINS`. scalar: a vertex quantity to load, or None.

        highest: the value at the top of its scale.
        """
        self._cache, self._scalar, self._highest = cache, scalar, max(highest, 1e-9)
        first = cache.epochs[0]
        rest = cache.positions(first, first.frames[0])
        self._grid_scale = (
            uv_scale(rest, first.triangles[first.origin == SKIN], first.st[first.origin == SKIN])
            if (first.st is not None)
            else np.ones(2)
        )
        self._meshes = {epoch.name: self._build(epoch, materials) for epoch in cache.epochs if epoch.frames}
        self.object = bpy.data.objects.new("Skin", next(iter(self._meshes.values())))
        bpy.context.scene.collection.objects.link(self.object)

    def show(self, time: float) -> None:
        """Swap to the epoch of a frame and set its positions (and the scalar)."""
        epoch = self._cache.epoch_at(time)
        mesh = self._meshes[epoch.name]
        self.object.data = mesh
        points = self._cache.positions(epoch, time) * SCALE
        mesh.attributes["position"].data.foreach_set("vector", points.astype(np.float32).ravel())
        if self._scalar and (values := self._cache.scalar(epoch, self._scalar, time)) is not None:
            set_attribute(mesh, "quantity", "FLOAT", "POINT", values)
            share = np.nan_to_num(values[epoch.triangles.ravel()] / self._highest)
            lay(mesh, np.stack([share, np.full_like(share, 0.5)], axis=1))
        mesh.update()

    def _build(self, epoch: SkinEpoch, materials: list[bpy.types.Material]) -> bpy.types.Mesh:
        points = self._cache.positions(epoch, epoch.frames[0])
        mesh = build_mesh(epoch.name, points, epoch.triangles)
        for material in materials:
            mesh.materials.append(material)
        mesh.polygons.foreach_set("material_index", epoch.origin.astype(np.int32))
        mark_sharp_borders(mesh, epoch.origin)
        st = epoch.st if epoch.st is not None else points[epoch.triangles][:, :, :2]
        grid = (st * self._grid_scale).astype(np.float32)
        set_attribute(mesh, "grid", "FLOAT2", "CORNER", grid)
        lay(mesh, grid.reshape(-1, 2) / TILE)
        set_attribute(mesh, "depth", "FLOAT", "POINT", self._cache.depth(epoch))
        rows = layer_rows(self._cache.layers, self._cache.column(epoch))
        set_attribute(mesh, ROW, "FLOAT", "FACE", rows)
        set_attribute(mesh, "rest", "FLOAT_VECTOR", "POINT", self._cache.rest(epoch).astype(np.float32))
        return mesh


class Bed:
    """The deep tissue (`deep_bed.py`) in the scene."""

    def __init__(self, cache: SkinCache, material: bpy.types.Material) -> None:
        """A cache that names no underside has no bed."""
        self._bed = DeepBed(cache)
        self._mesh: bpy.types.Mesh | None = None
        if len(self._bed):
            self._mesh = build_mesh("Bed", self._bed.rest.astype(np.float32), self._bed.triangles)
            self._mesh.materials.append(material)
            bpy.context.scene.collection.objects.link(bpy.data.objects.new("Bed", self._mesh))

    def show(self, time: float) -> None:
        """Lower the bed under the skin of a frame."""
        if self._mesh is not None:
            moved = (self._bed.positions(time) * SCALE).astype(np.float32)
            self._mesh.attributes["position"].data.foreach_set("vector", moved.ravel())
            self._mesh.update()
