"""Material points of the skin that a plate follows from panel to panel: the corners of what is cut, with letters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from string import ascii_lowercase

import numpy as np
from numpy.typing import NDArray

_STRETCH = 0.6  # mm: over so much of a cut before and after it a corner is judged
_TURN = np.radians(30.0)  # a cut that turns by more has a corner there
_SAME = 1.5  # mm: corners that are nearer are one
_ONE_CUT = np.radians(8.0)  # two cuts that meet at less lie on each other


@dataclass(frozen=True, eq=False)
class Sector:
    """The skin between two cuts that meet in a corner.

    Parameters
    ----------
    middle
        Unit vector along the skin from the corner into it, shape (3,).
    angle
        Its angle at the corner in radians; 2π at a free end of a cut.
    first, second
        Unit vectors along the two cuts that bound it, shape (3,).
    """

    middle: NDArray[np.float64]
    angle: float
    first: NDArray[np.float64]
    second: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Corner:
    """A corner of what is cut, in the tissue at rest.

    Parameters
    ----------
    letter
        Its letter, from a on.
    at
        The corner in mm, shape (3,).
    sectors
        The skin around it, the narrowest sector first.
    """

    letter: str
    at: NDArray[np.float64]
    sectors: tuple[Sector, ...]

    def inset(self, distance: float, sector: int = 0) -> NDArray[np.float64]:
        """Find a place beside the corner.

        Parameters
        ----------
        distance
            Distance from the corner in mm.
        sector
            Index of the sector in whose middle it lies.

        Returns
        -------
        NDArray[np.float64]
            The place in mm, shape (3,).
        """
        return self.at + distance * self.sectors[sector].middle


def cut_corners(lines: Sequence[NDArray[np.float64]], normal: NDArray[np.float64], apart: float = 0.0) -> list[Corner]:
    """Find the corners of the cuts of an operation.

    Parameters
    ----------
    lines
        The cuts at rest, sampled densely, in mm, each of shape (k, 3); a closed one repeats its first point.
    normal
        Unit normal of the skin, shape (3,).
    apart
        Of corners that are nearer to each other than this in mm, the sharpest is taken.

    Returns
    -------
    list[Corner]
        The corners in the order of the cuts, at most as many as there are letters.
    """
    places: list[NDArray[np.float64]] = []
    ways: list[list[NDArray[np.float64]]] = []
    for line in lines:
        for at, out in _turns(line):
            near = [k for k, place in enumerate(places) if np.linalg.norm(place - at) < _SAME]
            if near:
                ways[near[0]] += out
            else:
                places.append(at)
                ways.append(list(out))
    sectors = [_sectors(out, normal) for out in ways]
    kept: list[int] = []
    for k in sorted(range(len(places)), key=lambda each: sectors[each][0].angle):
        if all(np.linalg.norm(places[k] - places[other]) >= apart for other in kept):
            kept.append(k)
    named = zip(ascii_lowercase, sorted(kept), strict=False)
    return [Corner(letter, places[k], sectors[k]) for letter, k in named]


def _turns(line: NDArray[np.float64]) -> list[tuple[NDArray[np.float64], list[NDArray[np.float64]]]]:
    """Places of a cut at which it ends or turns, each with the unit ways along the cut from there."""
    closed = bool(np.allclose(line[0], line[-1]))
    points = line[:-1] if closed else line
    step = float(np.median(np.linalg.norm(np.diff(line, axis=0), axis=1)))
    reach = max(round(_STRETCH / max(step, 1e-9)), 1)
    count = len(points)

    def way(begin: int, to: int) -> NDArray[np.float64]:
        end = points[to % count] if closed else points[min(max(to, 0), count - 1)]
        away = end - points[begin]
        unit: NDArray[np.float64] = away / max(float(np.linalg.norm(away)), 1e-12)
        return unit

    turn = np.zeros(count)
    for k in range(count):
        if closed or 0 < k < count - 1:
            turn[k] = np.arccos(np.clip(-(way(k, k - reach) @ way(k, k + reach)), -1.0, 1.0))
    found = []
    order = np.argsort(-turn, kind="stable")
    kept: list[int] = []
    for k in order[turn[order] > _TURN]:
        gap = [abs(int(k) - each) for each in kept]
        if all(min(each, count - each if closed else each) > 2 * reach for each in gap):
            kept.append(int(k))
    for k in sorted(kept):
        found.append((points[k], [way(k, k - reach), way(k, k + reach)]))
    if not closed:
        found.insert(0, (points[0], [way(0, reach)]))
        found.append((points[-1], [way(count - 1, count - 1 - reach)]))
    return found


def legs(line: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Cut a line at its corners.

    Parameters
    ----------
    line
        A cut at rest, sampled densely, in mm, shape (k, 3); a closed one repeats its first point.

    Returns
    -------
    list[NDArray[np.float64]]
        Its pieces from corner to corner, each of shape (j, 3).
    """
    closed = bool(np.allclose(line[0], line[-1]))
    at = sorted({int(np.argmin(np.linalg.norm(line - place, axis=1))) for place, _ in _turns(line)})
    if closed:
        if not at:
            return [line]
        turned = np.vstack([line[at[0] : -1], line[: at[0] + 1]])
        at = [each - at[0] for each in at] + [len(turned) - 1]
        return [turned[a : b + 1] for a, b in pairwise(at)]
    at = sorted({0, *at, len(line) - 1})
    return [line[a : b + 1] for a, b in pairwise(at)]


def _sectors(ways: Sequence[NDArray[np.float64]], normal: NDArray[np.float64]) -> tuple[Sector, ...]:
    """The skin between cuts that meet, the narrowest first."""
    first = ways[0] - (ways[0] @ normal) * normal
    first /= max(float(np.linalg.norm(first)), 1e-12)
    second = np.cross(normal, first)

    def at(angle: float) -> NDArray[np.float64]:
        return np.asarray(np.cos(angle) * first + np.sin(angle) * second)

    angles = np.sort([np.arctan2(float(each @ second), float(each @ first)) for each in ways])
    gaps = np.diff(np.concatenate([angles, [angles[0] + 2.0 * np.pi]]))
    found = []
    for k in np.argsort(gaps, kind="stable"):
        if gaps[k] >= _ONE_CUT:
            begin, end = float(angles[k]), float(angles[k] + gaps[k])
            found.append(Sector(at(0.5 * (begin + end)), end - begin, at(begin), at(end)))
    return tuple(found)
