"""The bones of a procedure as the one closed surface that the daemon is told, and what is wrong with where they lie."""

from __future__ import annotations

from collections.abc import Sequence

import manifold3d
import numpy as np
from numpy.typing import NDArray

from lappet.closest_point import ClosestPoint
from lappet.problem import Problem
from lappet.procedure import Bone
from lappet.program import Bones, Surface
from lappet.refused import RefusedError
from lappet.surface import triangulate
from lappet.surface_check import place, signed_volume
from lappet.usd_writer import BONE

PUSHED_OUT = 0.5  # tissue that lies so many spacings deep in bone at rest is pushed out; deeper is refused

NEAR = 1.0  # mm that tissue may sink before bone bears it

SAMPLES = 30  # along the diagonal of the space that bone and tissue share


def united_bones(bones: Sequence[Bone]) -> Bones:
    """All bones as one closed surface without faces inside: those that touch or overlap become one.

    Raises RefusedError, naming the prim, for a bone that is not closed.
    """
    if not bones:
        return Bones()
    solids = [_solid(*_triangles(bone), f"{BONE}/{bone.name}") for bone in bones]
    return Bones(*_surface(manifold3d.Manifold.batch_boolean(solids, manifold3d.OpType.Add)))


def over_bone(surface: Surface, bones: Bones) -> NDArray[np.bool_]:
    """The resting faces, (m,), at most `NEAR` mm from a face of bone that looks at them; none where there are no bones.

    They need no plane to rest on, and on curved bone it would be wrong: tissue that slides by s over a radius R is held
    s² / 2R above the bone.
    """
    if len(bones.triangles) == 0:
        return np.zeros(0, bool)
    resting = np.flatnonzero(surface.resting)
    corners = surface.points[surface.triangles[resting]]
    nearest, _, distance = ClosestPoint(bones.points, bones.triangles).query(corners.mean(axis=1))
    facing = np.einsum("ij,ij->i", _across(corners), _across(bones.points[bones.triangles[nearest]])) < 0.0
    result = np.zeros(len(surface.triangles), bool)
    result[resting] = facing & (distance <= NEAR)
    return result


def _across(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """The normals of triangles (k, 3, 3), of any length."""
    return np.asarray(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))


def overlap_problems(
    bone: Bone, triangles: NDArray[np.int32], points: NDArray[np.float64], tissue: NDArray[np.int32], spacing: float
) -> list[Problem]:
    """Whether a bone and the tissue share space at rest, deeper than contact pushes out.

    triangles: (c, 3), of the bone's points. points, tissue: (n, 3) mm and (m, 3), the tissue's surface. spacing: mm.
    Both surfaces are closed.
    """
    path = f"{BONE}/{bone.name}"
    shared = _solid(bone.points, triangles, path) ^ _solid(points, tissue, "/Procedure/Tissue")
    if shared.is_empty():
        return []
    # The surface of the shared space lies on one of the two surfaces, and so deep in the other one.
    low, high = np.array(shared.bounding_box()).reshape(2, 3)
    corners, _ = _surface(shared.refine_to_length(max(2.0 * spacing, float(np.linalg.norm(high - low)) / SAMPLES)))
    depths = np.maximum(
        ClosestPoint(bone.points, triangles).query(corners)[2], ClosestPoint(points, tissue).query(corners)[2]
    )
    deepest = int(depths.argmax())
    depth = float(depths[deepest])
    if depth <= PUSHED_OUT * spacing:
        return []
    where = place(np.round(corners[deepest], 3))
    sentence = f"The bone and the tissue share space at rest: they reach {depth:.3g} mm into each other at {where}."
    mend = f"Move them apart; only {PUSHED_OUT * spacing:.3g} mm, half the lattice spacing, are pushed out."
    return [Problem(path, f"{depth:.3g} mm", sentence, mend)]


def _triangles(bone: Bone) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    counts, indices = bone.face_vertex_counts.astype(np.int64), bone.face_vertex_indices.astype(np.int64)
    triangles, _, _ = triangulate(bone.points, counts, indices)
    return bone.points, triangles


def _solid(points: NDArray[np.float64], triangles: NDArray[np.integer], path: str) -> manifold3d.Manifold:
    if signed_volume(points, triangles) < 0.0:
        triangles = triangles[:, ::-1]
    mesh = manifold3d.Mesh64(
        vert_properties=np.array(points, np.float64, order="C"),
        tri_verts=np.array(triangles, np.uint64, order="C"),
    )
    solid = manifold3d.Manifold(mesh)
    if solid.status() != manifold3d.Error.NoError:
        raise RefusedError(f"{path}: its surface is no closed solid ({solid.status().name}); repair the mesh.")
    return solid


def _surface(solid: manifold3d.Manifold) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    mesh = solid.to_mesh64()
    points = np.ascontiguousarray(np.asarray(mesh.vert_properties, np.float64)[:, :3])
    return points, np.asarray(mesh.tri_verts).astype(np.int32).reshape(-1, 3)
