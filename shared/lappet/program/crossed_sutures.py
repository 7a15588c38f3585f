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
from lappet.geometry.labeled_surface import Surface
from lappet.geometry.surface_check import place
from lappet.procedure import Suture
from lappet.procedure.prim_paths import TIMELINE
from lappet.program.program import FrameConstraints
from lappet.program.thread_pieces import bites_at_wounds, thread_pieces

REACH = 5.0  # lattice spacings from an anchor to the wound's edge that it holds, at most; chosen
DEEP = 0.25  # of its depth, how far along the edge an anchor in a wall may be off; chosen
NAMED = 3  # of the sutures that one crosses


@dataclass(frozen=True, eq=False)
class _Ends:
    """The ends of sutures, or of the passes of threads with more bites, on the wounds' edges.

    index: numbers of their sutures (s,). points: the ends in mm (s, 2, 3). loop, along: the loop (s, 2) that each end
    lies on, and how far along it in mm. unsure: by how much that may be off (s,). length: of each loop in mm.
    """

    index: NDArray[np.int32]
    points: NDArray[np.float64]
    loop: NDArray[np.int64]
    along: NDArray[np.float64]
    unsure: NDArray[np.float64]
    length: NDArray[np.float64]


def crossed_sutures(
    epochs: Sequence[Epoch], frames: Sequence[FrameConstraints], sutures: Sequence[Suture], spacing: float
) -> list[Problem]:
    """Find sutures that cross others along the edges of the wounds that they close.

    Parameters
    ----------
    epochs
        The epochs.
    frames
        The frames.
    sutures
        The sutures by their number.
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
            if ends.index[a] != ends.index[b]
        }
    )
    found = []
    while crossing:
        of = {suture: [pair for pair in crossing if suture in pair] for pair in crossing for suture in pair}
        worst = max(of, key=lambda suture: (len(of[suture]), suture))
        others = sorted(next(iter(pair - {worst})) for pair in of[worst])
        said = " and ".join(sutures[other].name for other in others[:NAMED])
        more = len(others) - NAMED
        said += f" and {more} more" if more > 0 else ""
        ends = crossing[of[worst][0]]
        code, path = ProblemCode.SUTURES_CROSSED, f"{TIMELINE}/{sutures[worst].name}"
        middle = f"{place(np.round(ends.mean(axis=0), 2))} mm"
        found.append(problem(code, path, said, place=Place.at(*ends), where=middle))
        for pair in of[worst]:
            del crossing[pair]
    return found


def _ends(surface: Surface, frame: FrameConstraints, spacing: float) -> _Ends | None:
    """The ends of the passes both of which lie near a wound's edge; None where there is no wound."""
    pieces = thread_pieces(frame)
    held = bites_at_wounds(surface, pieces.points.reshape(-1, 3), pieces.triangles.reshape(-1), spacing)
    if held is None:
        return None
    near = (held.distance.reshape(-1, 2) <= REACH * spacing).all(axis=1)
    kept = np.flatnonzero(near & pieces.passes(held.parted()))
    distance, in_wall = held.distance.reshape(-1, 2), held.in_wall.reshape(-1, 2)
    unsure = np.where(in_wall, DEEP * distance, distance).max(axis=1, initial=0.0)
    return _Ends(
        frame.suture_index[pieces.row[kept]],
        pieces.points[kept],
        held.loop.reshape(-1, 2)[kept],
        held.along.reshape(-1, 2)[kept],
        unsure[kept],
        held.length,
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
    rows_at = np.array(rows)
    count = len(rows)
    side = np.where(ends.loop[rows_at, 0] == first, 0, 1)
    along = np.stack([ends.along[rows_at, side], ends.along[rows_at, 1 - side]])
    length = ends.length[[ends.loop[rows_at[0], side[0]], ends.loop[rows_at[0], 1 - side[0]]]][:, None]
    unsure = ends.unsure[rows_at]
    told, against = np.zeros((count, count), np.int64), np.zeros((count, count), np.int64)
    # Every three of them, those of one first suture at a time: a run of a hundred stitches has 160 000.
    for i in range(count - 2):
        j, k = (i + 1 + each for each in np.triu_indices(count - i - 1, 1))
        a, b, c = along[:, [i]], along[:, j], along[:, k]
        steps = np.stack([b - a, c - b, a - c]) % length
        apart = np.minimum(steps, length - steps).min(axis=(0, 1))
        clear = apart > spacing + np.maximum(unsure[i], np.maximum(unsure[j], unsure[k]))
        once = steps.sum(axis=0) < 1.5 * length  # around the loop, or else twice
        wrong = clear & (once[0] == once[1])
        for one, other in ((np.full_like(j, i), j), (np.full_like(k, i), k), (j, k)):
            np.add.at(told, (one, other), clear)
            np.add.at(against, (one, other), wrong)
    found = np.argwhere((told > 0) & (2 * against > told))
    return [(rows[one], rows[other]) for one, other in found.tolist()]
