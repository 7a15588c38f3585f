"""Whether sutures pair the edges of wounds in order: those that do not cross each other or fold the skin between them.

The skin's border consists of loops: around each wound, and around each fragment. Sutures that close wounds in a plane
pair its points like brackets: of two sutures on one loop, either none of the ends of the second lies between those of
the first, or both do. Between two loops (a fragment and its bed) the order of the ends along one is reversed along the
other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Place, Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.cutting.epoch import Epoch
from lappet.geometry.border_loops import border_loops
from lappet.geometry.labeled_surface import FaceOrigin, Surface
from lappet.geometry.surface_check import place
from lappet.procedure.prim_paths import TIMELINE
from lappet.program.program import FrameConstraints

REACH = 5.0  # lattice spacings from an anchor to the wound's edge that it holds, at most; chosen
DEEP = 0.25  # of its depth, how far along the edge an anchor in a wall may be off; chosen
NAMED = 3  # of the sutures that one crosses


@dataclass(frozen=True, eq=False)
class _Ends:
    """The ends of sutures on the wounds' edges.

    index: numbers of the sutures (s,). points: their ends in mm (s, 2, 3). loop, along: the loop (s, 2) that each end
    lies on, and how far along it in mm. unsure: by how much that may be off (s,). length: of each loop in mm.
    """

    index: NDArray[np.int32]
    points: NDArray[np.float64]
    loop: NDArray[np.int64]
    along: NDArray[np.float64]
    unsure: NDArray[np.float64]
    length: NDArray[np.float64]


def crossed_sutures(
    epochs: Sequence[Epoch], frames: Sequence[FrameConstraints], names: Sequence[str], spacing: float
) -> list[Problem]:
    """Find sutures that cross others along the edges of the wounds that they close.

    Parameters
    ----------
    epochs
        The epochs.
    frames
        The frames.
    names
        Names of the sutures by their number.
    spacing
        Lattice spacing in mm.

    Returns
    -------
    list[Problem]
        A warning for each suture that crosses others, the one that crosses most first; none of the others is told
        again.
    """
    if not frames or len(frames[-1].suture_index) < 2:
        return []
    last = frames[-1]  # sutures stay, so all of them act by now
    ends = _ends(next(epoch.surface for epoch in epochs if epoch.index == last.epoch), last, spacing)
    crossing = (
        {}
        if ends is None
        else {
            frozenset((int(ends.index[a]), int(ends.index[b]))): np.concatenate([ends.points[a], ends.points[b]])
            for a, b in _crossing_pairs(ends, spacing)
        }
    )
    found = []
    while crossing:
        of = {suture: [pair for pair in crossing if suture in pair] for pair in crossing for suture in pair}
        worst = max(of, key=lambda suture: (len(of[suture]), suture))
        others = sorted(next(iter(pair - {worst})) for pair in of[worst])
        said = " and ".join(names[other] for other in others[:NAMED])
        more = len(others) - NAMED
        said += f" and {more} more" if more > 0 else ""
        ends = crossing[of[worst][0]]
        code, path = ProblemCode.SUTURES_CROSSED, f"{TIMELINE}/{names[worst]}"
        middle = f"{place(np.round(ends.mean(axis=0), 2))} mm"
        found.append(problem(code, path, said, place=Place.at(*ends), where=middle))
        for pair in of[worst]:
            del crossing[pair]
    return found


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


def _ends(surface: Surface, frame: FrameConstraints, spacing: float) -> _Ends | None:
    """The ends of the sutures both of which lie near a wound's edge; None where there is no wound."""
    edges = _edges(surface)
    if edges is None:
        return None
    points, faces = frame.suture_anchors.reshape(-1, 3), frame.suture_triangles.reshape(-1)
    in_wall = surface.origin[faces] == FaceOrigin.WOUND_WALL
    first, chord = edges.ends[:, 0], edges.ends[:, 1] - edges.ends[:, 0]
    squared = np.maximum(np.einsum("ei,ei->e", chord, chord), 1e-300)
    along = np.clip(np.einsum("qei,ei->qe", points[:, None] - first, chord) / squared, 0.0, 1.0)
    way = first + along[..., None] * chord - points[:, None]
    distance = np.linalg.norm(way, axis=2)
    # An anchor belongs to its own side of a wound, however narrow that is: in a wall to edges above walls that face as
    # it does, elsewhere to edges that face away from it.
    facing = np.where(in_wall[:, None], _normals(surface, faces) @ edges.outwards.T, 0.0)
    away = np.where(in_wall[:, None], facing, np.einsum("qei,ei->qe", way, edges.outwards))
    distance[away < -1e-3 * spacing] = np.inf
    row, edge = np.arange(len(points)), distance.argmin(axis=1)
    nearest, share = distance[row, edge].reshape(-1, 2), along[row, edge]
    along_loop = edges.start[edge] + share * np.sqrt(squared[edge])
    kept = (nearest <= REACH * spacing).all(axis=1)
    if len(frame.suture_inner_bites):  # what a thread with more bites pairs is not at its ends
        kept &= frame.suture_inner_bites == 0
    unsure = np.where(in_wall.reshape(-1, 2), DEEP * nearest, nearest).max(axis=1, initial=0.0)
    return _Ends(
        frame.suture_index[kept],
        frame.suture_anchors[kept],
        edges.loop[edge].reshape(-1, 2)[kept],
        along_loop.reshape(-1, 2)[kept],
        unsure[kept],
        edges.length,
    )


def _crossing_pairs(ends: _Ends, spacing: float) -> list[tuple[int, int]]:
    """The pairs of rows that cross."""
    found = []
    order = np.sort(ends.loop, axis=1)
    groups = {tuple(pair) for pair in order.tolist()}
    for first, second in groups:
        rows = np.flatnonzero((order == (first, second)).all(axis=1)).tolist()
        if first == second:
            found += [pair for pair in combinations(rows, 2) if _interleaved(ends, *pair, spacing)]
        else:
            found += _against_order(ends, rows, first, spacing)
    return found


def _interleaved(ends: _Ends, i: int, j: int, spacing: float) -> bool:
    """Whether two sutures on one loop cross by more than their places are unsure."""
    length = ends.length[ends.loop[i, 0]]
    (a, b), (c, d) = ends.along[i], ends.along[j]
    apart = np.abs(np.array([a - c, a - d, b - c, b - d]))
    clear = np.minimum(apart, length - apart).min() > spacing + max(ends.unsure[i], ends.unsure[j])
    low, high = min(a, b), max(a, b)
    return bool(clear and (low < c < high) != (low < d < high))


def _against_order(ends: _Ends, rows: list[int], first: int, spacing: float) -> list[tuple[int, int]]:
    """The pairs of sutures between two loops that stand against the order of most of the others."""
    turned = {row: (0, 1) if ends.loop[row, 0] == first else (1, 0) for row in rows}
    wrong: dict[tuple[int, int], list[bool]] = {pair: [] for pair in combinations(rows, 2)}
    for triple in combinations(rows, 3):
        margin = spacing + max(ends.unsure[row] for row in triple)
        turns = []
        for side in (0, 1):
            length = ends.length[ends.loop[triple[0], turned[triple[0]][side]]]
            a, b, c = (ends.along[row, turned[row][side]] for row in triple)
            steps = np.array([b - a, c - b, a - c]) % length
            if min(steps.min(), (length - steps).min()) <= margin:
                break
            turns.append(bool(np.isclose(steps.sum(), length)))  # once around, or twice
        if len(turns) == 2:
            for pair in combinations(triple, 2):
                wrong[pair].append(turns[0] == turns[1])
    return [pair for pair, said in wrong.items() if said and 2 * sum(said) > len(said)]
