"""Tubes along polylines, as Blender curves: what thread and instruments are made of."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np
from numpy.typing import NDArray

from .skin_import import SCALE


def add_tubes(
    name: str,
    lines: Sequence[NDArray[np.float64]],
    radii: Sequence[NDArray[np.float64] | float],
    material: bpy.types.Material,
    resolution: int = 2,
) -> bpy.types.Object:
    """One curve object with a round tube along each polyline (k, 3) in mm; radii in mm, one a line or one a point."""
    curve = bpy.data.curves.new(name, "CURVE")
    curve.dimensions = "3D"
    curve.bevel_depth = SCALE
    curve.bevel_resolution = resolution
    curve.use_fill_caps = True
    for line, radius in zip(lines, radii, strict=True):
        spline = curve.splines.new("POLY")
        spline.points.add(len(line) - 1)
        spline.points.foreach_set("co", np.column_stack([line * SCALE, np.ones(len(line))]).astype(np.float32).ravel())
        spline.points.foreach_set("radius", np.broadcast_to(np.asarray(radius, np.float32), len(line)).copy())
        spline.use_smooth = True
    curve.materials.append(material)
    tubes = bpy.data.objects.new(name, curve)
    bpy.context.scene.collection.objects.link(tubes)
    return tubes


def remove_tubes(tubes: bpy.types.Object | None) -> None:
    """Delete an object made by `add_tubes`; None is nothing to do."""
    if tubes is not None:
        bpy.data.curves.remove(tubes.data)
