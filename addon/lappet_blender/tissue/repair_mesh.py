"""Repair the mesh of a tissue in place; faces keep their groups and texture coordinates."""

from __future__ import annotations

import bmesh
import bpy
import numpy as np

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.geometry.border_loops import border_loops, perimeter
from lappet.geometry.triangulation import clip_ears, triangulate
from lappet.tissue.mesh_file import Mesh
from lappet.tissue.mesh_repair import orient

from ..model.mesh_values import MeshValues, mesh_values
from .edited_mesh import edited_mesh

_WELD = 1e-6  # of the mesh's diagonal
_SMALL_HOLE = 0.15  # of the rim, or of the diagonal where every hole is to be filled


def triangles_of(mesh: MeshValues) -> tuple[np.ndarray, np.ndarray]:
    """The faces as triangles (t, 3), and the face (t,) of each."""
    triangles, _, faces = triangulate(mesh.points, mesh.counts.astype(np.int64), mesh.indices.astype(np.int64))
    return triangles, faces


def weld(obj: bpy.types.Object) -> str:
    """One vertex per position (to 10⁻⁶ of the diagonal); faces and edges without extent are dissolved."""
    with edited_mesh(obj) as work:
        vertices, faces = len(work.verts), len(work.faces)
        if vertices:
            places = np.array([vertex.co for vertex in work.verts])
            near = _WELD * float(np.linalg.norm(np.ptp(places, axis=0)))
            bmesh.ops.remove_doubles(work, verts=work.verts, dist=near)
            bmesh.ops.dissolve_degenerate(work, dist=near, edges=work.edges)
            twice = _twice(work)
            bmesh.ops.delete(work, geom=twice, context="FACES_ONLY")
        after = (vertices - len(work.verts), faces - len(work.faces))
    return f"Merged {after[0]} vertices, removed {after[1]} faces."


def _twice(work: bmesh.types.BMesh) -> list:
    seen: set[frozenset[int]] = set()
    twice = []
    work.verts.index_update()
    for face in work.faces:
        key = frozenset(vertex.index for vertex in face.verts)
        if key in seen:
            twice.append(face)
        seen.add(key)
    return twice


def remove_loose(obj: bpy.types.Object) -> str:
    """Vertices and edges without a face are removed."""
    with edited_mesh(obj) as work:
        edges = [edge for edge in work.edges if not edge.link_faces]
        vertices = [vertex for vertex in work.verts if not vertex.link_faces]
        count = (len(vertices), len(edges))
        bmesh.ops.delete(work, geom=edges, context="EDGES")
        bmesh.ops.delete(work, geom=[vertex for vertex in vertices if vertex.is_valid], context="VERTS")
    return f"Removed {count[0]} vertices and {count[1]} edges without a face."


def turn_alike(scene: bpy.types.Scene, obj: bpy.types.Object) -> str:
    """Neighboring faces look the same way; closed parts outwards, open parts as most of their faces did."""
    mesh = mesh_values(scene, obj)
    triangles, faces = triangles_of(mesh)
    turned = orient(Mesh(mesh.points, triangles))[0].triangles
    flip = np.unique(faces[(turned != triangles).any(axis=1)])
    if len(flip) == 0:
        raise refused(ProblemCode.FACES_CANNOT_TURN, obj.name)
    with edited_mesh(obj) as work:
        work.faces.ensure_lookup_table()
        for face in flip.tolist():
            work.faces[face].normal_flip()
    return f"Turned {len(flip)} faces."


def fill_holes(scene: bpy.types.Scene, obj: bpy.types.Object, keep_rim: bool, everything: bool = False) -> str:
    """Close holes with triangles: those shorter than 0.15 of the longest border, or of the diagonal.

    keep_rim: the longest border is the sheet's rim and stays. everything: whatever their length. Raises RefusedError
    where nothing is that small, naming the shortest.
    """
    mesh = mesh_values(scene, obj)
    triangles, _ = triangles_of(mesh)
    borders = [loop for loop in border_loops(triangles) if len(loop) > 2]
    loops = sorted(borders, key=lambda loop: perimeter(mesh.points, loop))
    lengths = [perimeter(mesh.points, loop) for loop in loops]
    if keep_rim and loops:
        limit = _SMALL_HOLE * lengths[-1]
        loops, lengths = loops[:-1], lengths[:-1]
    else:
        limit = _SMALL_HOLE * float(np.linalg.norm(np.ptp(mesh.points, axis=0)))
    if not loops:
        raise refused(ProblemCode.HOLES_NONE, obj.name)
    small = [loop for loop, size in zip(loops, lengths, strict=True) if everything or len(loop) <= 4 or size <= limit]
    if not small:
        raise refused(ProblemCode.HOLES_LARGE, obj.name, f"{lengths[0]:.4g}", limit=limit)
    with edited_mesh(obj) as work:
        work.verts.ensure_lookup_table()
        uv = work.loops.layers.uv.active
        for loop in small:
            back = loop[::-1]
            for piece in back[clip_ears(mesh.points[back])].tolist():
                corners = [work.verts[i] for i in piece]
                if len(set(piece)) == 3 and work.faces.get(corners) is None:
                    face = work.faces.new(corners)
                    for corner in face.loops if uv is not None else ():
                        beside = next((other for other in corner.vert.link_loops if other.face is not face), None)
                        if beside is not None:
                            corner[uv].uv = beside[uv].uv
    left = len(loops) - len(small)
    return f"Filled {len(small)} hole{'s' * (len(small) != 1)}" + (f"; {left} larger left." if left else ".")
