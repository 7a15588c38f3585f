"""What pictures need of a skin's faces: their normals and the edge of the wound."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.drawing.skin_source import ORIGINS
from lappet.geometry.triangles import area_normals

SKIN, WOUND_WALL, UNDERSIDE, RIM = range(len(ORIGINS))


def vertex_normals(
    positions: NDArray[np.float32], triangles: NDArray[np.int32], origin: NDArray[np.uint8], label: int
) -> NDArray[np.float32]:
    """Compute area-weighted unit normals of the faces of one origin.

    Parameters
    ----------
    positions
        Vertices in mm, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).
    origin
        An index into `ORIGINS` for each triangle, shape (m,).
    label
        The origin whose faces count.

    Returns
    -------
    NDArray[np.float32]
        Normals, shape (n, 3); 0 at vertices that touch none of the faces.
    """
    t = triangles[origin == label]
    face = np.cross(positions[t[:, 1]] - positions[t[:, 0]], positions[t[:, 2]] - positions[t[:, 0]])
    total = np.zeros((len(positions), 3), np.float64)
    for k in range(3):
        for axis in range(3):
            total[:, axis] += np.bincount(t[:, k], weights=face[:, axis], minlength=len(positions))
    return (total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-12)).astype(np.float32)


class SkinNormals:
    """Unit normals of the faces of one origin, at a few vertices at a time.

    Parameters
    ----------
    triangles
        Vertex indices, shape (m, 3).
    origin
        An index into `ORIGINS` for each triangle, shape (m,).
    label
        The origin whose faces count.
    count
        Number of vertices.
    """

    def __init__(self, triangles: NDArray[np.int32], origin: NDArray[np.uint8], label: int, count: int) -> None:
        self._triangles = triangles[origin == label]
        corners = self._triangles.ravel()
        self._faces = np.argsort(corners, kind="stable") // 3
        self._first = np.searchsorted(np.sort(corners), np.arange(count + 1))

    @property
    def used(self) -> NDArray[np.bool_]:
        """Whether each vertex touches any of the faces, shape (n,)."""
        return np.diff(self._first) > 0

    def at(self, positions: NDArray[np.float32], vertices: NDArray[np.integer]) -> NDArray[np.float64]:
        """Compute area-weighted unit normals at some vertices.

        Parameters
        ----------
        positions
            All vertices in mm, shape (n, 3).
        vertices
            Indices, shape (k,).

        Returns
        -------
        NDArray[np.float64]
            Normals, shape (k, 3); 0 where a vertex touches none of the faces.
        """
        counts = self._first[vertices + 1] - self._first[vertices]
        owner = np.repeat(np.arange(len(vertices)), counts)
        inside = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
        t = self._triangles[self._faces[np.repeat(self._first[vertices], counts) + inside]]
        face = area_normals(positions[t].astype(np.float64))
        total = np.stack([np.bincount(owner, face[:, k], len(vertices)) for k in range(3)], axis=-1)
        return total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-12)


def border_chains(triangles: NDArray[np.int32], origin: NDArray[np.uint8]) -> list[NDArray[np.int32]]:
    """Join the edges between skin and wound wall into chains.

    Parameters
    ----------
    triangles
        Vertex indices, shape (m, 3).
    origin
        An index into `ORIGINS` for each triangle, shape (m,).

    Returns
    -------
    list[NDArray[np.int32]]
        Vertex indices of each chain, shape (k,); closed chains repeat their first.
    """

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
