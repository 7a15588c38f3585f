"""Brings a skin cache into Blender: one mesh datablock per epoch, positions set for every frame with foreach_set."""

from __future__ import annotations

import bpy
import numpy as np
from mathutils.kdtree import KDTree
from numpy.typing import NDArray

from .skin_fields import RIM, SKIN, UNDERSIDE, depth_below_skin, uv_scale, vertex_normals
from .skin_read import SkinCache
from .skin_source import SkinEpoch

SCALE = 0.1  # Blender units per mm: 1 unit is 1 cm
BED_GAP = 0.35


def build_mesh(name: str, points: NDArray[np.float32], triangles: NDArray[np.int32]) -> bpy.types.Mesh:
    """A mesh datablock from points (n, 3) in mm and triangles (m, 3), smooth shaded."""
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(points))
    mesh.loops.add(3 * len(triangles))
    mesh.polygons.add(len(triangles))
    mesh.loops.foreach_set("vertex_index", np.ascontiguousarray(triangles, np.int32).ravel())
    mesh.polygons.foreach_set("loop_start", np.arange(0, 3 * len(triangles), 3, dtype=np.int32))
    mesh.vertices.foreach_set("co", (points * SCALE).astype(np.float32).ravel())
    mesh.update(calc_edges=True)
    return mesh


def _set_attribute(mesh: bpy.types.Mesh, name: str, kind: str, domain: str, values: NDArray[np.float32]) -> None:
    attribute = mesh.attributes.get(name) or mesh.attributes.new(name, kind, domain)
    field = {"FLOAT": "value", "BOOLEAN": "value", "FLOAT2": "vector", "FLOAT_VECTOR": "vector"}[kind]
    attribute.data.foreach_set(field, np.ascontiguousarray(values).ravel())


def mark_sharp_borders(mesh: bpy.types.Mesh, origin: NDArray[np.uint8]) -> None:
    """Mark the edges between faces of different origin sharp, so that the wound has a crisp edge on smooth skin."""
    edges = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("edge_index", edges)
    label = np.repeat(origin.astype(np.int64), 3)
    low = np.full(len(mesh.edges), 255, np.int64)
    high = np.full(len(mesh.edges), -1, np.int64)
    np.minimum.at(low, edges, label)
    np.maximum.at(high, edges, label)
    _set_attribute(mesh, "sharp_edge", "BOOLEAN", "EDGE", (low != high) & (high >= 0))


class SkinObject:
    """The skin in the scene: one object that shows the mesh of the epoch of the current frame."""

    def __init__(self, cache: SkinCache, materials: list[bpy.types.Material], scalar: str | None = None) -> None:
        """materials: one per face origin, in the order of `ORIGINS`. scalar: a vertex quantity to load, or None."""
        self._cache, self._scalar = cache, scalar
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
            _set_attribute(mesh, "quantity", "FLOAT", "POINT", values)
        mesh.update()

    def _build(self, epoch: SkinEpoch, materials: list[bpy.types.Material]) -> bpy.types.Mesh:
        points = self._cache.positions(epoch, epoch.frames[0])
        mesh = build_mesh(epoch.name, points, epoch.triangles)
        for material in materials:
            mesh.materials.append(material)
        mesh.polygons.foreach_set("material_index", epoch.origin.astype(np.int32))
        mark_sharp_borders(mesh, epoch.origin)
        st = epoch.st if epoch.st is not None else points[epoch.triangles][:, :, :2]
        _set_attribute(mesh, "grid", "FLOAT2", "CORNER", (st * self._grid_scale).astype(np.float32))
        _set_attribute(mesh, "depth", "FLOAT", "POINT", depth_below_skin(points, epoch.triangles, epoch.origin))
        return mesh


class Bed:
    """The deep tissue under the skin, seen through an open wound: the underside at rest, a little deeper.

    It gives way where the skin sinks, so that it never shows through closed skin.
    """

    def __init__(self, cache: SkinCache, material: bpy.types.Material) -> None:
        """A cache that names no underside has no bed."""
        self._cache = cache
        epoch = cache.epochs[0]
        points = cache.positions(epoch, epoch.frames[0])
        faces = epoch.triangles[epoch.origin == UNDERSIDE]
        self._mesh: bpy.types.Mesh | None = None
        if not len(faces):
            return
        used, corners = np.unique(faces, return_inverse=True)
        corners = corners.reshape(-1, 3)
        self._rest = points[used].astype(np.float64)
        self._down = vertex_normals(points, epoch.triangles, epoch.origin, UNDERSIDE)[used].astype(np.float64)
        self._pairs = np.unique(np.sort(corners[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
        self._tree = KDTree(len(self._rest))
        for k, point in enumerate(self._rest):
            self._tree.insert(point, k)
        self._tree.balance()
        self._mesh = build_mesh("Bed", self._lowered(np.zeros(len(used))), corners[:, ::-1].astype(np.int32))
        self._mesh.materials.append(material)
        bpy.context.scene.collection.objects.link(bpy.data.objects.new("Bed", self._mesh))

    def show(self, time: float) -> None:
        """Lower the bed under the skin of a frame."""
        if self._mesh is None:
            return
        epoch = self._cache.epoch_at(time)
        points = self._cache.positions(epoch, time).astype(np.float64)
        below = np.zeros(len(self._rest))
        lower = points[np.unique(epoch.triangles[epoch.origin == UNDERSIDE])]
        nearest = np.array([self._tree.find(p)[1] for p in lower])
        np.maximum.at(below, nearest, np.einsum("ij,ij->i", lower - self._rest[nearest], self._down[nearest]))
        for _ in range(3):
            grown = below.copy()
            for a, b in ((0, 1), (1, 0)):
                np.maximum.at(grown, self._pairs[:, a], below[self._pairs[:, b]])
            below = grown
        moved = (self._lowered(below) * SCALE).astype(np.float32)
        self._mesh.attributes["position"].data.foreach_set("vector", moved.ravel())
        self._mesh.update()

    def _lowered(self, below: NDArray[np.float64]) -> NDArray[np.float32]:
        return (self._rest + (below + BED_GAP)[:, None] * self._down).astype(np.float32)


def has_rim(cache: SkinCache) -> bool:
    """Whether the skin ends in a cut rim (a patch) rather than closing on itself."""
    return bool((cache.epochs[0].origin == RIM).any())
