"""Quantities on the skin that the materials draw: normals and borders; the grid in mm and the depth are lappet's."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.background.skin_shape import depth_below_skin, uv_scale
from lappet.geometry.triangles import area_normals

from .skin_source import ORIGINS

__all__ = [
    "RIM",
    "SKIN",
    "UNDERSIDE",
    "WOUND_WALL",
    "SkinNormals",
    "border_chains",
    "depth_below_skin",
    "uv_scale",
    "vertex_normals",
]

SKIN, WOUND_WALL, UNDERSIDE, RIM = range(len(ORIGINS))


def vertex_normals(
    positions: NDArray[np.float32], triangles: NDArray[np.int32], origin: NDArray[np.uint8], label: int
) -> NDArray[np.float32]:
    """Area-weighted unit normals (n, 3) of the faces of one origin; 0 at vertices that touch none of them."""
    t = triangles[origin == label]
    face = np.cross(positions[t[:, 1]] - positions[t[:, 0]], positions[t[:, 2]] - positions[t[:, 0]])
    total = np.zeros((len(positions), 3), np.float64)
    for k in range(3):
        for axis in range(3):
            total[:, axis] += np.bincount(t[:, k], weights=face[:, axis], minlength=len(positions))
    return (total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-12)).astype(np.float32)


class SkinNormals:
    """Unit normals of the faces of one origin, at a few vertices at a time."""

    def __init__(self, triangles: NDArray[np.int32], origin: NDArray[np.uint8], label: int, count: int) -> None:
        """count: number of vertices."""
        self._triangles = triangles[origin == label]
        corners = self._triangles.ravel()
        self._faces = np.argsort(corners, kind="stable") // 3
        self._first = np.searchsorted(np.sort(corners), np.arange(count + 1))

    @property
    def used(self) -> NDArray[np.bool_]:
        """(n,): whether a vertex touches any of the faces."""
        return np.diff(self._first) > 0

    def at(self, positions: NDArray[np.float32], vertices: NDArray[np.integer]) -> NDArray[np.float64]:
        """(k, 3): area-weighted unit normals at vertices (k,); 0 where they touch none of the faces."""
        counts = self._first[vertices + 1] - self._first[vertices]
        owner = np.repeat(np.arange(len(vertices)), counts)
        inside = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
        t = self._triangles[self._faces[np.repeat(self._first[vertices], counts) + inside]]
        face = area_normals(positions[t].astype(np.float64))
        total = np.stack([np.bincount(owner, face[:, k], len(vertices)) for k in range(3)], axis=-1)
        return total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-12)


def border_chains(triangles: NDArray[np.int32], origin: NDArray[np.uint8]) -> list[NDArray[np.int32]]:
    """The edges between skin and wound wall, joined into chains of vertices (k,); closed chains repeat their first."""

    def edges(label: int) -> NDArray[np.int64]:
        t = triangles[origin == label].astype(np.int64)
        pairs = np.sort(np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]]), axis=1)
        return np.unique(pairs[:, 0] * (int(triangles.max(initial=0)) + 1) + pairs[:, 1])

    stride = int(triangles.max(initial=0)) + 1
    neighbors: dict[int, list[int]] = {}
    for key in np.intersect1d(edges(SKIN), edges(WOUND_WALL)):
        a, b = divmod(int(key), stride)
        neighbors.setdefault(a, []).append(b)
        neighbors.setdefault(b, []).append(a)
    chains = []
    # Ends and crossings first, so that what is left over is closed loops.
    for start in sorted(neighbors, key=lambda v: (len(neighbors[v]) == 2, v)):
        while neighbors[start]:
            chain = [start]
            while neighbors[chain[-1]]:
                here = chain[-1]
                there = neighbors[here].pop()
                neighbors[there].remove(here)
                chain.append(there)
                if len(neighbors[there]) != 1:
                    break
            chains.append(np.array(chain, np.int32))
    return chains
