"""The course of a stitch: where the thread enters the skin, its arc over the wound, the knot and its tails.

A suture of the procedure joins two material points, which coincide once it is closed. A surgeon's stitch bites a little
away from the edge, so each end is moved `BITE` mm into its own side of the wound, along the skin (never across the
wound), and from then on rides on the skin.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .skin_fields import SKIN, WOUND_WALL

BITE = 2.2
ARC = 0.55
BURIED = 0.7
KNOT_RADIUS = 0.34
KNOT_LENGTH = 1.0
TAIL = 2.6


@dataclass(frozen=True, eq=False)
class Bite:
    """A point that rides on the skin: a triangle's three vertices and their weights."""

    vertices: NDArray[np.int32]
    weights: NDArray[np.float64]

    def carried(self, values: NDArray[np.float32]) -> NDArray[np.float64]:
        """The value (3,) at the bite of a per-vertex array (n, 3)."""
        return self.weights @ values[self.vertices].astype(np.float64)


@dataclass(frozen=True, eq=False)
class StitchPath:
    """Polylines of a stitch, each (k, 3) in mm: the thread from bite to bite, the knot's coil, its two tails."""

    thread: NDArray[np.float64]
    knot: NDArray[np.float64]
    tails: tuple[NDArray[np.float64], NDArray[np.float64]]


def _reachable(
    positions: NDArray[np.float32], triangles: NDArray[np.int32], start: int, radius: float
) -> NDArray[np.bool_]:
    """Triangles (m,) joined to a vertex by triangles that lie within a radius (mm) of it."""
    near = np.linalg.norm(positions - positions[start], axis=1) <= radius
    member = np.zeros(len(positions), bool)
    member[start] = True
    taken = np.zeros(len(triangles), bool)
    while True:
        grown = ~taken & (member & near)[triangles].any(axis=1)
        grown |= ~taken & (triangles == start).any(axis=1)
        if not grown.any():
            return taken
        taken |= grown
        member[triangles[grown].ravel()] = True


def _project(point: NDArray[np.float64], corners: NDArray[np.float64]) -> tuple[int, NDArray[np.float64]]:
    """The triangle of corners (k, 3, 3) nearest to a point, and the weights (3,) of its point nearest by clamping."""
    a, e1, e2 = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    d11, d12, d22 = (np.einsum("ij,ij->i", x, y) for x, y in ((e1, e1), (e1, e2), (e2, e2)))
    r = point - a
    r1, r2 = np.einsum("ij,ij->i", r, e1), np.einsum("ij,ij->i", r, e2)
    det = np.maximum(d11 * d22 - d12 * d12, 1e-18)
    v, w = (d22 * r1 - d12 * r2) / det, (d11 * r2 - d12 * r1) / det
    weights = np.clip(np.stack([1 - v - w, v, w], axis=1), 0.0, None)
    weights /= weights.sum(axis=1, keepdims=True)
    gap = np.linalg.norm(np.einsum("ij,ijk->ik", weights, corners) - point, axis=1)
    best = int(gap.argmin())
    return best, weights[best]


def find_bite(
    positions: NDArray[np.float32],
    triangles: NDArray[np.int32],
    origin: NDArray[np.uint8],
    anchor: NDArray[np.float32],
    bite: float = BITE,
) -> Bite:
    """The point of the skin `bite` mm from a suture's end, away from the wound's edge and on the same side of it."""
    skin = triangles[origin == SKIN]
    used = np.unique(skin)
    start = int(used[np.linalg.norm(positions[used] - anchor, axis=1).argmin()])
    disk = skin[_reachable(positions, skin, start, 2.0 * bite)]
    members = np.unique(disk)
    edge = np.intersect1d(members, np.unique(triangles[origin == WOUND_WALL]))
    point = anchor.astype(np.float64)
    corners = positions[disk].astype(np.float64)
    if not len(edge):
        return Bite(*_weights(disk, _project(point, corners)))
    nearest = positions[edge[np.linalg.norm(positions[edge] - anchor, axis=1).argmin()]].astype(np.float64)
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    centre = (corners.mean(axis=1) * area[:, None]).sum(axis=0) / max(area.sum(), 1e-12)
    inward = centre - nearest
    inward /= max(float(np.linalg.norm(inward)), 1e-9)
    return Bite(*_weights(disk, _project(point + bite * inward, corners)))


def nearest_bite(
    positions: NDArray[np.float32], triangles: NDArray[np.int32], origin: NDArray[np.uint8], point: NDArray[np.float64]
) -> Bite:
    """The point of the skin nearest to a point (3,), mm, among the 16 triangles with the nearest centres."""
    skin = triangles[origin == SKIN]
    centres = positions[skin].mean(axis=1)
    count = min(16, len(skin))
    near = skin[np.argpartition(((centres - point) ** 2).sum(axis=1), count - 1)[:count]]
    return Bite(*_weights(near, _project(point, positions[near].astype(np.float64))))


def _weights(
    disk: NDArray[np.int32], hit: tuple[int, NDArray[np.float64]]
) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    return disk[hit[0]], hit[1]


def stitch_path(
    ends: NDArray[np.float64], normals: NDArray[np.float64], thread_radius: float, knot_at: float = 0.18
) -> StitchPath:
    """The polylines of a stitch between two bites.

    ends: (2, 3) mm, the bites on the skin. normals: (2, 3), unit normals of the skin there. thread_radius: mm.
    knot_at: where the knot sits, as a fraction of the way; it lies to one side of the wound, as it is tied.
    """
    across = ends[1] - ends[0]
    span = float(np.linalg.norm(across))
    up = normals.sum(axis=0)
    up /= max(float(np.linalg.norm(up)), 1e-9)
    along = across / max(span, 1e-9)
    u = np.linspace(0.0, 1.0, 17)[:, None]
    height = (thread_radius + ARC * np.sin(np.pi * u) ** 0.6) if span > 0.2 else np.full_like(u, thread_radius)
    over = ends[0] + u * across + height * up
    thread = np.vstack([ends[0] - BURIED * normals[0], over, ends[1] - BURIED * normals[1]])
    turns = np.linspace(0.0, 2.6, 40)
    sideways = np.cross(up, along)
    centre = ends[0] + knot_at * across + (np.interp(knot_at, u[:, 0], height[:, 0]) + 0.12) * up
    offset = (turns / turns[-1] - 0.5)[:, None] * KNOT_LENGTH * along
    angle = 2 * np.pi * turns[:, None]
    knot = centre + offset + KNOT_RADIUS * (np.cos(angle) * sideways + np.sin(angle) * up)
    s = np.linspace(0.0, 1.0, 7)[:, None]
    tails = tuple(
        centre + TAIL * s * (0.75 * sideways * side - 0.55 * along) + (0.9 * s - 0.75 * s**2) * up
        for side in (1.0, -0.35)
    )
    return StitchPath(thread, knot, (tails[0], tails[1]))
