"""A patch of skin as a Blender scene, and small acts on it through operators."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import bpy
import numpy as np

from lappet.tissue.patch import flat_patch


def patch_scene(scene: bpy.types.Scene, size: tuple[float, float, float], end: int, resolution: float = 4.0) -> None:
    """Makes the scene one in mm, frames 1 to `end`, with a patch whose underside lies at z = 0 as its tissue."""
    scene.unit_settings.scale_length = 0.001
    scene.frame_start, scene.frame_end = 1, end
    tissue = flat_patch(size, resolution=resolution, spacing=1.0)
    mesh = bpy.data.meshes.new("patch")
    ends = np.cumsum(tissue.face_vertex_counts)
    mesh.from_pydata(
        tissue.points.tolist(), [], [face.tolist() for face in np.split(tissue.face_vertex_indices, ends[:-1])]
    )
    obj = bpy.data.objects.new("patch", mesh)
    scene.collection.objects.link(obj)
    for name in ("fixed", "bed"):
        values = np.zeros(len(mesh.polygons), bool)
        values[tissue.subsets[name]] = True
        mesh.attributes.new(f"lappet_{name}", "BOOLEAN", "FACE").data.foreach_set("value", values)
    scene.lappet.tissue.object = obj
    scene.lappet.materials.add().name = "skin"


def co(points: Sequence[Sequence[float]]) -> list[dict[str, Any]]:
    """Points as the operators take them."""
    return [{"name": "", "co": tuple(point)} for point in points]
