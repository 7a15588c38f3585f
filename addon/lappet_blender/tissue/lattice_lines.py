"""The cells of the lattice that the tissue's surface touches, as lines to draw."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.triangles import areas

MOST_LINES = 60_000
_MOST_SAMPLES = 4_000_000


def touched_cells(points: NDArray[np.float64], triangles: NDArray[np.integer], spacing: float) -> NDArray[np.int64]:
    """The cells (c, 3) of the grid of `spacing` mm through the origin that hold a sample of the surface.

    Samples lie closer than half a cell, so that only cells which a corner of the surface just reaches are missed.
    points: (n, 3) mm. triangles: (m, 3). Empty where more than four million samples were needed.
    """
    corners = points[triangles]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    parts = np.maximum(1, np.ceil(2.0 * sides / spacing)).astype(np.int64)
    if float(((parts + 1) * (parts + 2) / 2).sum()) > _MOST_SAMPLES:
        return np.zeros((0, 3), np.int64)
    found = []
    for n in np.unique(parts):
        i, j = np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij")
        inside = i + j <= n
        weights = np.stack([n - i[inside] - j[inside], i[inside], j[inside]], axis=1) / n
        samples = np.einsum("sk,mkx->msx", weights, corners[parts == n]).reshape(-1, 3)
        found.append(np.unique(np.floor(samples / spacing).astype(np.int64), axis=0))
    return np.unique(np.concatenate(found), axis=0) if found else np.zeros((0, 3), np.int64)


def cell_lines(cells: NDArray[np.int64], spacing: float) -> NDArray[np.float32]:
    """The edges (k, 2, 3), mm, of cells (c, 3), each once."""
    lines = []
    for axis in range(3):
        across = [k for k in range(3) if k != axis]
        starts = []
        for first in (0, 1):
            for second in (0, 1):
                corner = cells.copy()
                corner[:, across[0]] += first
                corner[:, across[1]] += second
                starts.append(corner)
        low = np.unique(np.concatenate(starts), axis=0)
        high = low.copy()
        high[:, axis] += 1
        lines.append(np.stack([low, high], axis=1))
    return (np.concatenate(lines) * spacing).astype(np.float32)


def box_lines(points: NDArray[np.float64], spacing: float) -> NDArray[np.float32]:
    """The lines (k, 2, 3), mm, of the grid on the sides of the tissue's box; every second, fifth … where too many."""
    low = np.floor(points.min(axis=0) / spacing)
    high = np.ceil(points.max(axis=0) / spacing)
    step = max(1.0, float(np.ceil((high - low).max() / 200.0)))
    lines = []
    for axis in range(3):
        u, v = (k for k in range(3) if k != axis)
        for running, fixed in ((u, v), (v, u)):
            at = np.unique(np.append(np.arange(low[running], high[running], step), high[running]))
            for end in (low[axis], high[axis]):
                pair = np.empty((len(at), 2, 3))
                pair[:, :, axis] = end
                pair[:, :, running] = at[:, None]
                pair[:, 0, fixed], pair[:, 1, fixed] = low[fixed], high[fixed]
                lines.append(pair)
    return (np.concatenate(lines) * spacing).astype(np.float32)


def lattice_lines(points: NDArray[np.float64], triangles: NDArray[np.integer], spacing: float) -> NDArray[np.float32]:
    """The lines (k, 2, 3), mm, to draw: the cells at the surface, or the grid on the box where these are too many."""
    if 4.0 * float(areas(points[triangles]).sum()) / spacing**2 <= 2.0 * MOST_LINES:
        cells = touched_cells(points, triangles, spacing)
        if len(cells):
            lines = cell_lines(cells, spacing)
            if len(lines) <= MOST_LINES:
                return lines
    return box_lines(points, spacing)
