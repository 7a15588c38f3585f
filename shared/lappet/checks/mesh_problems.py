"""What is wrong with a mesh of polygons as a closed surface, by counting: every kind of fault once, with where and how
many."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Problem
from lappet.core.problem_code import ProblemCode
from lappet.geometry.surface_check import first_intersection, place, signed_volume, unique_edges
from lappet.geometry.triangulation import triangulate
from lappet.procedure import Bone, Tissue


@dataclass(frozen=True)
class MeshReport:
    """problems: what is wrong. readable: the indices fit the points, and these are finite. triangles: (m, 3), if so."""

    problems: list[Problem]
    readable: bool
    triangles: NDArray[np.int32]


def mesh_problems(mesh: Tissue | Bone, path: str) -> MeshReport:
    """Checks that a mesh can be read and that it is closed, manifold, oriented alike, and free of self-intersections.

    path: the prim, for the problems. Points are in mm.
    """
    unreadable = _unreadable(mesh, path)
    if unreadable:
        return MeshReport(unreadable, False, np.zeros((0, 3), np.int32))
    counts, indices = mesh.face_vertex_counts, mesh.face_vertex_indices
    problems = _edge_problems(mesh, path)
    pieces, _, _ = triangulate(mesh.points, counts.astype(np.int64), indices.astype(np.int64))
    triangles = np.asarray(pieces, np.int32)
    if not problems:
        problems = _volume_problems(mesh, triangles, path)
    if not any(problem.severity == "error" for problem in problems):
        pair = first_intersection(mesh.points, triangles)
        if pair is not None:
            where = place(mesh.points[triangles[list(pair)]].mean(axis=(0, 1)))
            sentence = f"The surface passes through itself near {where}."
            problems.append(
                Problem(
                    ProblemCode.UNSORTED, path, where, sentence, "Move these parts of the mesh away from each other."
                )
            )
    return MeshReport(problems, True, triangles)


def _unreadable(mesh: Tissue | Bone, path: str) -> list[Problem]:
    points, counts, indices = mesh.points, mesh.face_vertex_counts, mesh.face_vertex_indices
    problems = []

    def add(value: object, sentence: str, remedy: str) -> None:
        problems.append(Problem(ProblemCode.UNSORTED, path, str(value), sentence, remedy))

    if len(points) == 0 or len(counts) == 0:
        add("empty", f"The mesh has {len(points)} points and {len(counts)} faces.", "Give it points and faces.")
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        value = "(" + ", ".join(f"{v:g}" for v in points[bad[0]]) + ")"
        sentence = f"{len(bad)} of {len(points)} points are not finite; the first is point {bad[0]}, {value}."
        add(value, sentence, "Replace them by finite numbers.")
    small = np.flatnonzero(counts < 3)
    if len(small):
        sentence = f"Face {small[0]} has {counts[small[0]]} corners."
        add(counts[small[0]], sentence, "Give every face at least 3 corners.")
    total = int(counts.sum(dtype=np.int64))
    if total != len(indices):
        sentence = f"The face vertex counts add up to {total}, but there are {len(indices)} face vertex indices."
        add(total, sentence, "Export the mesh again.")
    outside = np.flatnonzero((indices < 0) | (indices >= len(points)))
    if len(outside):
        index = indices[outside[0]]
        sentence = f"{len(outside)} face vertex indices are out of range: {index} with {len(points)} points."
        add(index, sentence, "Export the mesh again.")
    return problems


def _edge_problems(mesh: Tissue | Bone, path: str) -> list[Problem]:
    counts, indices = mesh.face_vertex_counts.astype(np.int64), mesh.face_vertex_indices.astype(np.int64)
    starts = np.repeat(np.cumsum(counts) - counts, counts)
    within = np.arange(len(indices)) - starts
    following = indices[starts + (within + 1) % np.repeat(counts, counts)]
    edges = np.stack([indices, following], axis=1)[indices != following]
    problems: list[Problem] = []

    def add(which: NDArray[np.intp], sentence: str, remedy: str) -> None:
        where = place(mesh.points[pairs[which[0]]].mean(axis=0))
        problems.append(Problem(ProblemCode.UNSORTED, path, where, sentence.format(n=len(which), where=where), remedy))

    pairs, inverse, uses = unique_edges(edges)
    lone = np.flatnonzero(uses == 1)
    if len(lone):
        sentence = "The surface is open: {n} edges belong to one face only, the first at {where}."
        remedy = "Close the mesh" + (
            "." if isinstance(mesh, Bone) else ", or make the tissue from it with: lappet new MESH --thickness MM."
        )
        add(lone, sentence, remedy)
    crowded = np.flatnonzero(uses > 2)
    if len(crowded):
        sentence = (
            f"The surface is not manifold: {uses[crowded[0]]} faces share an edge at {{where}} ({{n}} such edges)."
        )
        add(crowded, sentence, "Leave two faces at each edge.")
    forward = np.zeros(len(pairs), np.int64)
    np.add.at(forward, inverse, np.where(edges[:, 0] < edges[:, 1], 1, -1))
    twisted = np.flatnonzero((uses == 2) & (forward != 0))
    if len(twisted):
        sentence = "The faces are not oriented alike: the two at {where} face opposite ways ({n} such edges)."
        add(twisted, sentence, "Make the normals consistent; a one-sided surface encloses nothing.")
    return problems


def _volume_problems(mesh: Tissue | Bone, triangles: NDArray[np.int32], path: str) -> list[Problem]:
    volume = signed_volume(mesh.points, triangles)
    if not abs(volume) > 1e-12 * float(np.ptp(mesh.points, axis=0).max()) ** 3:
        sentence = f"The surface encloses no volume ({volume:.3g} mm³)."
        return [Problem(ProblemCode.UNSORTED, path, f"{volume:.3g}", sentence, "Give the mesh a thickness.")]
    if volume < 0.0:
        sentence = f"The surface is inside out (its volume is {volume:.4g} mm³) and is turned for solving."
        return [
            Problem(
                ProblemCode.UNSORTED,
                path,
                f"{volume:.4g}",
                sentence,
                "Flip the normals to be rid of this warning.",
                "warning",
            )
        ]
    return []
