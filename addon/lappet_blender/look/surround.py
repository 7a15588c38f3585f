"""Skin that goes on where a cut-out of skin ends, so that a figure has no edge."""

from __future__ import annotations

import bpy
import numpy as np
from numpy.typing import NDArray

from lappet.drawing.skin_fields import SKIN, vertex_normals
from lappet.drawing.skin_read import SkinCache
from lappet.geometry.border_loops import border_loops, perimeter

from .skin_import import build_mesh, set_attribute


def surround(cache: SkinCache, width: float, material: bpy.types.Material) -> bpy.types.Object | None:
    """A band of skin of a width in mm beyond the tissue's border, straight on; None where the skin has no border."""
    epoch = cache.epochs[0]
    rest = cache.rest(epoch)
    points = rest.astype(np.float64)
    skin = epoch.triangles[epoch.origin == SKIN].astype(np.int64)
    loops = border_loops(skin)
    if not loops:
        return None
    loop = max(loops, key=lambda each: perimeter(points, each))
    normals = vertex_normals(rest, epoch.triangles, epoch.origin, SKIN)[loop].astype(np.float64)
    near, far = points[loop], points[loop] + width * _outward(points[loop], normals)
    count = len(loop)
    a, b = np.arange(count), np.roll(np.arange(count), -1)
    triangles = np.concatenate([np.stack([b, a, a + count], axis=1), np.stack([b, a + count, b + count], axis=1)])
    places = np.concatenate([near, far]).astype(np.float32)
    mesh = build_mesh("Surround", places, triangles.astype(np.int32))
    set_attribute(mesh, "rest", "FLOAT_VECTOR", "POINT", places)
    mesh.materials.append(material)
    band = bpy.data.objects.new("Surround", mesh)
    bpy.context.scene.collection.objects.link(band)
    return band


def _outward(loop: NDArray[np.float64], normals: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unit vectors along the skin and away from it at the points of its border, (k, 3)."""
    edges = np.roll(loop, -1, axis=0) - loop
    sides = np.cross(edges, normals)
    sides /= np.maximum(np.linalg.norm(sides, axis=1, keepdims=True), 1e-12)
    both = sides + np.roll(sides, 1, axis=0)
    both -= np.einsum("ki,ki->k", both, normals)[:, None] * normals
    away: NDArray[np.float64] = both / np.maximum(np.linalg.norm(both, axis=1, keepdims=True), 1e-12)
    return away
