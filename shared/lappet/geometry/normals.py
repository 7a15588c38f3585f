"""Normals at the corners of triangles, smooth but across sharp edges."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.triangles import area_normals, directions

_CREASE = np.cos(np.radians(60.0))


def corner_normals(points: NDArray[np.float64], triangles: NDArray[np.int64]) -> NDArray[np.float64]:
    """Compute normals at the corners of triangles, smooth but across sharp edges.

    A normal is the angle-weighted mean over the faces around the vertex that turn less than 60° from the corner's own
    face.

    Parameters
    ----------
    points
        Vertices, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).

    Returns
    -------
    NDArray[np.float64]
        Unit normals, shape (m, 3, 3).
    """
    corners = points[triangles]
    face = directions(area_normals(corners))
    to_next = np.roll(corners, -1, axis=1) - corners
    to_last = np.roll(corners, 1, axis=1) - corners
    sine = np.linalg.norm(np.cross(to_next, to_last), axis=2)
    angle = np.arctan2(sine, np.einsum("mci,mci->mc", to_next, to_last)).reshape(-1)

    vertex = triangles.reshape(-1)
    order = np.argsort(vertex, kind="stable")
    starts = np.searchsorted(vertex[order], vertex, side="left")
    stops = np.searchsorted(vertex[order], vertex, side="right")
    count = stops - starts
    corner = np.repeat(np.arange(len(vertex)), count)
    rank = np.arange(len(corner)) - np.repeat(np.cumsum(count) - count, count)
    neighbor = order[np.repeat(starts, count) + rank]
    own, other = face[corner // 3], face[neighbor // 3]
    alike = np.einsum("ij,ij->i", own, other) >= _CREASE
    owner, turned = corner[alike], (angle[neighbor, None] * other)[alike]
    normals: NDArray[np.float64] = np.stack([np.bincount(owner, turned[:, k], len(vertex)) for k in range(3)], axis=1)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.where(length > 1e-12, normals / np.maximum(length, 1e-300), np.repeat(face, 3, axis=0))
    return normals.reshape(-1, 3, 3)


def vertex_normals(points: NDArray[np.float64], triangles: NDArray[np.integer]) -> NDArray[np.float64]:
    """Compute normals at vertices: the means over the faces around, weighted by their areas.

    Parameters
    ----------
    points
        Vertices, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).

    Returns
    -------
    NDArray[np.float64]
        Unit normals, shape (n, 3); 0 where there is no face.
    """
    a, b, c = (points[triangles[:, k]] for k in range(3))
    faces = np.cross(b - a, c - a)
    normals = np.zeros_like(points)
    for k in range(3):
        np.add.at(normals, triangles[:, k], faces)
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
