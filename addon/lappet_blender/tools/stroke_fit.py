"""A stroke drawn free-hand as few points with a smooth curve through them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.geometry.curve import sample_curve


def simplify(points: ArrayLike, tolerance: float) -> list[int]:
    """The points of a polyline (n, 3) to keep so that no other lies farther than `tolerance` from what is left.

    The first and the last are always kept (Douglas and Peucker 1973).
    """
    line = np.asarray(points, np.float64).reshape(-1, 3)
    if len(line) < 3:
        return list(range(len(line)))
    keep = {0, len(line) - 1}
    spans = [(0, len(line) - 1)]
    while spans:
        a, b = spans.pop()
        if b - a < 2:
            continue
        distance = _to_segment(line[a + 1 : b], line[a], line[b])
        worst = int(distance.argmax())
        if distance[worst] > tolerance:
            middle = a + 1 + worst
            keep.add(middle)
            spans += [(a, middle), (middle, b)]
    return sorted(keep)


def fit_stroke(points: ArrayLike, tolerance: float) -> NDArray[np.float64]:
    """Points (k, 3) of a stroke (n, 3) through which a Catmull-Rom curve runs within `tolerance` of the stroke.

    The points that `simplify` keeps, and the middles of those spans where the curve swings out.
    """
    line = np.asarray(points, np.float64).reshape(-1, 3)
    moved = np.concatenate([[True], np.linalg.norm(np.diff(line, axis=0), axis=1) > 1e-9])
    line = line[moved]
    if len(line) < 3:
        return line
    kept = simplify(line, tolerance)
    while True:
        added = []
        for k, (a, b) in enumerate(pairwise(kept)):
            if b - a < 2:
                continue
            around = line[[kept[max(k - 1, 0)], a, b, kept[min(k + 2, len(kept) - 1)]]]
            curve = sample_curve(around, "catmullRom", step=max(0.5 * tolerance, 1e-6))
            off = _to_polyline(curve, line[a : b + 1]).max()
            if max(off, _to_polyline(line[a : b + 1], curve).max()) > tolerance:
                added.append((a + b) // 2)
        if not added:
            return line[kept]
        kept = sorted({*kept, *added})


def with_ends(points: ArrayLike) -> NDArray[np.float64]:
    """Control points of an open Catmull-Rom curve that begins and ends at the first and last of these (n, 3).

    USD's curve runs from its second to its last but one point, so both ends are given twice.
    """
    line = np.asarray(points, np.float64).reshape(-1, 3)
    return np.concatenate([line[:1], line, line[-1:]])


def _to_segment(points: NDArray[np.float64], a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    way = b - a
    square = float(way @ way)
    t = np.clip((points - a) @ way / square, 0.0, 1.0) if square > 0.0 else np.zeros(len(points))
    return np.linalg.norm(points - a - t[:, None] * way, axis=1)


def _to_polyline(points: NDArray[np.float64], line: NDArray[np.float64]) -> NDArray[np.float64]:
    """The distance (k,) of points (k, 3) to a polyline (n, 3), n >= 2."""
    distances = [_to_segment(points, a, b) for a, b in pairwise(line)]
    return np.min(distances, axis=0)
