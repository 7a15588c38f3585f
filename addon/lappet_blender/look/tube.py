"""Tubes along polylines as one mesh: what thread and instruments are made of. Only positions change while they can."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np
from numpy.typing import NDArray

from lappet.drawing.tube_shape import Radius, tube_faces, tube_points

from .skin_import import SCALE

TOPOLOGY = "lappet_tubes"


def draw_tubes(
    tubes: bpy.types.Object,
    lines: Sequence[NDArray[np.float64]],
    radii: Sequence[Radius],
    sides: int = 8,
    scale: float = SCALE,
) -> None:
    """Give a mesh object a round tube along each polyline (k, 3) in mm; radii in mm, one a line or one a point.

    scale: Blender units per mm.
    """
    points = (tube_points(lines, radii, sides) * scale).astype(np.float32)
    topology = f"{sides}:{','.join(str(len(line)) for line in lines)}"
    mesh = tubes.data
    if mesh.get(TOPOLOGY) != topology or len(mesh.vertices) != len(points):
        corners, starts = tube_faces([len(line) for line in lines], sides)
        mesh.clear_geometry()
        mesh.vertices.add(len(points))
        mesh.loops.add(len(corners))
        mesh.polygons.add(len(starts))
        mesh.loops.foreach_set("vertex_index", corners)
        mesh.polygons.foreach_set("loop_start", starts)
        mesh.vertices.foreach_set("co", points.ravel())
        mesh.update(calc_edges=True)
        mesh[TOPOLOGY] = topology
    else:
        mesh.attributes["position"].data.foreach_set("vector", points.ravel())
        mesh.update()


def add_tube_object(name: str, material: bpy.types.Material) -> bpy.types.Object:
    """An object without any tubes yet, in the scene of the context."""
    mesh = bpy.data.meshes.new(name)
    mesh.materials.append(material)
    tubes = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(tubes)
    return tubes
