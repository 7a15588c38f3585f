"""Whether bones and tissue share space at rest."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Problem
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
    """Whether a bone and the tissue share space at rest, deeper than contact pushes out.

    triangles: (c, 3), of the bone's points. points, tissue: (n, 3) mm and (m, 3), the tissue's surface. spacing: mm.
    Both surfaces are closed.
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
    where = place(np.round(corners[deepest], 3))
    sentence = f"The bone and the tissue share space at rest: they reach {depth:.3g} mm into each other at {where}."
    remedy = f"Move them apart; only {PUSHED_OUT * spacing:.3g} mm, half the lattice spacing, are pushed out."
    return [Problem(ProblemCode.UNSORTED, path, f"{depth:.3g} mm", sentence, remedy)]
