"""What is wrong with a triangle surface, and where: open, not manifold, not orientable, self-intersecting."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import RefusedError


class SurfaceError(RefusedError):
    """A surface that cannot be tissue; the sentence names the prim, the place and the remedy."""


def place(point: NDArray[np.float64]) -> str:
    """A point as people read it: (1.25, 0, -3) in mm."""
    return "(" + ", ".join(f"{float(c):.6g}" for c in point) + ")"


def signed_volume(points: NDArray[np.float64], triangles: NDArray[np.integer]) -> float:
    """The volume in mm³ enclosed by a closed surface, negative when it is turned inside out."""
    p = points - points.mean(axis=0)
    a, b, c = (p[triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def check_finite(points: NDArray[np.float64], counts: NDArray[np.int64], indices: NDArray[np.int64], prim: str) -> None:
    """Raises SurfaceError for points that are no numbers and for face indices that do not fit."""
    if len(points) == 0 or len(counts) == 0:
        raise SurfaceError(f"{prim}: the mesh is empty; give it points and faces")
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        raise SurfaceError(f"{prim}: point {bad[0]} is {tuple(points[bad[0]].tolist())}; replace it by finite numbers")
    if counts.sum() != len(indices):
        raise SurfaceError(
            f"{prim}: the face vertex counts add up to {counts.sum()}, but there are {len(indices)} face vertex "
            "indices; export the mesh again"
        )
    outside = np.flatnonzero((indices < 0) | (indices >= len(points)))
    if len(outside):
        raise SurfaceError(
            f"{prim}: a face names point {indices[outside[0]]}, but the mesh has {len(points)} points; "
            "export the mesh again"
        )


def directed_edges(triangles: NDArray[np.integer]) -> NDArray[np.int64]:
    """The three directed edges of each triangle, (3m, 2)."""
    t = np.asarray(triangles, np.int64)
    return np.vstack([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]])


def open_edges(triangles: NDArray[np.integer]) -> NDArray[np.int64]:
    """The directed edges (k, 2) that belong to one triangle only."""
    edges = directed_edges(triangles)
    _, inverse, counts = unique_edges(edges)
    return edges[counts[inverse] == 1]


def unique_edges(edges: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """The undirected edges (u, 2), smaller index first, which of them each edge (k, 2) is, and how often they occur."""
    low, high = np.minimum(edges[:, 0], edges[:, 1]), np.maximum(edges[:, 0], edges[:, 1])
    size = int(high.max()) + 1 if len(edges) else 1
    key, inverse, counts = np.unique(low * size + high, return_inverse=True, return_counts=True)
    return np.stack([key // size, key % size], axis=1), inverse.reshape(-1), counts


def check_closed(points: NDArray[np.float64], triangles: NDArray[np.integer], prim: str) -> None:
    """Raises SurfaceError unless every edge belongs to exactly two triangles that run along it in opposite ways."""
    if not _is_closed(triangles):  # what is wrong with it takes longer to say
        _refuse_open(points, triangles, prim)
        check_oriented(points, triangles, prim)
    volume = signed_volume(points, triangles)
    if not abs(volume) > 1e-12 * float(np.ptp(points, axis=0).max()) ** 3:
        raise SurfaceError(f"{prim}: the surface encloses no volume ({volume:.3g} mm³); give the tissue a thickness")


def _is_closed(triangles: NDArray[np.integer]) -> bool:
    """Whether every directed edge occurs once and the other way around once."""
    a, b = directed_edges(triangles).T
    size = int(triangles.max(initial=0)) + 1
    ahead = np.sort(a * size + b)
    return bool((a != b).all() and (np.diff(ahead) > 0).all() and np.array_equal(ahead, np.sort(b * size + a)))


def _refuse_open(points: NDArray[np.float64], triangles: NDArray[np.integer], prim: str) -> None:
    lone = open_edges(triangles)
    if len(lone):
        raise SurfaceError(
            f"{prim}: the surface is open: {len(lone)} edges belong to one face only, the first at "
            f"{place(points[lone[0]].mean(axis=0))}; close the mesh, or make it with `lappet new MESH --thickness MM`"
        )


def check_oriented(points: NDArray[np.float64], triangles: NDArray[np.integer], prim: str) -> None:
    """Raises SurfaceError where more than two triangles share an edge, or two face opposite ways; it may be open."""
    edges = directed_edges(triangles)
    undirected, inverse, counts = unique_edges(edges)

    def middle(which: int) -> str:
        return place(points[undirected[which]].mean(axis=0))

    crowded = np.flatnonzero(counts > 2)
    if len(crowded):
        raise SurfaceError(
            f"{prim}: the surface is not manifold: {counts[crowded[0]]} faces share the edge at {middle(crowded[0])}; "
            "leave two of them"
        )
    forward = np.zeros(len(undirected), np.int64)
    np.add.at(forward, inverse, np.where(edges[:, 0] < edges[:, 1], 1, -1))
    twisted = np.flatnonzero((counts == 2) & (forward != 0))
    if len(twisted):
        raise SurfaceError(
            f"{prim}: the surface is not oriented alike: the two faces at {middle(twisted[0])} face opposite ways "
            f"({len(twisted)} such edges); make the normals consistent"
        )


def check_not_self_intersecting(points: NDArray[np.float64], triangles: NDArray[np.integer], prim: str) -> None:
    """Raises SurfaceError when two triangles that share no vertex pass through each other."""
    pair = first_intersection(points, triangles)
    if pair is not None:
        here = points[triangles[list(pair)]].mean(axis=(0, 1))
        raise SurfaceError(
            f"{prim}: the surface passes through itself near {place(here)} (triangles {pair[0]} and {pair[1]}); "
            "move these parts of the mesh away from each other"
        )


def first_intersection(points: NDArray[np.float64], triangles: NDArray[np.integer]) -> tuple[int, int] | None:
    """A pair of triangles without a common vertex that pierce each other, or None; see `intersections`."""
    for pairs in intersections(points, triangles):
        return int(pairs[0].min()), int(pairs[0].max())
    return None


def intersections(points: NDArray[np.float64], triangles: NDArray[np.integer]) -> Iterator[NDArray[np.int64]]:
    """The pairs (k, 2) of triangles without a common vertex that pierce each other, some at a time.

    Candidate pairs share a cell of a grid; a pair intersects when an edge of one crosses the inside of the other
    (Möller and Trumbore 1997). A corner that only touches the other triangle does not count.
    """
    t = np.asarray(triangles, np.int64)
    corners = points[t]
    low, high = corners.min(axis=1), corners.max(axis=1)
    for left, right in _overlapping_boxes(low, high):
        shared = (t[left][:, :, None] == t[right][:, None, :]).any(axis=(1, 2))
        left, right = left[~shared], right[~shared]
        hit = _pierces(corners[left], corners[right]) | _pierces(corners[right], corners[left])
        if hit.any():
            yield np.stack([left[hit], right[hit]], axis=1)


def _overlapping_boxes(
    low: NDArray[np.float64], high: NDArray[np.float64]
) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64]]]:
    """Index arrays (left, right) of boxes (n, 3) that overlap or touch, each pair once."""
    size = max(float(np.median((high - low).max(axis=1))) * 1.5, float((high - low).max()) / 32.0, 1e-30)
    origin = low.min(axis=0)
    first = np.floor((low - origin) / size).astype(np.int64)
    last = np.floor((high - origin) / size).astype(np.int64)
    span = last - first + 1
    copies = span.prod(axis=1)
    box = np.repeat(np.arange(len(low)), copies)
    local = np.arange(len(box)) - np.repeat(np.cumsum(copies) - copies, copies)
    s = span[box]
    cell = first[box] + np.stack([local // (s[:, 1] * s[:, 2]), local // s[:, 2] % s[:, 1], local % s[:, 2]], axis=1)
    extent = last.max(axis=0) + 1
    key = (cell[:, 0] * extent[1] + cell[:, 1]) * extent[2] + cell[:, 2]
    order = np.argsort(key, kind="stable")
    key, box = key[order], box[order]
    for shift in range(1, len(key)):
        same = np.flatnonzero(key[shift:] == key[:-shift])
        if len(same) == 0:
            return
        a, b = box[same], box[same + shift]
        overlap = ((low[a] <= high[b]) & (low[b] <= high[a])).all(axis=1)
        # A common box counts in the cell that holds its lower corner only.
        corner = np.floor((np.maximum(low[a], low[b]) - origin) / size).astype(np.int64)
        here = (corner[:, 0] * extent[1] + corner[:, 1]) * extent[2] + corner[:, 2] == key[same]
        keep = overlap & here
        if keep.any():
            yield a[keep], b[keep]


def _pierces(one: NDArray[np.float64], other: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether an edge of triangle `one` (k, 3, 3) passes through triangle `other`, its border included."""
    a = other[:, 0]
    u, v = other[:, 1] - a, other[:, 2] - a
    hit = np.zeros(len(one), bool)
    for i in range(3):
        start, ray = one[:, i], one[:, (i + 1) % 3] - one[:, i]
        p = np.cross(ray, v)
        det = np.einsum("ij,ij->i", u, p)
        scale = np.linalg.norm(u, axis=1) * np.linalg.norm(v, axis=1) * np.linalg.norm(ray, axis=1)
        proper = np.abs(det) > 1e-9 * scale
        inverse = np.divide(1.0, det, out=np.zeros_like(det), where=proper)
        s = start - a
        q = np.cross(s, u)
        x = np.einsum("ij,ij->i", s, p) * inverse
        y = np.einsum("ij,ij->i", ray, q) * inverse
        at = np.einsum("ij,ij->i", v, q) * inverse
        e = 1e-9
        hit |= proper & (x > -e) & (y > -e) & (x + y < 1 + e) & (at > e) & (at < 1 - e)
    return hit
