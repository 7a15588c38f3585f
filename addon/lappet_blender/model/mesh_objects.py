"""Make mesh objects of arrays in mm."""

from __future__ import annotations

import math
from collections.abc import Mapping

import bpy
import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.geometry.mesh_faults import refuse_unreadable

from .mesh_values import GROUP
from .units import mm_per_unit

_SHARP = math.radians(50.0)  # of the angle between faces: from here on an edge is seen as one


def mesh_object(
    scene: bpy.types.Scene,
    collection: bpy.types.Collection,
    name: str,
    points: NDArray[np.float64],
    counts: NDArray[np.integer],
    indices: NDArray[np.integer],
    uv: NDArray[np.float32] | None = None,
    groups: Mapping[str, NDArray[np.integer]] | None = None,
) -> bpy.types.Object:
    """A new object whose mesh has these polygons; its coordinates are mm, which its scale makes units of the scene.

    points: (n, 3) mm. counts: (m,), indices: (k,). uv: (k, 2). groups: face indices by name. Raises RefusedError for
    arrays that Blender could not hold.
    """
    _check(name, points, counts, indices, uv, groups or {})
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(points))
    mesh.vertices.foreach_set("co", np.ascontiguousarray(points, np.float32).reshape(-1))
    mesh.loops.add(len(indices))
    mesh.loops.foreach_set("vertex_index", np.ascontiguousarray(indices, np.int32))
    mesh.polygons.add(len(counts))
    mesh.polygons.foreach_set("loop_start", (np.cumsum(counts) - counts).astype(np.int32))
    if uv is not None:
        layer = mesh.uv_layers.new(name="UVMap", do_init=False)
        layer.uv.foreach_set("vector", np.ascontiguousarray(uv, np.float32).reshape(-1))
    for group, faces in (groups or {}).items():
        inside = np.zeros(len(counts), bool)
        inside[faces] = True
        mesh.attributes.new(GROUP + group, "BOOLEAN", "FACE").data.foreach_set("value", inside)
    mesh.update(calc_edges=True)
    mesh.set_sharp_from_angle(angle=_SHARP)  # smooth over the rim, skin would darken towards it in jags
    obj = bpy.data.objects.new(name, mesh)
    obj.scale = [1.0 / mm_per_unit(scene)] * 3
    collection.objects.link(obj)
    return obj


def _check(
    name: str,
    points: NDArray[np.float64],
    counts: NDArray[np.integer],
    indices: NDArray[np.integer],
    uv: NDArray[np.float32] | None,
    groups: Mapping[str, NDArray[np.integer]],
) -> None:
    refuse_unreadable(name, points, counts, indices)
    if uv is not None and len(uv) != len(indices):
        raise refused(ProblemCode.TISSUE_UV_COUNT, name, len(uv), corners=len(indices))
    for group, faces in groups.items():
        if len(faces) and not 0 <= faces.min() <= faces.max() < len(counts):
            raise refused(ProblemCode.SUBSET_INDEX_RANGE, name, faces.max(), name=group, faces=len(counts))
