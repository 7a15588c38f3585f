"""The bones of a procedure as the one closed surface that the daemon is told, and what is wrong with where they lie."""

from __future__ import annotations

from collections.abc import Sequence

import manifold3d
import numpy as np
from numpy.typing import NDArray

from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.labeled_surface import Surface
from lappet.geometry.rigid_motion import RigidMotion
from lappet.geometry.solid import closed_solid, solid_surface
from lappet.geometry.triangles import area_normals
from lappet.geometry.triangulation import triangulate
from lappet.procedure import Bone
from lappet.procedure.prim_paths import BONE
from lappet.program.program import Bones

NEAR = 1.0  # mm that tissue may sink before bone bears it


def united_bones(bones: Sequence[Bone]) -> Bones:
    """Unite all bones that stay in one closed surface without faces inside: those that touch or overlap become one.

    Each bone that moves is a body of its own, after those that stay.

    Parameters
    ----------
    bones
        The bones.

    Returns
    -------
    Bones
        The surface.

    Raises
    ------
    RefusedError
        If a bone is not closed; names the prim.
    """
    if not bones:
        return Bones()
    solids = [closed_solid(*_triangles(bone), f"{BONE}/{bone.name}") for bone in bones if not bone.moves]
    moving = [closed_solid(*_triangles(bone), f"{BONE}/{bone.name}") for bone in bones if bone.moves]
    still = [manifold3d.Manifold.batch_boolean(solids, manifold3d.OpType.Add)] if solids else []
    if not moving:
        return Bones(*solid_surface(still[0]))
    points, triangles, bodies, count = [], [], [], 0
    for body, solid in enumerate([*still, *moving]):
        own_points, own_triangles = solid_surface(solid)
        points.append(own_points)
        triangles.append(own_triangles + count)
        bodies.append(np.full(len(own_triangles), body, np.int32))
        count += len(own_points)
    return Bones(np.concatenate(points), np.concatenate(triangles).astype(np.int32), np.concatenate(bodies))


def bone_motions(bones: Sequence[Bone], start: float, times: Sequence[float]) -> NDArray[np.float64]:
    """Compute where the bodies of bones are in some frames.

    Parameters
    ----------
    bones
        The bones.
    start
        Time code of the procedure's start.
    times
        Time codes of the frames.

    Returns
    -------
    NDArray[np.float64]
        Motions of the bodies of `united_bones` from the start, shape (t, B, 4, 4), column-vector convention, mm; B is 0
        where no bone moves.

    Raises
    ------
    RefusedError
        If a motion is not rigid; names the prim.
    """
    moving = [RigidMotion(bone.motion, f"{BONE}/{bone.name}") for bone in bones if bone.moves]
    if not moving:
        return np.zeros((len(times), 0, 4, 4))
    still = [np.eye(4)] if any(not bone.moves for bone in bones) else []
    return np.array([[*still, *(motion.between(start, time) for motion in moving)] for time in times])


def over_bone(surface: Surface, bones: Bones) -> NDArray[np.bool_]:
    """Find the resting faces close above bone, which need no plane to rest on.

    On curved bone a plane would be wrong: tissue that slides by s over a radius R would be held s² / 2R above the bone.

    Parameters
    ----------
    surface
        Surface of an epoch.
    bones
        The bones.

    Returns
    -------
    NDArray[np.bool_]
        Which faces are at most `NEAR` mm from a face of bone that looks at them, shape (m,); none where there are no
        bones.
    """
    if len(bones.triangles) == 0:
        return np.zeros(0, bool)
    resting = np.flatnonzero(surface.resting)
    corners = surface.points[surface.triangles[resting]]
    nearest, _, _ = ClosestPoint(bones.points, bones.triangles).query(corners.mean(axis=1), within=NEAR)
    near = nearest >= 0
    across = area_normals(bones.points[bones.triangles[nearest[near]]])
    facing = np.einsum("ij,ij->i", area_normals(corners[near]), across) < 0.0
    result = np.zeros(len(surface.triangles), bool)
    result[resting[near]] = facing
    return result


def _triangles(bone: Bone) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    counts, indices = bone.face_vertex_counts.astype(np.int64), bone.face_vertex_indices.astype(np.int64)
    triangles, _, _ = triangulate(bone.points, counts, indices)
    return bone.points, triangles
