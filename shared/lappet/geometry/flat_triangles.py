"""Remove flat triangles (three corners almost on a line) from a labeled surface by turning their long edges."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.labeled_surface import Surface
from lappet.geometry.vectors import cross, length, triangle_corners
from lappet.geometry.without_piercings import NO_STEPS, Change, Step, step_of_edge, unchanged

_ROUNDS = 8


def turn_flat_triangles(surface: Surface, height: float, left_out: frozenset[Step] = NO_STEPS) -> Change:
    """Turn the longest edge of each flat triangle, where that helps.

    The triangle abc, flat over its longest edge ab, and its neighbor bad become adc and dbc: both take the neighbor's
    label and UVs, so the surface moves by less than `height` and nothing opens. Vertices stay as they are. A turn that
    would make an edge twice, or a flatter triangle, is left out.

    Parameters
    ----------
    surface
        The surface.
    height
        Triangles lower than this are flat, mm.
    left_out
        Steps that are not made: the ends of an edge, the lower index first.

    Returns
    -------
    Change
        The surface with other triangles between the same vertices.
    """
    triangles = surface.triangles.astype(np.int64)
    uv = surface.uv.astype(np.float64)
    source = np.arange(len(triangles))
    points = surface.points
    steps: dict[int, tuple[Step, ...]] = {}
    for _ in range(_ROUNDS):
        low = _heights(points, triangles)
        flat = np.flatnonzero(low < height)
        if len(flat) == 0:
            break
        turned = 0
        owner = _edge_owner(triangles, np.unique(triangles[flat]))
        for face in flat[np.argsort(low[flat], kind="stable")].tolist():
            if low[face] >= height:  # a turn before has changed it
                continue
            corners = points[triangles[face]]
            lengths = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
            first = int(lengths.argmax())
            a, b, c = (int(v) for v in np.roll(triangles[face], -first))
            other, step = owner.get((b, a)), step_of_edge(points, min(a, b), max(a, b))
            if other is None or other == face or step in left_out:
                continue
            row = triangles[other].tolist()
            if a not in row or b not in row:
                continue
            at = row.index(b)
            d = row[(at + 2) % 3]
            if d == c or (c, d) in owner or (d, c) in owner:
                continue
            fresh = np.array([[a, d, c], [d, b, c]])
            after = _heights(points, fresh)
            if after.min() <= min(low[face], low[other]):
                continue
            uv_b, uv_a, uv_d = (uv[other, (at + k) % 3].copy() for k in range(3))
            t = float(np.clip(np.dot(points[c] - points[a], points[b] - points[a]) / lengths[first] ** 2, 0.0, 1.0))
            uv_c = uv_a + t * (uv_b - uv_a)
            triangles[face], triangles[other] = fresh
            low[face], low[other] = after
            uv[face], uv[other] = (uv_a, uv_d, uv_c), (uv_d, uv_b, uv_c)
            source[face] = source[other]
            del owner[(a, b)], owner[(b, a)]
            for which in (face, other):
                x, y, z = triangles[which].tolist()
                owner.update({(x, y): which, (y, z): which, (z, x): which})
            steps[face] = steps[other] = (step,)
            turned += 1
        if turned == 0:
            break
    if not steps:
        return unchanged(surface)
    return Change(surface.of_faces(source, points, triangles, uv), np.arange(len(triangles)), steps)


def _heights(points: NDArray[np.float64], triangles: NDArray[np.int64]) -> NDArray[np.float64]:
    """The height (k,) of each triangle over its longest edge."""
    a, b, c = triangle_corners(points, triangles).swapaxes(0, 1)
    ab, ac = b - a, c - a
    longest = np.maximum(np.maximum(length(ab), length(c - b)), length(ac))
    return np.asarray(length(cross(ab, ac)) / np.maximum(longest, 1e-300))


def _edge_owner(triangles: NDArray[np.int64], vertices: NDArray[np.int64]) -> dict[tuple[int, int], int]:
    """The triangle of each directed edge near some vertices: of all triangles that share a vertex with theirs."""
    mark = np.zeros(int(triangles.max()) + 1, bool)
    mark[vertices] = True
    for _ in range(2):
        mark[triangles[mark[triangles].any(axis=1)]] = True
    owner = {}
    for face in np.flatnonzero(mark[triangles].any(axis=1)).tolist():
        a, b, c = triangles[face].tolist()
        owner.update({(a, b): face, (b, c): face, (c, a): face})
    return owner
