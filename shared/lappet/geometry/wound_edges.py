"""The edges of wounds on the skin: where it meets a wound's wall, as loops that positions and arcs lie on."""

from __future__ import annotations

import heapq
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.border_loops import border_loops
from lappet.geometry.labeled_surface import FaceOrigin, Surface
from lappet.geometry.surface_check import directed_edges
from lappet.geometry.triangles import area_normals, directions

# How far from a wound's edge, along the surface, a point may lie to belong to it in mm (chosen: a wide bite).
REACH = 10.0
_ACROSS = (
    10.0  # how much a millimeter out of the tissue counts: what lies across a narrow cut belongs to the other edge
)


@dataclass(frozen=True)
class EdgePlace:
    """A place on a wound's edge.

    Parameters
    ----------
    loop
        Index of the loop in `WoundEdges.loops`.
    at
        Length along it at rest from its first vertex in mm.
    """

    loop: int
    at: float


@dataclass(frozen=True, eq=False)
class EdgeLoop:
    """A closed loop around skin, which lies on its left as seen from outside.

    Parameters
    ----------
    vertices
        Vertices of the surface in order, shape (k,).
    along
        Length at rest up to each and around the whole in mm, shape (k + 1,).
    wound
        Which edges, from each vertex to the next, meet a wound's wall; the others meet the rim, shape (k,), bool.
    outwards
        Unit normals of the walls at these, out of the tissue; zero at the others, shape (k, 3).
    """

    vertices: NDArray[np.int64]
    along: NDArray[np.float64]
    wound: NDArray[np.bool_]
    outwards: NDArray[np.float64]

    @property
    def length(self) -> float:
        """Length around it at rest in mm."""
        return float(self.along[-1])

    def ahead(self, begin: float, end: float, way: int) -> float:
        """Measure the way from one place to another.

        Parameters
        ----------
        begin, end
            Places in mm along the loop.
        way
            1 in the direction of the loop, -1 against it.

        Returns
        -------
        float
            Length at rest in mm, from 0 to that of the loop.
        """
        return float((way * (end - begin)) % self.length)

    def to_rim(self, begin: float, way: int) -> float:
        """Measure how far the wound goes on from a place.

        Parameters
        ----------
        begin
            Place in mm along the loop.
        way
            1 in the direction of the loop, -1 against it.

        Returns
        -------
        float
            Length at rest in mm up to where the wound ends at the rim; infinite where it goes all around.
        """
        rims = np.flatnonzero(~self.wound)
        starts = self.along[rims] if way > 0 else self.along[rims + 1]
        return min((self.ahead(begin, float(start), way) for start in starts), default=np.inf)

    def nodes(self, begin: float, size: float, way: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """List the nodes of an arc: its ends and the vertices between.

        Parameters
        ----------
        begin
            Place in mm along the loop at which it begins.
        size
            Its length at rest in mm, at most that of the loop.
        way
            1 in the direction of the loop, -1 against it.

        Returns
        -------
        tuple[NDArray[np.int64], NDArray[np.float64]]
            The two vertices that each node lies between, shape (n, 2), and its share of the way from the first to the
            second, shape (n,).
        """
        ways = (way * (self.along[:-1] - begin)) % self.length
        order = np.argsort(ways, kind="stable")
        inner = order[(ways[order] > 1e-9) & (ways[order] < size - 1e-9)]
        first, last = self._node(begin), self._node(begin + way * size)
        vertices = self.vertices[inner]
        pairs = np.vstack([first[:2], np.stack([vertices, vertices], axis=1), last[:2]]).astype(np.int64)
        return pairs, np.concatenate([[first[2]], np.zeros(len(inner)), [last[2]]])

    def _node(self, at: float) -> tuple[int, int, float]:
        at = at % self.length
        k = min(int(np.searchsorted(self.along, at, side="right")) - 1, len(self.vertices) - 1)
        share = (at - self.along[k]) / max(self.along[k + 1] - self.along[k], 1e-300)
        return int(self.vertices[k]), int(self.vertices[(k + 1) % len(self.vertices)]), float(share)


class WoundEdges:
    """The edges of the wounds of an epoch's surface, and what of the surface lies near them.

    Parameters
    ----------
    surface
        The surface.

    Attributes
    ----------
    loops
        The loops around skin that meet a wound.
    distance
        Distance of each vertex of the surface from a wound's edge along the surface's edges in mm, infinite beyond
        `REACH`, shape (n,).
    nearest
        Vertex of an edge that this leads to, or -1, shape (n,).
    """

    def __init__(self, surface: Surface) -> None:
        self._surface = surface
        self.loops = _loops(surface)
        self._spots = {
            int(vertex): EdgePlace(index, float(loop.along[k]))
            for index, loop in enumerate(self.loops)
            for k, vertex in enumerate(loop.vertices)
            if loop.wound[k] or loop.wound[k - 1]
        }
        self.distance, self.nearest = _spread(surface, list(self._spots))

    def place_of(self, vertex: int) -> EdgePlace:
        """Tell where a vertex of a wound's edge is on it.

        Parameters
        ----------
        vertex
            One of `nearest`.

        Returns
        -------
        EdgePlace
            The place.
        """
        return self._spots[int(vertex)]

    def locate(self, point: NDArray[np.float64], triangle: int) -> EdgePlace | None:
        """Find the place on a wound's edge that is nearest to a point of the tissue, on the point's own side.

        Parameters
        ----------
        point
            Rest point in mm, shape (3,).
        triangle
            Triangle of the surface that it lies on or under.

        Returns
        -------
        EdgePlace | None
            The place, or None where no edge is within `REACH`.
        """
        corners = self._surface.triangles[triangle]
        ways = self.distance[corners] + np.linalg.norm(self._surface.points[corners] - point, axis=1)
        best = int(np.argmin(ways))
        if not ways[best] <= REACH:
            return None
        near = self.place_of(self.nearest[corners[best]])
        loop = self.loops[near.loop]
        window = float(ways[best]) + float(np.diff(loop.along).max())
        middles = 0.5 * (loop.along[:-1] + loop.along[1:])
        off = np.abs((middles - near.at + 0.5 * loop.length) % loop.length - 0.5 * loop.length)
        kept = np.flatnonzero(loop.wound & (off <= window + 0.5 * np.diff(loop.along)))
        begins = self._surface.points[loop.vertices[kept]]
        steps = self._surface.points[np.roll(loop.vertices, -1)[kept]] - begins
        share = np.einsum("ij,ij->i", point - begins, steps) / np.maximum(np.einsum("ij,ij->i", steps, steps), 1e-300)
        share = np.clip(share, 0.0, 1.0)
        offsets = point - (begins + share[:, None] * steps)
        outside = np.maximum(np.einsum("ij,ij->i", offsets, loop.outwards[kept]), 0.0)
        k = int(np.argmin(np.linalg.norm(offsets, axis=1) + _ACROSS * outside))
        edge = kept[k]
        return EdgePlace(near.loop, float(loop.along[edge] + share[k] * (loop.along[edge + 1] - loop.along[edge])))


def _loops(surface: Surface) -> tuple[EdgeLoop, ...]:
    triangles = surface.triangles.astype(np.int64)
    walls = triangles[surface.origin == FaceOrigin.WOUND_WALL]
    normals = directions(area_normals(surface.points[walls]))
    # A wall's edge runs against that of the skin beside it.
    wall_at = {(int(b), int(a)): k % len(walls) for k, (a, b) in enumerate(directed_edges(walls))}
    found = []
    for vertices in border_loops(triangles[surface.origin == FaceOrigin.SKIN]):
        following = np.roll(vertices, -1)
        wall = np.array([wall_at.get((int(a), int(b)), -1) for a, b in zip(vertices, following, strict=True)])
        if not (wall >= 0).any():
            continue
        sizes = np.linalg.norm(surface.points[following] - surface.points[vertices], axis=1)
        outwards = np.where((wall >= 0)[:, None], normals[wall], 0.0)
        found.append(EdgeLoop(vertices, np.concatenate([[0.0], np.cumsum(sizes)]), wall >= 0, outwards))
    return tuple(found)


def _spread(surface: Surface, sources: list[int]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Dijkstra's way from all sources at once, up to `REACH`."""
    edges = directed_edges(surface.triangles.astype(np.int64))
    edges = edges[np.argsort(edges[:, 0], kind="stable")]
    starts = np.searchsorted(edges[:, 0], np.arange(len(surface.points) + 1)).tolist()
    sizes = np.linalg.norm(surface.points[edges[:, 1]] - surface.points[edges[:, 0]], axis=1).tolist()
    ends = edges[:, 1].tolist()
    distance = np.full(len(surface.points), np.inf)
    nearest = np.full(len(surface.points), -1, np.int64)
    waiting = [(0.0, vertex, vertex) for vertex in sources]
    heapq.heapify(waiting)
    while waiting:
        way, vertex, source = heapq.heappop(waiting)
        if nearest[vertex] >= 0:
            continue
        distance[vertex], nearest[vertex] = way, source
        for k in range(starts[vertex], starts[vertex + 1]):
            if way + sizes[k] <= REACH and nearest[ends[k]] < 0:
                heapq.heappush(waiting, (way + sizes[k], ends[k], source))
    return distance, nearest
