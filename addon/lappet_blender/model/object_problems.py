"""What is wrong with an object as tissue or bone, on Blender's side: each with the operator that repairs it."""

from __future__ import annotations

import bpy

from .keyframes import curves_of
from .scene_problem import SceneProblem, problem
from .world_matrix import keeps_shape, stretch, world_matrix

_MOVES = ("location", "rotation", "scale", "delta_")


def object_problems(scene: bpy.types.Scene, obj: bpy.types.Object, role: str) -> list[SceneProblem]:
    """Why the object cannot be the tissue or a bone of the scene, all reasons at once.

    role: "tissue" or "bone".
    """
    name = obj.name
    if obj.type != "MESH":
        sentence = f"The {role} {name!r} is a {obj.type.lower()} and no mesh."
        return [problem(name, obj.type, sentence, "Choose a mesh object, or convert this one to a mesh.")]
    if scene not in obj.users_scene:
        sentence = f"The {role} {name!r} is not in the scene {scene.name!r}: it was deleted or moved elsewhere."
        remedy = "Undo the deletion, link the object to the scene, or choose another one."
        return [problem(name, scene.name, sentence, remedy, "lappet.tissue_restore", object=name)]
    problems = [*_linked(obj, role), *_shape(obj, role)]
    matrix = world_matrix(obj)
    if not keeps_shape(matrix):
        sizes = ", ".join(f"{v:.4g}" for v in stretch(matrix))
        mirrored = matrix.to_3x3().determinant() < 0.0
        sentence = (
            f"The {role} {name!r} is {'mirrored by its scale' if mirrored else 'stretched by its scale'}, ({sizes})."
        )
        remedy = "Apply the scale; the mesh keeps its place and shape."
        problems.append(problem(name, f"({sizes})", sentence, remedy, "lappet.tissue_apply_scale", object=name))
    return [*problems, *_motion(obj, role)]


def _linked(obj: bpy.types.Object, role: str) -> list[SceneProblem]:
    library = obj.data.library or obj.library
    if library is None or role != "tissue":
        return []
    sentence = f"The mesh of the tissue {obj.name!r} is linked from {library.filepath!r} and cannot be changed here."
    remedy = "Make it local; the library's file stays as it is."
    return [problem(obj.name, library.filepath, sentence, remedy, "lappet.tissue_make_local", object=obj.name)]


def _shape(obj: bpy.types.Object, role: str) -> list[SceneProblem]:
    """Modifiers and shape keys: what is seen is another shape than the mesh."""
    name, problems = obj.name, []
    active = [modifier.name for modifier in obj.modifiers if modifier.show_viewport or modifier.show_render]
    if active:
        names = ", ".join(active)
        sentence = (
            f"The {role} {name!r} has the modifier{'s' * (len(active) > 1)} {names}: its shape is not its mesh's."
        )
        remedy = "Apply what changes its shape, or switch it off for viewport and render."
        problems.append(problem(name, names, sentence, remedy, "lappet.tissue_apply_modifiers", object=name))
    if obj.data.shape_keys is not None:
        count = len(obj.data.shape_keys.key_blocks)
        sentence = f"The {role} {name!r} has {count} shape key{'s' * (count != 1)}: its shape is not its mesh's."
        remedy = "Apply them as they are mixed now."
        problems.append(problem(name, count, sentence, remedy, "lappet.tissue_apply_modifiers", object=name))
    return problems


def _motion(obj: bpy.types.Object, role: str) -> list[SceneProblem]:
    """Tissue and bone are given at rest: they may not move on their own."""
    each: bpy.types.Object | None = obj
    while each is not None:
        how = _moved_by(each)
        if how:
            whose = "" if each == obj else f" through its parent {each.name!r}"
            sentence = f"The {role} {obj.name!r} is moved by {how}{whose}; a procedure needs it at rest."
            remedy = "Fix it where it stands now."
            return [problem(obj.name, how, sentence, remedy, "lappet.tissue_fix_place", object=obj.name)]
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
