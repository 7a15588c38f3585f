"""Evenly spaced pairs of points to suture: along two wound edges, or across an incision."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.curve import sample_curve
from lappet.procedure import Incision

BESIDE = 0.01  # mm from the wall of the cut to a suture's anchor: at the wound's edge, and off its middle


def shares_along(count: int, inset_start: float | None, inset_end: float | None) -> NDArray[np.float64]:
    """Shares (count,) of a length, evenly spaced: from one inset to the other, by default half a distance each.

    inset_start, inset_end: shares from the ends to the first and the last. Raises RefusedError for fewer than one and
    insets that leave nothing.
    """
    if count < 1:
        raise refused(ProblemCode.SUTURE_RUN_EMPTY, "", count)
    half = 0.5 / count
    first = half if inset_start is None else inset_start
    last = 1.0 - (half if inset_end is None else inset_end)
    if first > last:
        raise refused(ProblemCode.SUTURE_INSETS, "", f"{first:g}", last=1.0 - last)
    if count == 1:
        return np.array([0.5 * (first + last)])
    return np.linspace(first, last, count)


def along(line: ArrayLike, shares: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points (n, 3) of a polyline (k, 3) at shares (n,) of its length."""
    points = np.asarray(line, np.float64).reshape(-1, 3)
    reached = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    return np.stack([np.interp(shares * reached[-1], reached, points[:, k]) for k in range(3)], axis=1)


def length(line: ArrayLike) -> float:
    """The length of a polyline (k, 3)."""
    return float(np.linalg.norm(np.diff(np.asarray(line, np.float64).reshape(-1, 3), axis=0), axis=1).sum())


def count_for(size: float, spacing: float) -> int:
    """How many sutures `spacing` mm apart fill a length of `size` mm, at least one."""
    return max(1, round(size / spacing))


def across_incision(
    incision: Incision, shares: NDArray[np.float64], bite: float, skin: ClosestPoint, normals: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points (n, 3) on the skin to the left and the right of an incision, `bite` mm from its middle.

    shares: of the incision's length. skin: the tissue's surface at rest. normals: (m, 3), of its triangles. Raises
    CurveError for a line that cannot be followed.
    """
    line = incision_line(incision)
    middle, tangent = along(line, shares), _tangents(line, shares)
    triangle, _, _ = skin.query(middle)
    side = np.cross(normals[triangle], tangent)
    size = np.linalg.norm(side, axis=1, keepdims=True)
    if not (size > 1e-9).all():
        raise refused(ProblemCode.SUTURE_INTO_SKIN, incision.name)
    side = bite * side / size
    return skin.query(middle + side)[1], skin.query(middle - side)[1]


def incision_line(incision: Incision) -> NDArray[np.float64]:
    """The line that an incision follows, (k, 3); a closed one ends where it begins."""
    line = sample_curve(incision.points, incision.basis, incision.closed, 0.25)
    return np.vstack([line, line[:1]]) if incision.closed else line


def _tangents(line: NDArray[np.float64], shares: NDArray[np.float64]) -> NDArray[np.float64]:
    steps = np.diff(line, axis=0)
    sizes = np.linalg.norm(steps, axis=1)
    ends = np.cumsum(sizes)
    segment = np.minimum(np.searchsorted(ends, shares * ends[-1], side="left"), len(steps) - 1)
    return np.asarray(steps[segment] / sizes[segment, None], np.float64)
