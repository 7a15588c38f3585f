"""Where the mesh of a tissue is wrong: edges, faces and points to show, each with what repairs it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from mathutils.bvhtree import BVHTree
from numpy.typing import NDArray

from lappet.core.problem import Problem, Severity
from lappet.geometry.surface_check import intersections, place, signed_volume, unique_edges
from lappet.geometry.triangulation import triangulate
from lappet.procedure import Tissue
from lappet.tissue.mesh_repair import border_loops, perimeter

from ..model.mesh_values import MeshValues
from ..model.scene_problem import problem
from ..model.surface_border import directed_edges

_MOST_CROSSINGS = 2000
_NO_AREA = 1e-10  # of the square of the longest edge


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


def mesh_places(mesh: MeshValues, name: str, thicken: bool) -> list[ProblemPlace]:
    """What is wrong with the mesh as it was modelled.

    name: of the object. thicken: it is the outer surface only and may be open.
    """
    places: list[ProblemPlace] = []

    def add(sentence: str, remedy: str, kind: str = "", severity: Severity = "error", **where: NDArray) -> None:
        operator, arguments = ("lappet.tissue_repair", {"kind": kind}) if kind else ("", {})
        found = problem(name, kind or "mesh", sentence, remedy, operator, severity, **arguments)
        places.append(ProblemPlace(found, **where))

    points = mesh.points
    loose = np.setdiff1d(np.arange(len(points)), mesh.indices)
    if len(loose):
        sentence = f"{len(loose)} vertices belong to no face, the first at {place(points[loose[0]])}."
        add(sentence, "Remove loose parts.", "LOOSE", "warning", points=points[loose])
    if len(mesh.counts) == 0 or not np.isfinite(points).all():
        return places  # reading the scene says so
    triangles, _, _ = triangulate(points, mesh.counts.astype(np.int64), mesh.indices.astype(np.int64))
    corners = points[triangles]
    flat = _without_area(corners)
    if flat.any():
        sentence = f"{int(flat.sum())} faces have no area, the first at {place(corners[flat][0].mean(axis=0))}."
        add(sentence, "Weld the mesh.", "WELD", lines=_outline(corners[flat]))
    _edges(mesh, thicken, add)
    if not places or all(each.problem.severity == "warning" for each in places):
        volume = signed_volume(points, triangles)
        if not thicken and volume < 0.0:
            sentence = f"The surface is inside out (its volume is {volume:.4g} mm³); it is turned for solving."
            add(sentence, "Turn the faces.", "ORIENT", "warning")
    crossing = _crossing(points, triangles[~flat])
    if len(crossing):
        hit = points[triangles[~flat][crossing]]
        sentence = f"The surface passes through itself: {len(hit)} triangles cross, near {place(hit[0].mean(axis=0))}."
        add(sentence, "Move these parts of the mesh away from each other.", triangles=hit)
    return places


def thin_places(tissue: Tissue, name: str, spacing: float) -> list[ProblemPlace]:
    """Where the tissue is thinner than a cell of the lattice, measured from the middle of each face inwards."""
    counts, indices = tissue.face_vertex_counts.astype(np.int64), tissue.face_vertex_indices.astype(np.int64)
    triangles, _, _ = triangulate(tissue.points, counts, indices)
    if signed_volume(tissue.points, triangles) < 0.0:
        triangles = triangles[:, ::-1]
    corners = tissue.points[triangles]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inwards = -across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-300)
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
    sentence = (
        f"The tissue is thinner than the lattice spacing of {spacing:g} mm at {int(thin.sum())} triangles: "
        f"{depth[least]:.3g} mm at {place(np.round(corners[least].mean(axis=0), 3))}."
    )
    remedy = f"Use a spacing of {depth[least]:.3g} mm or less there, or make the tissue thicker."
    found = problem(name, f"{depth[least]:.3g} mm", sentence, remedy, severity="warning")
    return [ProblemPlace(found, triangles=corners[thin])]


def _edges(mesh: MeshValues, thicken: bool, add) -> None:  # type: ignore[no-untyped-def]
    directed = directed_edges(mesh)
    directed = directed[directed[:, 0] != directed[:, 1]]
    pairs, inverse, uses = unique_edges(directed)
    ends = mesh.points[pairs]

    def at(which: NDArray[np.bool_]) -> str:
        return place(ends[which][0].mean(axis=0))

    crowded = uses > 2
    if crowded.any():
        sentence = f"More than two faces share an edge at {at(crowded)} ({int(crowded.sum())} such edges)."
        add(sentence, "Weld the mesh, or leave two faces at each edge.", "WELD", lines=ends[crowded])
    forward = np.zeros(len(pairs), np.int64)
    np.add.at(forward, inverse, np.where(directed[:, 0] < directed[:, 1], 1, -1))
    twisted = (uses == 2) & (forward != 0)
    if twisted.any():
        sentence = f"Neighbouring faces look opposite ways at {at(twisted)} ({int(twisted.sum())} such edges)."
        add(sentence, "Turn the faces alike.", "ORIENT", lines=ends[twisted])
    border = uses == 1
    if border.any() and not thicken:
        sentence = f"The surface is open: {int(border.sum())} edges belong to one face only, the first at {at(border)}."
        add(sentence, "Fill the holes, or turn Thicken on.", "HOLES", lines=ends[border])
    elif border.any() and not crowded.any() and not twisted.any():
        triangles, _, _ = triangulate(mesh.points, mesh.counts.astype(np.int64), mesh.indices.astype(np.int64))
        loops = sorted(border_loops(triangles), key=lambda loop: perimeter(mesh.points, loop))
        if len(loops) > 1:
            sentence = f"The surface has {len(loops)} borders; each becomes a fixed rim."
            inner = [mesh.points[np.stack([loop, np.roll(loop, -1)], axis=1)] for loop in loops[:-1]]
            add(sentence, "Fill those that are holes.", "HOLES", "warning", lines=np.concatenate(inner))


def _without_area(corners: NDArray[np.float64]) -> NDArray[np.bool_]:
    sides = corners - np.roll(corners, 1, axis=1)
    longest = np.linalg.norm(sides, axis=2).max(axis=1)
    area = np.linalg.norm(np.cross(sides[:, 1], sides[:, 2]), axis=1)
    return np.asarray(area <= _NO_AREA * longest**2)


def _outline(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2, 3)


def _crossing(points: NDArray[np.float64], triangles: NDArray[np.int64]) -> NDArray[np.int64]:
    """The triangles that pierce others; no more than so many are looked for."""
    hit: list[NDArray[np.int64]] = []
    for pairs in intersections(points, triangles):
        hit.append(pairs.reshape(-1))
        if sum(len(each) for each in hit) > _MOST_CROSSINGS:
            break
    return np.unique(np.concatenate(hit)) if hit else np.zeros(0, np.int64)
