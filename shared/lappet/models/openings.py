"""The openings of the face: where skin ends at the lids, the lips and the nostrils.

The body of the package goes on into eye sockets, mouth and nose. An opening is taken out by rings: the faces within so
many edges of the innermost vertices. Vertices are named by their numbers in the base mesh, on the left and in the middle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.models.body_mesh import BodyMesh


@dataclass(frozen=True)
class Opening:
    """An opening.

    Parameters
    ----------
    name
        What it is called.
    seeds
        Its innermost vertices, of the left side or the middle.
    rings
        How many rows of faces around them are taken out.
    paired
        Whether there is one on the right as well.
    """

    name: str
    seeds: tuple[int, ...]
    rings: int
    paired: bool


EYES = Opening("eyes", (8011,), 20, True)
MOUTH = Opening("mouth", (710,), 13, False)
NOSTRILS = Opening("nostrils", (7152, 7153, 7155, 7156, 7158), 2, True)
OPENINGS = (EYES, MOUTH, NOSTRILS)


def without_openings(mesh: BodyMesh, quads: NDArray[np.int64]) -> NDArray[np.int64]:
    """Take the openings out of the body's faces.

    Parameters
    ----------
    mesh
        The base mesh.
    quads
        Vertex indices of the body's faces, shape (m, 4).

    Returns
    -------
    NDArray[np.int64]
        Those that are outer skin, shape (k, 4).
    """
    inside = np.zeros(len(quads), bool)
    for opening in OPENINGS:
        seeds = np.array(opening.seeds)
        sides = [seeds, _mirrored(mesh, quads, seeds)] if opening.paired else [seeds]
        for side in sides:
            inside |= _within(quads, side, opening.rings, len(mesh.points))
    return quads[~inside]


def _within(quads: NDArray[np.int64], seeds: NDArray[np.int64], rings: int, count: int) -> NDArray[np.bool_]:
    """Which faces have a vertex that is fewer than `rings` edges from the seeds."""
    edges = np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2)
    reached = np.zeros(count, bool)
    reached[seeds] = True
    for _ in range(rings - 1):
        touched = edges[reached[edges].any(axis=1)]
        reached[touched] = True
    return np.asarray(reached[quads].any(axis=1))


def _mirrored(mesh: BodyMesh, quads: NDArray[np.int64], vertices: NDArray[np.int64]) -> NDArray[np.int64]:
    used = np.unique(quads)
    wanted = mesh.points[vertices] * (-1.0, 1.0, 1.0)
    away = np.linalg.norm(mesh.points[used][None] - wanted[:, None], axis=2)
    return np.asarray(used[away.argmin(axis=1)])
