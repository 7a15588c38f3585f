"""Collapse very short edges of a labeled surface; nothing opens and no triangle turns over."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.labeled_surface import Surface
from lappet.geometry.surface_check import directed_edges, unique_edges
from lappet.geometry.triangles import area_normals
from lappet.geometry.vectors import length
from lappet.geometry.without_piercings import NO_STEPS, Change, Step, step_of_edge, unchanged


def collapse_short_edges(surface: Surface, shortest: float, left_out: frozenset[Step] = NO_STEPS) -> Change:
    """Shrink short edges to one of their ends, where that keeps the surface manifold.

    An edge stays when its ends have more than two neighbors in common, or when a triangle that is not itself lower than
    `shortest` would turn by more than 60°. Triangles keep their labels and their corners' UVs.

    Parameters
    ----------
    surface
        The surface.
    shortest
        Edges shorter than this are collapsed, mm.
    left_out
        Steps that are not made: an edge's end that would go, and the one that it would go to.

    Returns
    -------
    Change
        The surface with fewer vertices.
    """
    points = surface.points
    every = directed_edges(surface.triangles)
    edges = unique_edges(every[_lengths(points, every) < shortest])[0]
    if len(edges) == 0:
        return unchanged(surface)
    triangles = surface.triangles.astype(np.int64)
    around = _faces_around(triangles, np.unique(edges))
    dead = np.zeros(len(triangles), bool)
    merged: dict[int, int] = {}
    for edge in np.argsort(_lengths(points, edges), kind="stable").tolist():
        one, other = (_final(int(v), merged) for v in edges[edge])
        for gone, kept in ((one, other), (other, one)) if one != other else ():
            is_left_out = bool(left_out) and step_of_edge(points, gone, kept) in left_out
            if not is_left_out and _can_collapse(points, triangles, around, gone, kept, shortest):
                break
        else:
            continue
        for face in sorted(around[gone]):
            if kept in triangles[face]:
                dead[face] = True
                for vertex in triangles[face].tolist():
                    around[vertex].discard(face)
            else:
                triangles[face][triangles[face] == gone] = kept
                around[kept].add(face)
        around[gone] = set()
        merged[gone] = kept
    if not merged:
        return unchanged(surface)
    faces = np.flatnonzero(~dead)
    used, compact = np.unique(triangles[faces], return_inverse=True)
    made = surface.of_faces(faces, points[used], compact.reshape(-1, 3), surface.uv[faces])
    return Change(made, faces, _last_steps(surface, faces, merged))


def _last_steps(surface: Surface, faces: NDArray[np.int64], merged: dict[int, int]) -> dict[int, tuple[Step, ...]]:
    """For each of the faces that are left whose corners went elsewhere: the last step of each corner."""
    before = surface.triangles[faces]
    gone = np.zeros(len(surface.points), bool)
    gone[list(merged)] = True
    steps = {}
    for face in np.flatnonzero(gone[before].any(axis=1)).tolist():
        last = []
        for vertex in before[face].tolist():
            while merged.get(merged.get(vertex, -1), -1) >= 0:
                vertex = merged[vertex]
            last += [step_of_edge(surface.points, vertex, merged[vertex])] if vertex in merged else []
        steps[face] = tuple(last)
    return steps


def _lengths(points: NDArray[np.float64], edges: NDArray[np.int64]) -> NDArray[np.float64]:
    placed = np.ascontiguousarray(points.T)
    return length(placed[:, edges[:, 0]] - placed[:, edges[:, 1]])


def _final(vertex: int, merged: dict[int, int]) -> int:
    while vertex in merged:
        vertex = merged[vertex]
    return vertex


def _faces_around(triangles: NDArray[np.int64], vertices: NDArray[np.int64]) -> dict[int, set[int]]:
    """The faces of each vertex that is at most two edges away from some vertices."""
    mark = np.zeros(int(triangles.max()) + 1, bool)
    mark[vertices] = True
    for _ in range(2):
        mark[triangles[mark[triangles].any(axis=1)]] = True
    around: dict[int, set[int]] = {}
    for face in np.flatnonzero(mark[triangles].any(axis=1)).tolist():
        for vertex in triangles[face].tolist():
            around.setdefault(vertex, set()).add(face)
    return around


def _can_collapse(
    points: NDArray[np.float64],
    triangles: NDArray[np.int64],
    around: dict[int, set[int]],
    gone: int,
    kept: int,
    shortest: float,
) -> bool:
    """Whether the vertex `gone` may move into `kept` (the link condition, and no triangle turned over)."""
    mine, other = around[gone], around[kept]
    shared = mine & other
    if len(shared) != 2:
        return False
    near_gone = {v for face in mine for v in triangles[face].tolist()}
    near_kept = {v for face in other for v in triangles[face].tolist()}
    opposite = {v for face in shared for v in triangles[face].tolist()} - {gone, kept}
    if (near_gone & near_kept) - {gone, kept} != opposite or len(opposite) != 2:
        return False
    if any(len(around[v]) <= 3 for v in opposite):
        return False
    faces = triangles[sorted(mine - shared)]
    before = points[faces]
    after = np.where((faces == gone)[:, :, None], points[kept], before)
    old, new = area_normals(before), area_normals(after)
    size_old, size_new = np.linalg.norm(old, axis=1), np.linalg.norm(new, axis=1)
    longest = np.linalg.norm(np.roll(before, -1, axis=1) - before, axis=2).max(axis=1)
    flat = size_old < shortest * longest
    alike = np.einsum("ij,ij->i", old, new) >= 0.5 * size_old * size_new
    return bool((flat | (alike & (size_new > 1e-3 * shortest * shortest))).all())
