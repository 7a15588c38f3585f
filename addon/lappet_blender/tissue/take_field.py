"""Make tissue of the skin around a point of an object: a new object, the tissue; the old one stays and is hidden."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.marked_faces import marked_outline
from lappet.geometry.border_loops import border_loops, perimeter
from lappet.geometry.mesh_faults import refuse_unreadable
from lappet.geometry.triangulation import triangulate
from lappet.tissue.mesh_file import Mesh
from lappet.tissue.surgical_field import Disc, Outline
from lappet.tissue.tissue_from_mesh import tissue_of_mesh

from ..model.mesh_objects import mesh_object
from ..model.mesh_values import MeshValues, mesh_values
from .set_tissue import set_tissue


def take_field(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    point: Sequence[float],
    radius: float,
    thickness: float,
    resolution: float,
    preset: str,
    faces: NDArray[np.bool_] | None = None,
) -> str:
    """Make the scene's tissue of the skin of an object around a point, or of marked faces of it.

    point: mm. radius: mm along the skin. thickness: mm. resolution: mm down to which edges are divided, 0 = the
    thickness. preset: as of `set_tissue`. faces: (m,), which faces are taken instead. Raises RefusedError before
    anything has changed; returns what was taken.
    """
    scene = context.scene
    if obj.type != "MESH":
        raise refused(ProblemCode.OBJECT_NOT_A_MESH, obj.name, obj.type.lower(), role="object")
    if any(bone.object == obj for bone in scene.lappet.bones):
        raise refused(ProblemCode.BONE_IS_TISSUE, obj.name)
    values = mesh_values(scene, obj)
    refuse_unreadable(obj.name, values.points, values.counts, values.indices)
    triangles, corners, _ = triangulate(values.points, values.counts.astype(np.int64), values.indices.astype(np.int64))
    uv = None if values.uv is None else values.uv[corners].astype(np.float64)
    tissue, report = tissue_of_mesh(
        Mesh(values.points, triangles, uv),
        thickness,
        Disc(tuple(point), radius) if faces is None else _outline(values, faces, obj.name),
        resolution=resolution or None,
        name=obj.name,
    )
    if obj.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    made = mesh_object(
        scene,
        obj.users_collection[0] if obj.users_collection else scene.collection,
        f"{obj.name} field",
        tissue.points,
        tissue.face_vertex_counts,
        tissue.face_vertex_indices,
        uv=tissue.uv,
        groups=tissue.subsets,
    )
    set_tissue(scene, made, 0.0, tissue.spacing, preset)
    layer = context.view_layer
    if obj.name in layer.objects:
        obj.select_set(False)
        obj.hide_set(True)
    if made.name in layer.objects:
        made.select_set(True)
        layer.objects.active = made
    return f"Took the skin {report['region']}; thickness {report['thickness']}."


def _outline(mesh: MeshValues, faces: NDArray[np.bool_], name: str) -> Outline:
    """The border of marked faces, around what they leave out. Raises RefusedError where they are in pieces."""
    marked_outline(mesh.points, mesh.counts, mesh.indices, faces, name)
    triangles, _, of = triangulate(mesh.points, mesh.counts.astype(np.int64), mesh.indices.astype(np.int64))
    loops = border_loops(triangles[faces[of]])
    if not loops:
        raise refused(ProblemCode.FACES_NO_BORDER, name, int(faces.sum()))
    longest = max(loops, key=lambda loop: perimeter(mesh.points, loop))
    return Outline(tuple((float(x), float(y), float(z)) for x, y, z in mesh.points[longest]))
