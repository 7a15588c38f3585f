"""The openings of the face: where skin ends at the lids, the lips and the nostrils.

The body of the package goes on into eye sockets, mouth and nose. An opening is an edge loop of its mesh: at each
vertex of four faces the loop goes straight on. What lies on its inner side is taken out. Vertices are named by their
numbers in the base mesh, on the left and in the middle.
"""

from __future__ import annotations

from collections import defaultdict
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
    edge
        Two neighboring vertices of the loop at which skin ends.
    within
        A vertex inside it.
    paired
        Whether there is one on the right as well; the vertices are those of the left then.
    """

    name: str
    edge: tuple[int, int]
    within: int
    paired: bool


OPENINGS = (
    Opening("eyes", (7774, 7773), 8011, True),
    Opening("mouth", (474, 7229), 710, False),
    Opening("nostrils", (7109, 7126), 7155, True),
)


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
    faces_at: dict[int, list[int]] = defaultdict(list)
    for number, quad in enumerate(quads.tolist()):
        for vertex in quad:
            faces_at[vertex].append(number)
    inside = np.zeros(len(quads), bool)
    for opening in OPENINGS:
        named = np.array([*opening.edge, opening.within])
        for start, onwards, within in [named, _mirrored(mesh, quads, named)] if opening.paired else [named]:
            loop = edge_loop(quads, faces_at, int(start), int(onwards))
            inside[_faces_within(quads, faces_at, loop, int(within))] = True
    return quads[~inside]


def edge_loop(quads: NDArray[np.int64], faces_at: dict[int, list[int]], start: int, onwards: int) -> list[int]:
    """Follow an edge of a mesh straight on until it closes.

    Parameters
    ----------
    quads
        Vertex indices of the faces, shape (m, 4).
    faces_at
        The faces at each vertex.
    start
        First vertex.
    onwards
        Second vertex.

    Returns
    -------
    list[int]
        The vertices of the loop in order.

    Raises
    ------
    ValueError
        If the loop comes to a vertex that has other than four faces.
    """
    loop = [start, onwards]
    while True:
        before, here = loop[-2:]
        around = quads[faces_at[here]]
        if len(around) != 4:
            raise ValueError(f"the edge loop from {start} ends at {here}, which has {len(around)} faces")
        neighbors = {
            int(quad[(k + turn) % 4]) for quad in around for k in np.flatnonzero(quad == here) for turn in (1, 3)
        }
        beside = {int(vertex) for quad in around if before in quad for vertex in quad}
        ahead = (neighbors - beside).pop()
        if ahead == start:
            return loop
        loop.append(ahead)


def _faces_within(quads: NDArray[np.int64], faces_at: dict[int, list[int]], loop: list[int], within: int) -> list[int]:
    """The faces that are reached from a vertex without crossing the loop."""
    walls = {frozenset(pair) for pair in zip(loop, [*loop[1:], loop[0]], strict=True)}
    found = set(faces_at[within])
    pending = list(found)
    while pending:
        quad = quads[pending.pop()].tolist()
        for k in range(4):
            edge = (quad[k], quad[(k + 1) % 4])
            if frozenset(edge) in walls:
                continue
            beyond = set(faces_at[edge[0]]).intersection(faces_at[edge[1]]) - found
            found |= beyond
            pending += beyond
    return sorted(found)


def _mirrored(mesh: BodyMesh, quads: NDArray[np.int64], vertices: NDArray[np.int64]) -> NDArray[np.int64]:
    used = np.unique(quads)
    wanted = mesh.points[vertices] * (-1.0, 1.0, 1.0)
    away = np.linalg.norm(mesh.points[used][None] - wanted[:, None], axis=2)
    return np.asarray(used[away.argmin(axis=1)])
