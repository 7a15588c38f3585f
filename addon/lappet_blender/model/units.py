"""Lengths: the scene's units and millimetres.

A procedure's coordinates are the world's, in mm: world coordinate × scale_length × 1000. A scene whose unit scale is
0.001 has 1 unit = 1 mm.
"""

from __future__ import annotations

from collections.abc import Sequence

import bpy
from mathutils import Vector

from .decimals import decimal


def mm_per_unit(scene: bpy.types.Scene) -> float:
    """Millimetres per Blender unit."""
    return 1000.0 * decimal(scene.unit_settings.scale_length)


def to_mm(scene: bpy.types.Scene, world: Sequence[float]) -> tuple[float, float, float]:
    """A point of the world in mm."""
    x, y, z = (float(v) * mm_per_unit(scene) for v in world)
    return (x, y, z)


def to_world(scene: bpy.types.Scene, mm: Sequence[float]) -> Vector:
    """A point in mm as a point of the world."""
    return Vector([float(v) for v in mm]) / mm_per_unit(scene)
