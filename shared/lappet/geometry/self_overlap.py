"""Where a closed surface passes through itself: which of its vertices lie inside it, and how deep."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.axis_rays import AxisRays
from lappet.geometry.normals import vertex_normals

_OFF = 1e-5  # of the surface's extent: so far outside its own triangles a vertex is asked whether others enclose it


class SelfOverlap(NamedTuple):
    """The vertices of a closed surface that lie inside it.

    Parameters
    ----------
    vertices
        Their indices, ascending, shape (k,).
    depth
        How deep each lies in what it has passed into, in the surface's unit, shape (k,): the shortest way along an axis
        of space to where the surface is left. Out of a body that is larger than its own, that is at most √3 times the
        shortest way of all.
    """

    vertices: NDArray[np.int64]
    depth: NDArray[np.float64]


def self_overlap(points: NDArray[np.floating], triangles: NDArray[np.integer]) -> SelfOverlap:
    """Find the vertices of a closed surface that lie inside it.

    Just outside its own triangles a vertex has the winding number 0, and more where other parts of the surface enclose
    it; just inside one more.

    Parameters
    ----------
    points
        Vertices in any length unit, shape (n, 3).
    triangles
        Vertex indices, outward-oriented, shape (m, 3).

    Returns
    -------
    SelfOverlap
        What was found.
    """
    points = np.asarray(points, np.float64)
    off = _OFF * float(np.ptp(points, axis=0).max(initial=0.0)) * vertex_normals(points, triangles)
    upwards = AxisRays(points, triangles, 2)
    without = winding_numbers(upwards, points + off)
    within = np.flatnonzero((without > 0) & off.any(axis=1))
    # Where the normal is none, as at the end of a slit, both sides of the vertex may lie in its own tissue.
    within = within[winding_numbers(upwards, (points - off)[within]) == without[within] + 1]
    outside = (points + off)[within]
    depth = np.full(len(within), np.inf)
    for axis in range(3):
        rays = upwards if axis == 2 else AxisRays(points, triangles, axis)
        line, along, leaves = rays.crossings(outside)
        out = leaves == (along > 0.0)
        np.minimum.at(depth, line[out], np.abs(along[out]))
    return SelfOverlap(within, depth)


def winding_numbers(upwards: AxisRays, queries: NDArray[np.float64]) -> NDArray[np.int64]:
    """Count how often a closed surface goes round points.

    Parameters
    ----------
    upwards
        Lines along z through the surface.
    queries
        Points in the surface's unit, shape (q, 3).

    Returns
    -------
    NDArray[np.int64]
        1 inside it, 0 outside, shape (q,).
    """
    line, along, leaves = upwards.crossings(queries)
    above = along > 0.0
    signs = np.where(leaves[above], 1, -1)
    return np.bincount(line[above], signs, len(queries)).round().astype(np.int64)
