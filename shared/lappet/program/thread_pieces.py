"""The pieces of threads from bite to bite, and which of them lead across a wound."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.border_loops import border_loops
from lappet.geometry.labeled_surface import FaceOrigin, Surface
from lappet.program.program import FrameConstraints


@dataclass(frozen=True, eq=False)
class ThreadPieces:
    """The pieces of the sutures of a frame, each from one bite to the next; p are they in all.

    Parameters
    ----------
    row
        Number of each one's thread among those that were given, shape (p,).
    points
        Its ends at rest in mm, shape (p, 2, 3).
    triangles
        Triangles under them, shape (p, 2).
    """

    row: NDArray[np.int64]
    points: NDArray[np.float64]
    triangles: NDArray[np.integer]

    def passes(self, parted: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Find the pieces that draw edges together: of a thread with many bites every other one that crosses a wound.

        What lies between two passes comes back over the wound askew, or goes on along it.

        Parameters
        ----------
        parted
            Which pieces cross a wound, shape (p,).

        Returns
        -------
        NDArray[np.bool_]
            Which are passes, shape (p,); of a thread of two bites its only piece.
        """
        kept = np.ones(len(parted), bool)
        for row in np.unique(self.row):
            own = np.flatnonzero(self.row == row)
            if len(own) > 1:
                kept[own] = False
                kept[own[parted[own]][::2]] = True
        return kept


def thread_pieces(frame: FrameConstraints) -> ThreadPieces:
    """List the pieces of the sutures of a frame, in the order of the sutures and of each thread.

    Parameters
    ----------
    frame
        The frame.

    Returns
    -------
    ThreadPieces
        The pieces.
    """
    counts = frame.suture_inner_bites if len(frame.suture_inner_bites) else np.zeros(len(frame.suture_index), np.int32)
    ends = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    bites, under = [], []
    for row, (anchors, faces) in enumerate(zip(frame.suture_anchors, frame.suture_triangles, strict=True)):
        inner = slice(ends[row], ends[row + 1])
        bites.append(np.concatenate([anchors[:1], frame.inner_bite_anchors[inner], anchors[1:]]))
        under.append(np.concatenate([faces[:1], frame.inner_bite_triangles[inner], faces[1:]]))
    return pieces_between(bites, under)


def pieces_between(bites: Sequence[NDArray[np.float64]], triangles: Sequence[NDArray[np.integer]]) -> ThreadPieces:
    """List the pieces of threads.

    Parameters
    ----------
    bites
        The bites of each at rest in mm, each of shape (n, 3).
    triangles
        Triangles under them, each of shape (n,).

    Returns
    -------
    ThreadPieces
        The pieces.
    """
    none = ThreadPieces(np.zeros(0, np.int64), np.zeros((0, 2, 3)), np.zeros((0, 2), np.int64))
    return (
        none
        if not bites
        else ThreadPieces(
            np.repeat(np.arange(len(bites)), [len(each) - 1 for each in bites]),
            np.concatenate([np.stack([each[:-1], each[1:]], axis=1) for each in bites]),
            np.concatenate([np.stack([each[:-1], each[1:]], axis=1) for each in triangles]),
        )
    )


@dataclass(frozen=True, eq=False)
class BitesAtWounds:
    """Bites, and the edges of wounds that they hold; q are they.

    Parameters
    ----------
    points
        Their places at rest in mm, shape (q, 3).
    edge
        The nearest places on edges that they hold, shape (q, 3).
    outward
        Normals of the walls there, out of the tissue, shape (q, 3).
    distance
        Distance from it in mm, infinite where a bite holds none, shape (q,).
    loop, along
        The loop of skin, and how far along it in mm, shape (q,).
    in_wall
        Whether a bite is in a wound's wall, shape (q,).
    length
        Length of each loop in mm.
    """

    points: NDArray[np.float64]
    edge: NDArray[np.float64]
    outward: NDArray[np.float64]
    distance: NDArray[np.float64]
    loop: NDArray[np.int64]
    along: NDArray[np.float64]
    in_wall: NDArray[np.bool_]
    length: NDArray[np.float64]

    def parted(self) -> NDArray[np.bool_]:
        """Find which bites the wound parts, each two that follow each other taken as a pair.

        Returns
        -------
        NDArray[np.bool_]
            Whether either of a pair lies beyond the wall of the other, shape (q / 2,).
        """
        return self.across() > 0.0

    def across(self) -> NDArray[np.float64]:
        """Find how much of each piece between two bites that follow each other leads across the wound between them.

        Returns
        -------
        NDArray[np.float64]
            Cosine of its angle to the direction across, where either bite lies beyond the wall of the other; else 0.
            Shape (q / 2,).
        """
        known = np.isfinite(self.distance).reshape(-1, 2).all(axis=1)
        other = self.points.reshape(-1, 2, 3)[:, ::-1].reshape(-1, 3)
        beyond = np.einsum("qi,qi->q", self.outward, other - self.edge) > 0.0
        crossing = known & beyond.reshape(-1, 2).all(axis=1)
        ways = np.diff(self.points.reshape(-1, 2, 3), axis=1)[:, 0]
        out = self.outward.reshape(-1, 2, 3)
        across = out[:, 0] - out[:, 1]
        sizes = np.linalg.norm(ways, axis=1) * np.linalg.norm(across, axis=1)
        cosine = np.einsum("pi,pi->p", ways, across) / np.maximum(sizes, 1e-300)
        return np.where(crossing, np.maximum(cosine, 0.0), 0.0)


_known: WeakKeyDictionary[Surface, _Edges | None] = WeakKeyDictionary()


def bites_at_wounds(
    surface: Surface, points: NDArray[np.float64], triangles: NDArray[np.integer], spacing: float
) -> BitesAtWounds | None:
    """Find the edges of wounds that bites hold.

    Parameters
    ----------
    surface
        Surface of the epoch at rest.
    points
        The bites in mm, shape (q, 3).
    triangles
        Triangles under them, shape (q,).
    spacing
        Lattice spacing in mm.

    Returns
    -------
    BitesAtWounds | None
        The bites with their edges, or None where there is no wound.
    """
    if surface not in _known:
        _known[surface] = _edges(surface)
    edges = _known[surface]
    if edges is None:
        return None
    in_wall = surface.origin[triangles] == FaceOrigin.WOUND_WALL
    first, chord = edges.ends[:, 0], edges.ends[:, 1] - edges.ends[:, 0]
    squared = np.maximum(np.einsum("ei,ei->e", chord, chord), 1e-300)
    along = np.clip(np.einsum("qei,ei->qe", points[:, None] - first, chord) / squared, 0.0, 1.0)
    way = first + along[..., None] * chord - points[:, None]
    distance = np.linalg.norm(way, axis=2)
    # An anchor belongs to its own side of a wound, however narrow that is: in a wall to edges above walls that face as
    # it does, elsewhere to edges that face away from it.
    facing = np.where(in_wall[:, None], _normals(surface, triangles) @ edges.outwards.T, 0.0)
    away = np.where(in_wall[:, None], facing, np.einsum("qei,ei->qe", way, edges.outwards))
    distance[away < -1e-3 * spacing] = np.inf
    row, edge = np.arange(len(points)), distance.argmin(axis=1)
    return BitesAtWounds(
        points,
        points + way[row, edge],
        edges.outwards[edge],
        distance[row, edge],
        edges.loop[edge],
        edges.start[edge] + along[row, edge] * np.sqrt(squared[edge]),
        in_wall,
        edges.length,
    )


@dataclass(frozen=True, eq=False)
class _Edges:
    """The edges of the skin at wounds.

    ends: their vertices in mm (e, 2, 3), in the direction of the skin. outwards: normals of the walls below them, out
    of the tissue (e, 3). loop: of each. start: how far along it each begins, mm. length: of each loop, mm.
    """

    ends: NDArray[np.float64]
    outwards: NDArray[np.float64]
    loop: NDArray[np.int64]
    start: NDArray[np.float64]
    length: NDArray[np.float64]


def _edges(surface: Surface) -> _Edges | None:
    """The edges of the skin that are those of wound walls as well; None where there are none."""
    loops = border_loops(surface.triangles[surface.origin == FaceOrigin.SKIN].astype(np.int64))
    if not loops:
        return None
    edges = np.concatenate([np.stack([loop, np.roll(loop, -1)], axis=1) for loop in loops])
    number = np.repeat(np.arange(len(loops)), [len(loop) for loop in loops])
    lengths = np.linalg.norm(surface.points[edges[:, 1]] - surface.points[edges[:, 0]], axis=1)
    length = np.bincount(number, lengths).astype(np.float64)
    start = np.cumsum(lengths) - lengths - np.repeat(np.cumsum(length) - length, np.bincount(number))
    walls = np.flatnonzero(surface.origin == FaceOrigin.WOUND_WALL)
    size, triangles = len(surface.points), surface.triangles[walls].astype(np.int64)
    sides = np.concatenate([triangles[:, k] * size + triangles[:, (k + 1) % 3] for k in range(3)])
    order = np.argsort(sides)
    wanted = edges[:, 1] * size + edges[:, 0]
    at = np.minimum(np.searchsorted(sides[order], wanted), len(sides) - 1)
    kept = np.flatnonzero(sides[order][at] == wanted) if len(sides) else np.zeros(0, np.int64)
    if not len(kept):
        return None
    wall = walls[order[at[kept]] % len(walls)]
    return _Edges(surface.points[edges[kept]], _normals(surface, wall), number[kept], start[kept], length)


def _normals(surface: Surface, faces: NDArray[np.integer]) -> NDArray[np.float64]:
    """The unit normals of faces (f,)."""
    a, b, c = np.moveaxis(surface.points[surface.triangles[faces]], 1, 0)
    normals = np.cross(b - a, c - a)
    return np.asarray(normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300))
