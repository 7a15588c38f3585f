"""Small spheres as one triangle mesh: the beads of landmarks."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

_RINGS, _SIDES = 6, 12


def spheres(centers: ArrayLike, radius: float) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Points (n, 3) and outward triangles (m, 3) of spheres around centers (k, 3), in the same unit."""
    polar = np.linspace(0.0, np.pi, _RINGS + 1)[1:-1]
    around = np.linspace(0.0, 2.0 * np.pi, _SIDES, endpoint=False)
    ring = np.stack(
        [
            np.outer(np.sin(polar), np.cos(around)),
            np.outer(np.sin(polar), np.sin(around)),
            np.outer(np.cos(polar), np.ones(_SIDES)),
        ],
        axis=-1,
    ).reshape(-1, 3)
    one = np.vstack([ring, [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]])
    k, n = np.arange(_SIDES), (np.arange(_SIDES) + 1) % _SIDES
    top, bottom, last = len(ring), len(ring) + 1, len(ring) - _SIDES
    faces = [np.stack([np.full(_SIDES, top), k, n], -1), np.stack([np.full(_SIDES, bottom), last + n, last + k], -1)]
    for row in range(_RINGS - 2):
        a, b = row * _SIDES + k, row * _SIDES + n
        faces += [np.stack([a, a + _SIDES, b + _SIDES], -1), np.stack([a, b + _SIDES, b], -1)]
    triangles = np.concatenate(faces)
    places = np.asarray(centers, np.float64).reshape(-1, 3)
    points = (places[:, None] + radius * one[None]).reshape(-1, 3)
    shifted = triangles[None] + len(one) * np.arange(len(places))[:, None, None]
    return points, shifted.reshape(-1, 3).astype(np.int32)
