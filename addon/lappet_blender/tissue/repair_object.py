"""Repair an object so that its mesh is what is seen: scale, modifiers, links, motion."""

from __future__ import annotations

import bpy
from mathutils import Matrix

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode

from ..model.keyframes import curves_of
from ..model.world_matrix import keeps_shape, world_matrix
from .tissue_objects import changeable_mesh

_PLACE = ("location", "rotation", "scale", "delta_")


def apply_scale(obj: bpy.types.Object) -> None:
    """Move the object's scale, and what a parent stretches, into its mesh, which stays where it is in the world.

    A mesh that other objects use is copied first. An object whose parent stretches it lets go of the parent. Raises
    RefusedError for a linked mesh and for a scale of 0.
    """
    changeable_mesh(obj)
    _out_of_edit_mode(obj)
    world = world_matrix(obj)
    if abs(world.to_3x3().determinant()) < 1e-30:
        raise refused(ProblemCode.OBJECT_SCALE_ZERO, obj.name)
    place, turn, _ = world.decompose()
    rigid = Matrix.LocRotScale(place, turn, None)
    if obj.data.users > 1:
        obj.data = obj.data.copy()
    inner = rigid.inverted() @ world
    obj.data.transform(inner, shape_keys=True)
    if inner.to_3x3().determinant() < 0.0:
        obj.data.flip_normals()
    if obj.parent is not None and obj.parent_type == "OBJECT":
        above = world_matrix(obj.parent) @ obj.matrix_parent_inverse
        if keeps_shape(above):
            obj.delta_scale = (1.0, 1.0, 1.0)
            obj.matrix_basis = above.inverted() @ rigid
            obj.data.update()
            return
    _stand(obj, rigid)
    obj.data.update()


def apply_shape(context: bpy.types.Context, obj: bpy.types.Object) -> str:
    """Make the mesh what modifiers and shape keys make of it as they are now, and remove them.

    Raises RefusedError for a linked mesh, and where nothing would be left.
    """
    changeable_mesh(obj)
    _out_of_edit_mode(obj)
    graph = context.evaluated_depsgraph_get()
    made = bpy.data.meshes.new_from_object(obj.evaluated_get(graph), preserve_all_data_layers=True, depsgraph=graph)
    if len(made.polygons) == 0:
        bpy.data.meshes.remove(made)
        raise refused(ProblemCode.OBJECT_NO_FACE_LEFT, obj.name)
    before, name = obj.data, obj.data.name
    faces = len(before.polygons)
    obj.modifiers.clear()
    obj.data = made
    if before.users == 0:
        bpy.data.meshes.remove(before)
    made.name = name
    return f"{obj.name!r} has {len(made.polygons)} faces; it had {faces}."


def make_local(obj: bpy.types.Object) -> None:
    """Make the object and its mesh local copies of what a library has."""
    if obj.library is None and obj.data.library is None:
        raise refused(ProblemCode.OBJECT_LOCAL, obj.name)
    if obj.library is not None:
        obj.make_local()
    if obj.data.library is not None:
        obj.data = obj.data.copy()
    if obj.data.library is not None:
        obj.data.make_local()


def fix_place(obj: bpy.types.Object) -> None:
    """Leave the object where it stands now, without constraints, parent, drivers and keyframes of its place."""
    if obj.library is not None:
        raise refused(ProblemCode.OBJECT_LINKED, obj.name, obj.library.filepath, role="object")
    world = world_matrix(obj)
    obj.constraints.clear()
    if obj.animation_data is not None:
        for driver in [d for d in obj.animation_data.drivers if d.data_path.startswith(_PLACE)]:
            obj.driver_remove(driver.data_path, driver.array_index)
        for curve in [c for c in curves_of(obj) if c.data_path.startswith(_PLACE)]:
            path, index = curve.data_path, curve.array_index
            for time in [point.co[0] for point in curve.keyframe_points][::-1]:
                obj.keyframe_delete(path, index=index, frame=time)
    _stand(obj, world)


def restore(scene: bpy.types.Scene, obj: bpy.types.Object) -> None:
    """Link an object that was taken out of the scene into it again."""
    if scene in obj.users_scene:
        raise refused(ProblemCode.OBJECT_IN_SCENE, obj.name)
    scene.collection.objects.link(obj)


def _stand(obj: bpy.types.Object, world: Matrix) -> None:
    obj.parent = None
    obj.delta_location, obj.delta_scale = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)
    obj.delta_rotation_euler, obj.delta_rotation_quaternion = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)
    obj.matrix_basis = world


def _out_of_edit_mode(obj: bpy.types.Object) -> None:
    if obj.mode == "EDIT":
        raise refused(ProblemCode.OBJECT_IN_EDIT_MODE, obj.name)
