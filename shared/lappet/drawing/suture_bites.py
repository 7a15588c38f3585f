"""Where a stitch enters the skin: two bites across the closed wound, and which sutures show on the skin at all.

A suture of the procedure joins two material points, which coincide once it is closed. A surgeon's stitch bites a little
away from the edge and crosses the wound at right angles. The bites are found where the suture is closed and ride on the
skin from then on and before; which lip each belongs to is read off the open wound, where the lips are apart.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.drawing.skin_fields import SKIN, WOUND_WALL
from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.connected_parts import parts_of

BITE = 1.3
BURIED_DEPTH = 0.4
CLOSED_GAP = 1.0
# A lip whose edges spread in direction by more than this share is a corner: a flap's tip or the end of a cut.
CORNER = 0.06


@dataclass(frozen=True, eq=False)
class Bite:
    """A point that rides on the skin.

    Parameters
    ----------
    vertices
        A triangle's vertices, shape (3,), int32.
    weights
        Their weights, shape (3,), which sum to 1.
    """

    vertices: NDArray[np.int32]
    weights: NDArray[np.float64]

    def carried(self, values: NDArray[np.float32]) -> NDArray[np.float64]:
        """Carry the bite along with the skin.

        Parameters
        ----------
        values
            A vector for each vertex, shape (n, 3).

        Returns
        -------
        NDArray[np.float64]
            The value at the bite, shape (3,).
        """
        return self.weights @ values[self.vertices].astype(np.float64)


def carried(bites: Sequence[Bite], values: NDArray[np.float32]) -> NDArray[np.float64]:
    """Carry some bites along with the skin.

    Parameters
    ----------
    bites
        The bites, k of them.
    values
        A vector for each vertex, shape (n, 3).

    Returns
    -------
    NDArray[np.float64]
        The values at the bites, shape (k, 3).
    """
    vertices = np.array([b.vertices for b in bites], np.int64).reshape(-1, 3)
    weights = np.array([b.weights for b in bites], np.float64).reshape(-1, 3)
    placed: NDArray[np.float64] = np.einsum("kc,kci->ki", weights, values[vertices].astype(np.float64))
    return placed


@dataclass(frozen=True, eq=False)
class Lip:
    """The skin around one end of a suture, joined to it without crossing the wound, and its stretch of wound edge.

    Parameters
    ----------
    disk
        Triangles of that skin, shape (k, 3), int32.
    edges
        Edges between skin and wound wall that belong to the disk, shape (e, 2), int32.
    """

    disk: NDArray[np.int32]
    edges: NDArray[np.int32]


def buried(
    positions: NDArray[np.float32],
    triangles: NDArray[np.int32],
    depth: NDArray[np.float32],
    ends: NDArray[np.float32],
) -> bool:
    """Tell whether a suture lies in the depth: an end is more than `BURIED_DEPTH` mm below the skin.

    That the lips overlap at this frame does not matter.

    Parameters
    ----------
    positions
        Vertices in mm, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).
    depth
        How deep each vertex lies below the edge of the skin in mm, shape (n,); 0 on the skin.
    ends
        The suture's ends on the surface in mm, shape (2, 3).

    Returns
    -------
    bool
        Whether it does.
    """
    return any(
        float(bite.weights @ depth[bite.vertices]) > BURIED_DEPTH for bite in bites_at(positions, triangles, ends)
    )


class TrianglesNear:
    """A search for the triangles about a point; made once for many points of one surface.

    Parameters
    ----------
    positions
        Vertices in mm, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).
    """

    def __init__(self, positions: NDArray[np.float32], triangles: NDArray[np.int32]) -> None:
        first = positions[triangles[:, 0]]
        self._order = np.argsort(first[:, 0], kind="stable")
        self._first = first[self._order]
        self.longest = longest_edge(positions, triangles)

    def around(self, point: NDArray[np.floating[Any]], reach: float) -> NDArray[np.int64]:
        """Find the triangles around a point.

        Parameters
        ----------
        point
            A point in mm, shape (3,), on the surface, or as near to it as its longest edge, if it can be.
        reach
            How much farther than the nearest a triangle's first vertex may lie from it, mm.

        Returns
        -------
        NDArray[np.int64]
            Indices of the triangles, ascending, shape (k,).
        """
        span = reach + self.longest
        while True:
            low, high = np.searchsorted(self._first[:, 0], [point[0] - span, point[0] + span])
            near = self._first[low:high] - point.astype(np.float32)
            away = np.sqrt(np.einsum("ij,ij->i", near, near))
            limit = float(away.min(initial=np.inf)) + reach
            if limit <= span or high - low == len(self._first):
                return np.sort(self._order[low:high][away <= limit])
            span *= 2.0


def longest_edge(positions: NDArray[np.float32], triangles: NDArray[np.int32]) -> float:
    """Measure the longest edge of some triangles.

    Parameters
    ----------
    positions
        Vertices in mm, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).

    Returns
    -------
    float
        Its length in mm; 0 where there are no triangles.
    """
    longest = 0.0
    for k in range(3):  # an edge at a time: all of them at once take several times as long
        edge = positions[triangles[:, k]] - positions[triangles[:, k - 1]]
        longest = max(longest, float(np.einsum("ij,ij->i", edge, edge).max(initial=0.0)))
    return math.sqrt(longest)


def bites_at(
    positions: NDArray[np.float32], triangles: NDArray[np.int32], points: NDArray[np.floating[Any]]
) -> list[Bite]:
    """Find the points of some triangles nearest to others.

    Parameters
    ----------
    positions
        Vertices in mm, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).
    points
        The other points in mm, shape (k, 3).

    Returns
    -------
    list[Bite]
        The nearest point for each.
    """
    return BitesInto(positions, triangles).at(points)


class BitesInto:
    """A search for the points of some triangles nearest to others; made once for many calls.

    Parameters
    ----------
    positions
        Vertices in mm, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).
    """

    def __init__(self, positions: NDArray[np.float32], triangles: NDArray[np.int32]) -> None:
        self._positions, self._triangles = positions, triangles
        corners = positions[triangles].reshape(-1, 3)  # of these triangles only: most are about a few of many
        self._closest = ClosestPoint(corners, np.arange(len(corners)).reshape(-1, 3))

    def at(self, points: NDArray[np.floating[Any]]) -> list[Bite]:
        """Find the points nearest to others.

        Parameters
        ----------
        points
            The other points in mm, shape (k, 3).

        Returns
        -------
        list[Bite]
            The nearest point for each.
        """
        index, closest, _ = self._closest.query(points)
        bites = []
        for triangle, point in zip(self._triangles[index], closest, strict=True):
            corners = self._positions[triangle].astype(np.float64)
            weights, *_ = np.linalg.lstsq(np.vstack([corners.T, np.ones(3)]), np.append(point, 1.0), rcond=None)
            weights = np.clip(weights, 0.0, None)
            bites.append(Bite(triangle, weights / weights.sum()))
        return bites


def _reachable(
    positions: NDArray[np.float32], triangles: NDArray[np.int32], seed: NDArray[np.int32], radius: float
) -> NDArray[np.bool_]:
    """Triangles (m,) joined to the vertices of a seed by vertices that lie within a radius (mm) of the seed."""
    used, corners = np.unique(triangles, return_inverse=True)  # a few of many
    corners, seed_at = corners.reshape(-1, 3), np.searchsorted(used, seed)
    near = np.linalg.norm(positions[used] - positions[seed].mean(axis=0), axis=1) <= radius
    near[seed_at] = True
    inside = near[corners]
    touched = np.flatnonzero(inside.any(axis=1))
    # Parts of what is near alone: a corner beyond the radius counts as one of its triangle's that is not.
    own, first = inside[touched], inside[touched].argmax(axis=1)
    joined = np.where(own, corners[touched], np.take_along_axis(corners[touched], first[:, None], axis=1))
    part = parts_of(joined, len(used))
    taken = np.zeros(len(triangles), bool)
    taken[touched] = part == part[(joined == seed_at[0]).any(axis=1).argmax()]
    return taken


def find_lip(
    positions: NDArray[np.float32],
    triangles: NDArray[np.int32],
    origin: NDArray[np.uint8],
    end: NDArray[np.float32],
    radius: float = 2.0 * BITE,
) -> Lip:
    """Find the lip of the wound that an end of a suture holds, while the wound is open.

    Parameters
    ----------
    positions
        Vertices in mm, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).
    origin
        An index into `ORIGINS` for each triangle, shape (m,).
    end
        The suture's end in mm, shape (3,).
    radius
        Of the lip's disk in mm.

    Returns
    -------
    Lip
        The lip.
    """
    skin = triangles[origin == SKIN]
    seed = bites_at(positions, skin, end[None].astype(np.float64))[0].vertices
    disk = skin[_reachable(positions, skin, seed, radius)]
    stride = int(triangles.max(initial=0)) + 1

    def keys(t: NDArray[np.int32]) -> NDArray[np.int64]:
        pairs = np.sort(np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]]).astype(np.int64), axis=1)
        return pairs[:, 0] * stride + pairs[:, 1]

    shared = np.intersect1d(keys(disk), keys(triangles[origin == WOUND_WALL]))
    return Lip(disk, np.stack(np.divmod(shared, stride), axis=-1).astype(np.int32))


def inward(positions: NDArray[np.float32], lip: Lip, at: NDArray[np.float64], reach: float) -> NDArray[np.float64]:
    """Find the direction from a place on a lip's edge into its skin: across the edge, or halving its corner.

    Where the lip has no wound edge it leads to the middle of the disk.

    Parameters
    ----------
    positions
        Vertices in mm, shape (n, 3).
    lip
        The lip.
    at
        The place in mm, shape (3,).
    reach
        How far along the edge the direction looks, mm.

    Returns
    -------
    NDArray[np.float64]
        A unit vector, shape (3,).
    """
    a, b, c = (positions[lip.disk[:, k]].astype(np.float64) for k in range(3))
    face = np.cross(b - a, c - a)
    area = np.linalg.norm(face, axis=1)
    normal = _unit(face.sum(axis=0))
    middle = ((a + b + c) / 3 * area[:, None]).sum(axis=0) / max(float(area.sum()), 1e-12)
    into = middle - at
    into -= (into @ normal) * normal
    if len(lip.edges):
        ends = positions[lip.edges].astype(np.float64)
        along = ends[:, 1] - ends[:, 0]
        away = np.linalg.norm(ends.mean(axis=1) - at, axis=1)
        length = np.maximum(np.linalg.norm(along, axis=1), 1e-9)
        weight = np.exp(-((away / reach) ** 2)) / length
        spread, axes = np.linalg.eigh(np.einsum("i,ij,ik->jk", weight, along, along))
        if spread[1] < CORNER * spread[2]:
            edge = axes[:, 2] - (axes[:, 2] @ normal) * normal
            edge = _unit(edge)
            across = into - (into @ edge) * edge
            if np.linalg.norm(across) > 0.2 * np.linalg.norm(into):
                into = across
    return _unit(into)


def find_bites(
    positions: NDArray[np.float32], lips: tuple[Lip, Lip], ends: NDArray[np.float32], bite: float = BITE
) -> tuple[Bite, Bite]:
    """Place the two bites of a stitch on either side of the wound's edge.

    Where the ends have met, both bites lie on one line across the wound; where they have not, each lies across its own
    lip.

    Parameters
    ----------
    positions
        Vertices in mm of the frame in which the suture is closed, or nearest to closed, shape (n, 3).
    lips
        The lips that the ends hold.
    ends
        The suture's ends in that frame in mm, shape (2, 3).
    bite
        Distance of a bite from the edge in mm.

    Returns
    -------
    tuple[Bite, Bite]
        The bites, in the order of the ends.
    """
    p = ends.astype(np.float64)
    ways = [inward(positions, lip, at, bite) for lip, at in zip(lips, p, strict=True)]
    if np.linalg.norm(p[1] - p[0]) <= CLOSED_GAP:
        middle = p.mean(axis=0)
        across = _unit(ways[1] - ways[0])
        p, ways = np.stack([middle, middle]), [-across, across]
    a, b = (
        bites_at(positions, lip.disk, (at + bite * way)[None])[0] for lip, at, way in zip(lips, p, ways, strict=True)
    )
    return a, b


def _unit(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    unit: NDArray[np.float64] = vector / max(float(np.linalg.norm(vector)), 1e-12)
    return unit
