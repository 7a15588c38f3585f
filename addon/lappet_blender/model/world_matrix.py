"""Where an object stands in the world, also before Blender has evaluated the scene, and whether it keeps its shape."""

from __future__ import annotations

import bpy
import numpy as np
from mathutils import Matrix
from numpy.typing import NDArray

from .decimals import decimals
from .units import mm_per_unit

_RIGID = 1e-4  # of the scale: how far axes may differ in length and squareness


def world_matrix(obj: bpy.types.Object) -> Matrix:
    """The object's matrix in the world from its own and its parents' transforms.

    `matrix_world` is that of the last evaluation; it is only asked where constraints or a parent bone decide.
    """
    if obj.constraints or (obj.parent is not None and obj.parent_type != "OBJECT"):
        return obj.matrix_world.copy()
    if obj.parent is None:
        return obj.matrix_basis.copy()
    return world_matrix(obj.parent) @ obj.matrix_parent_inverse @ obj.matrix_basis


def object_to_mm(scene: bpy.types.Scene, obj: bpy.types.Object) -> NDArray[np.float64]:
    """The matrix (4, 4) that takes the object's coordinates to mm of the world (column vectors).

    Its entries are the decimals that Blender holds in single precision, so that an object of scale 0.001 in a scene of
    metres has exactly one unit per mm.
    """
    matrix = np.array([decimals(row) for row in world_matrix(obj)])
    matrix[:3] *= mm_per_unit(scene)
    return matrix


def stretch(matrix: Matrix) -> tuple[float, float, float]:
    """The lengths of the object's axes in the world."""
    return tuple(float(matrix.col[k].to_3d().length) for k in range(3))  # type: ignore[return-value]


def keeps_shape(matrix: Matrix) -> bool:
    """Whether the matrix turns, moves and scales alike in all directions, and does not mirror."""
    linear = np.array(matrix.to_3x3(), np.float64)
    size = float(np.cbrt(abs(np.linalg.det(linear))))
    if size == 0.0 or np.linalg.det(linear) < 0.0:
        return False
    return bool(np.abs(linear.T @ linear / size**2 - np.eye(3)).max() < _RIGID)
