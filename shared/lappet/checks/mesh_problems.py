"""What is wrong with a mesh of polygons as a closed surface: every kind of fault once, with where and how many."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Problem
from lappet.core.problem_code import ProblemCode
from lappet.geometry.mesh_faults import SOLID, mesh_faults
from lappet.geometry.triangulation import triangulate
from lappet.procedure import Bone, Tissue

_READABLE = SOLID | {ProblemCode.MESH_INSIDE_OUT}


@dataclass(frozen=True)
class MeshReport:
    """What is wrong with a mesh.

    Parameters
    ----------
    problems
        The problems.
    readable
        Whether the indices fit the points, and these are finite.
    triangles
        Vertex indices, shape (m, 3), where the mesh is readable.
    """

    problems: list[Problem]
    readable: bool
    triangles: NDArray[np.int32]


def mesh_problems(mesh: Tissue | Bone, path: str) -> MeshReport:
    """Check that a mesh can be read, is closed, manifold and oriented alike, and does not pass through itself.

    Parameters
    ----------
    mesh
        The tissue or bone; its points are in mm.
    path
        Path of its prim.

    Returns
    -------
    MeshReport
        The problems, and the triangles.
    """
    faults = mesh_faults(mesh.points, mesh.face_vertex_counts, mesh.face_vertex_indices, _READABLE)
    problems = [fault.problem(path) for fault in faults]
    if any(fault.code not in _READABLE for fault in faults):
        return MeshReport(problems, False, np.zeros((0, 3), np.int32))
    counts, indices = mesh.face_vertex_counts.astype(np.int64), mesh.face_vertex_indices.astype(np.int64)
    triangles, _, _ = triangulate(mesh.points, counts, indices)
    return MeshReport(problems, True, np.asarray(triangles, np.int32))
