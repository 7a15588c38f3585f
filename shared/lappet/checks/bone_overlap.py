"""Whether bones and tissue share space at rest."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Place, Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.solid import closed_solid, solid_surface
from lappet.geometry.surface_check import place
from lappet.procedure import Bone
from lappet.procedure.prim_paths import BONE

PUSHED_OUT = 0.5  # tissue that lies so many spacings deep in bone at rest is pushed out; deeper is refused


SAMPLES = 30  # along the diagonal of the space that bone and tissue share


def overlap_problems(
    bone: Bone, triangles: NDArray[np.int32], points: NDArray[np.float64], tissue: NDArray[np.int32], spacing: float
) -> list[Problem]:
    """Find whether a bone and the tissue share space at rest, deeper than contact pushes out.

    Both surfaces are closed.

    Parameters
    ----------
    bone
        The bone.
    triangles
        Vertex indices of the bone's triangles, shape (c, 3).
    points
        Vertices of the tissue in mm, shape (n, 3).
    tissue
        Vertex indices of the tissue's triangles, shape (m, 3).
    spacing
        Lattice spacing in mm.

    Returns
    -------
    list[Problem]
        The problems.
    """
    path = f"{BONE}/{bone.name}"
    shared = closed_solid(bone.points, triangles, path) ^ closed_solid(points, tissue, "/Procedure/Tissue")
    if shared.is_empty():
        return []
    # The surface of the shared space lies on one of the two surfaces, and so deep in the other one.
    low, high = np.array(shared.bounding_box()).reshape(2, 3)
    corners, _ = solid_surface(shared.refine_to_length(max(2.0 * spacing, float(np.linalg.norm(high - low)) / SAMPLES)))
    depths = np.maximum(
        ClosestPoint(bone.points, triangles).query(corners)[2], ClosestPoint(points, tissue).query(corners)[2]
    )
    deepest = int(depths.argmax())
    depth = float(depths[deepest])
    if depth <= PUSHED_OUT * spacing:
        return []
    where = np.round(corners[deepest], 3)
    return [
        problem(
            ProblemCode.BONE_IN_TISSUE,
            path,
            f"{depth:.3g} mm",
            place=Place.at(where),
            where=place(where),
            pushed=PUSHED_OUT * spacing,
        )
    ]
