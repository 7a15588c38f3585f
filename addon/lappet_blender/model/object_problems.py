"""Why an object cannot be tissue or a bone: each reason with a code that names the operator which repairs it."""

from __future__ import annotations

import bpy

from lappet.core.problem import Problem, problem
from lappet.core.problem_code import ProblemCode

from .keyframes import curves_of
from .world_matrix import keeps_shape, stretch, world_matrix

_MOVES = ("location", "rotation", "scale", "delta_")


def object_problems(scene: bpy.types.Scene, obj: bpy.types.Object, role: str) -> list[Problem]:
    """Return why the object cannot be the tissue or a bone of the scene, all reasons at once.

    role: "tissue" or "bone".
    """
    if obj.type != "MESH":
        return [problem(ProblemCode.OBJECT_NOT_A_MESH, obj.name, obj.type.lower(), role=role)]
    if scene not in obj.users_scene:
        return [problem(ProblemCode.OBJECT_NOT_IN_SCENE, obj.name, scene.name, role=role)]
    problems = [*_linked(obj, role), *_shape(obj, role)]
    matrix = world_matrix(obj)
    if not keeps_shape(matrix):
        mirrored = matrix.to_3x3().determinant() < 0.0
        code = ProblemCode.OBJECT_MIRRORED if mirrored else ProblemCode.OBJECT_STRETCHED
        sizes = ", ".join(f"{v:.4g}" for v in stretch(matrix))
        problems.append(problem(code, obj.name, f"({sizes})", role=role))
    return [*problems, *_motion(obj, role)]


def _linked(obj: bpy.types.Object, role: str) -> list[Problem]:
    library = obj.data.library or obj.library
    if library is None or role != "tissue":
        return []
    return [problem(ProblemCode.OBJECT_LINKED, obj.name, library.filepath, role=role)]


def _shape(obj: bpy.types.Object, role: str) -> list[Problem]:
    """Modifiers and shape keys: what is seen is another shape than the mesh."""
    problems = []
    active = [modifier.name for modifier in obj.modifiers if modifier.show_viewport or modifier.show_render]
    if active:
        problems.append(problem(ProblemCode.OBJECT_MODIFIERS, obj.name, ", ".join(active), role=role))
    if obj.data.shape_keys is not None:
        count = len(obj.data.shape_keys.key_blocks)
        problems.append(problem(ProblemCode.OBJECT_SHAPE_KEYS, obj.name, count, role=role))
    return problems


def _motion(obj: bpy.types.Object, role: str) -> list[Problem]:
    """Tissue and bone are given at rest: they may not move on their own."""
    each: bpy.types.Object | None = obj
    while each is not None:
        how = _moved_by(each)
        if how:
            whose = "" if each == obj else f" of its parent {each.name!r}"
            return [problem(ProblemCode.OBJECT_MOVES, obj.name, f"{how}{whose}", role=role)]
        each = each.parent
    return []


def _moved_by(obj: bpy.types.Object) -> str:
    active = [constraint.name for constraint in obj.constraints if constraint.enabled and constraint.influence > 0.0]
    if active:
        return f"the constraint {active[0]}"
    if any(curve.data_path.startswith(_MOVES) for curve in curves_of(obj)):
        return "keyframes"
    if obj.animation_data is not None and any(d.data_path.startswith(_MOVES) for d in obj.animation_data.drivers):
        return "a driver"
    return ""
