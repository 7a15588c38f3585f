"""A moving mesh with fewer triangles, of the same vertices: meshoptimizer's edge collapses, by the error in all states.

Garland & Heckbert 1997, "Surface simplification using quadric error metrics", with the places in other states as
attributes (Hoppe 1999, "New quadric metric for simplifying meshes with appearance attributes"): a vertex goes only
where its place follows from its neighbors' in every state.
"""

from __future__ import annotations

import ctypes

import numpy as np
from numpy.typing import NDArray

from lappet.export.meshopt_package import meshopt
from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.surface_check import pinched_vertices, unpaired_edges
from lappet.geometry.unique_rows import unique_rows

_STATES = 11  # the package takes 32 attributes: three for each state but the first
_APART = 2e-5  # mm
_ROUNDS = 20  # of simplifying again where it was pinched; after these the mesh stays whole
_LOCKED = 1  # the package's flag of a vertex that stays


def simplified_triangles(
    triangles: NDArray[np.int32], place: NDArray[np.int64], states: NDArray[np.float32], most: int, error_mm: float
) -> NDArray[np.int32]:
    """Leave triangles of a moving mesh out, by collapsing edges towards one of their ends.

    A watertight mesh stays so. The package collapses an edge also where its ends have a neighbor in common that is in
    neither of the edge's triangles; that pinches a thin part to an edge of four triangles, or to a point. Where this
    has happened, the mesh is simplified again with all of the vertices around that place kept.

    Parameters
    ----------
    triangles
        Vertex indices, shape (m, 3).
    place
        For each vertex the place where it lies, an index into those of `states`, shape (n,). Vertices of one place stay
        together: they are what a seam between two kinds of triangles is made of.
    states
        Places in mm, shape (f, p, 3).
    most
        How many triangles may be left; there are more where no edge can go any more, the error would be greater, or
        the surface would be pinched.
    error_mm
        How great the error may be by the measure of the quadrics, in mm.

    Returns
    -------
    NDArray[np.int32]
        The triangles that are left, as vertex indices, shape (k, 3).

    Raises
    ------
    RefusedError
        If the package that does it is not installed.
    """
    before = _pinched(place[triangles])
    kept = np.zeros(states.shape[1], np.bool_)
    for _ in range(_ROUNDS):
        faces = _collapsed(triangles, place, states, kept, most, error_mm)
        pinched = np.setdiff1d(_pinched(place[faces]), before)
        if not len(pinched):
            return faces
        # The triangles at these places are then those of the whole mesh, and are pinched no more.
        around = np.isin(place[triangles], pinched).any(axis=1)
        kept[place[triangles[around]]] = True
    return triangles


def _pinched(triangles: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.union1d(unpaired_edges(triangles), pinched_vertices(triangles))


def _collapsed(
    triangles: NDArray[np.int32],
    place: NDArray[np.int64],
    states: NDArray[np.float32],
    kept: NDArray[np.bool_],
    most: int,
    error_mm: float,
) -> NDArray[np.int32]:
    """What the package leaves of a mesh; vertices at places that are kept do not go, shape (p,)."""
    package = meshopt("--simplify")
    chosen = np.unique(np.linspace(0, len(states) - 1, min(len(states), _STATES)).round().astype(np.int64))
    first = np.ascontiguousarray(_set_apart(states[chosen[0]])[place], np.float32)
    others = states[chosen[1:]][:, place].transpose(1, 0, 2).reshape(len(place), -1)
    attributes = np.ascontiguousarray(others if others.shape[1] else first, np.float32)
    count, extent = attributes.shape[1], float(np.ptp(first, axis=0).max())  # by which the package divides places
    indices = np.ascontiguousarray(triangles.ravel(), np.uint32)
    left = np.zeros(len(indices), np.uint32)
    size = ctypes.c_size_t  # the package does not say of which types the arguments of this function are
    found = package.simplify_with_attributes(
        left,
        indices,
        first,
        attributes,
        np.full(count, 1.0 / extent, np.float32),
        index_count=size(len(indices)),
        vertex_count=size(len(first)),
        vertex_positions_stride=size(12),
        vertex_attributes_stride=size(4 * count),
        attribute_count=size(count),
        vertex_lock=np.where(kept[place], np.uint8(_LOCKED), np.uint8(0)),
        target_index_count=size(3 * most),
        target_error=ctypes.c_float(error_mm),
        options=package.SIMPLIFY_ERROR_ABSOLUTE,
    )
    faces = left[:found].reshape(-1, 3).astype(np.int32)
    a, b, c = place[faces].T  # at a seam an edge may have shrunk to two vertices of one place
    return faces[(a != b) & (b != c) & (c != a)]


def _set_apart(points: NDArray[np.float32]) -> NDArray[np.float32]:
    """Points of which no two lie at one place: meshoptimizer takes those for one, and lips lie so until they part."""
    _, group, counts = np.unique(points, axis=0, return_inverse=True, return_counts=True)
    group = group.reshape(-1)
    order = np.argsort(group, kind="stable")
    rank = np.empty(len(points), np.int64)
    rank[order] = np.arange(len(points)) - np.repeat(np.cumsum(counts) - counts, counts)
    return (points + _APART * rank[:, None]).astype(np.float32)


def surface_distance(
    points: NDArray[np.floating],
    triangles: NDArray[np.integer],
    simplified: NDArray[np.integer],
) -> float:
    """Measure how far a mesh and a simplified one of the same vertices are from each other at most.

    Parameters
    ----------
    points
        Vertices in mm, shape (n, 3).
    triangles
        The whole mesh, shape (m, 3).
    simplified
        The simplified one, shape (k, 3).

    Returns
    -------
    float
        The greatest distance in mm of a vertex of the whole mesh from the simplified one, and of the middle of a new
        triangle of the simplified one, or of its edges, from the whole mesh.
    """
    gone = np.setdiff1d(triangles, simplified)
    if not len(gone):
        return 0.0
    there = ClosestPoint(points, simplified).query(points[gone])[2]
    rows = unique_rows(np.concatenate([np.sort(triangles, axis=1), np.sort(simplified, axis=1)]))[1]
    new = points[simplified[~np.isin(rows[len(triangles) :], rows[: len(triangles)])]].astype(np.float64)
    middles = np.concatenate([new.mean(axis=1), *(0.5 * (new[:, a] + new[:, b]) for a, b in ((0, 1), (1, 2), (2, 0)))])
    back = ClosestPoint(points, triangles).query(middles)[2]
    return float(max(there.max(), back.max()))
