"""Where the mesh of a tissue is wrong: edges, faces and points to show for each problem."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from mathutils.bvhtree import BVHTree
from numpy.typing import NDArray

from lappet.core.problem import Place, Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.geometry.border_loops import border_loops, perimeter
from lappet.geometry.mesh_faults import MODELLED, MeshFault, mesh_faults
from lappet.geometry.surface_check import place, signed_volume
from lappet.geometry.triangles import area_normals, directions
from lappet.geometry.triangulation import triangulate
from lappet.procedure import Tissue

from ..model.mesh_values import MeshValues

_MAX_CROSSINGS = 2000
_OF_CLOSED = {ProblemCode.MESH_OPEN, ProblemCode.MESH_NO_VOLUME, ProblemCode.MESH_INSIDE_OUT}


def _none(*shape: int) -> NDArray[np.float64]:
    return np.zeros((0, *shape))


@dataclass(frozen=True, eq=False)
class ProblemPlace:
    """A problem and where it is: lines (k, 2, 3), triangles (t, 3, 3) and points (p, 3), mm."""

    problem: Problem
    lines: NDArray[np.float64] = field(default_factory=lambda: _none(2, 3))
    triangles: NDArray[np.float64] = field(default_factory=lambda: _none(3, 3))
    points: NDArray[np.float64] = field(default_factory=lambda: _none(3))

    def middle(self) -> NDArray[np.float64] | None:
        """A point of it, mm, or None where it is nowhere in particular."""
        for each in (self.lines, self.triangles, self.points):
            if len(each):
                return np.asarray(each[0].reshape(-1, 3).mean(axis=0))
        return None


def place_of(found: Problem) -> ProblemPlace:
    """Return a problem with the points that it names itself."""
    points = () if found.place is None else found.place.points
    return ProblemPlace(found, points=np.array(points, np.float64).reshape(-1, 3))


def mesh_places(mesh: MeshValues, name: str, thicken: bool) -> list[ProblemPlace]:
    """Return what is wrong with the mesh as it was modeled.

    name: of the object. thicken: it is the outer surface only and may be open.
    """
    kinds = MODELLED - _OF_CLOSED if thicken else MODELLED
    faults = mesh_faults(mesh.points, mesh.counts, mesh.indices, kinds, _MAX_CROSSINGS)
    places = [_fault_place(mesh, fault, name) for fault in faults]
    torn = {ProblemCode.MESH_NOT_MANIFOLD, ProblemCode.MESH_NOT_ORIENTED}
    if thicken and all(fault.code in kinds and fault.code not in torn for fault in faults):
        places += _inner_borders(mesh, name)
    return places


def _fault_place(mesh: MeshValues, fault: MeshFault, name: str) -> ProblemPlace:
    lines = mesh.points[fault.edges]
    if fault.code is ProblemCode.MESH_NO_AREA:  # nothing is to be seen of the faces but their outlines
        outline = np.stack([fault.corners, np.roll(fault.corners, -1, axis=1)], axis=2).reshape(-1, 2, 3)
        return ProblemPlace(fault.problem(name), lines=outline)
    points = mesh.points[fault.vertices]
    return ProblemPlace(
        fault.problem(name), lines, fault.corners, points[np.isfinite(points).all(axis=1)] if len(points) else points
    )


def _inner_borders(mesh: MeshValues, name: str) -> list[ProblemPlace]:
    """The borders of an open surface but its rim, the longest."""
    triangles, _, _ = triangulate(mesh.points, mesh.counts.astype(np.int64), mesh.indices.astype(np.int64))
    loops = sorted(border_loops(triangles), key=lambda loop: perimeter(mesh.points, loop))
    if len(loops) < 2:
        return []
    inner = [mesh.points[np.stack([loop, np.roll(loop, -1)], axis=1)] for loop in loops[:-1]]
    return [ProblemPlace(problem(ProblemCode.SHEET_BORDERS, name, len(loops)), lines=np.concatenate(inner))]


def thin_places(tissue: Tissue, name: str, spacing: float) -> list[ProblemPlace]:
    """Where the tissue is thinner than a cell of the lattice, measured from the middle of each face inwards."""
    counts, indices = tissue.face_vertex_counts.astype(np.int64), tissue.face_vertex_indices.astype(np.int64)
    triangles, _, _ = triangulate(tissue.points, counts, indices)
    if signed_volume(tissue.points, triangles) < 0.0:
        triangles = triangles[:, ::-1]
    corners = tissue.points[triangles]
    inwards = -directions(area_normals(corners))
    tree = BVHTree.FromPolygons(tissue.points.tolist(), triangles.tolist(), all_triangles=True)
    skip = 1e-4 * spacing
    starts = corners.mean(axis=1) + skip * inwards
    depth = np.full(len(triangles), np.inf)
    for i, (start, ray) in enumerate(zip(starts.tolist(), inwards.tolist(), strict=True)):
        distance = tree.ray_cast(start, ray, spacing)[3]
        if distance is not None:
            depth[i] = distance + skip
    thin = depth < spacing * (1.0 - 1e-3)
    if not thin.any():
        return []
    least = int(depth.argmin())
    middle = corners[least].mean(axis=0)
    found = problem(
        ProblemCode.TISSUE_THIN,
        name,
        f"{depth[least]:.3g} mm",
        place=Place.at(middle),
        spacing=spacing,
        count=int(thin.sum()),
        where=place(np.round(middle, 3)),
    )
    return [ProblemPlace(found, triangles=corners[thin])]
