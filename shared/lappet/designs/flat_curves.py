"""Curves in the plane of a design: polylines (k, 2), mm."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

STEP = 1.0  # mm between the points of a curve, so that it follows a curved skin
NICK = 0.3  # mm by which an incision begins inside what is excised
GOTHIC = 1.3  # exponent of a pointed bow: 1 is a triangle, 2 a parabola


def length(curve: NDArray[np.float64]) -> float:
    """Measure a polyline.

    Parameters
    ----------
    curve
        Its points in mm, shape (k, 2) or (k, 3).

    Returns
    -------
    float
        Its length in mm.
    """
    return float(np.linalg.norm(np.diff(curve, axis=0), axis=1).sum())


def at_shares(curve: NDArray[np.float64], shares: ArrayLike) -> NDArray[np.float64]:
    """Find the points at shares of a polyline's length.

    Parameters
    ----------
    curve
        Its points in mm, shape (k, 2).
    shares
        Shares, 0 to 1, shape (n,).

    Returns
    -------
    NDArray[np.float64]
        Points in mm, shape (n, 2).
    """
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))])
    there = np.asarray(shares, np.float64) * along[-1]
    return np.column_stack([np.interp(there, along, curve[:, k]) for k in range(2)])


def part(curve: NDArray[np.float64], start: float, end: float, step: float = STEP) -> NDArray[np.float64]:
    """Take a part of a polyline.

    Parameters
    ----------
    curve
        Its points in mm, shape (k, 2).
    start
        Where the part starts, mm along the curve.
    end
        Where it ends, mm along the curve.
    step
        Distance from point to point in mm, about.

    Returns
    -------
    NDArray[np.float64]
        Points in mm, at least 3, shape (n, 2).
    """
    whole = length(curve)
    return at_shares(curve, np.linspace(start, end, max(2, round((end - start) / step)) + 1) / whole)


def segment(start: ArrayLike, end: ArrayLike, step: float = STEP) -> NDArray[np.float64]:
    """Draw a straight line.

    Parameters
    ----------
    start
        First point in mm, shape (2,).
    end
        Last point in mm, shape (2,).
    step
        Distance from point to point in mm, about.

    Returns
    -------
    NDArray[np.float64]
        Points in mm, both ends included, shape (n, 2).
    """
    first, last = np.asarray(start, np.float64), np.asarray(end, np.float64)
    count = max(1, round(float(np.linalg.norm(last - first)) / step))
    return first + np.linspace(0.0, 1.0, count + 1)[:, None] * (last - first)


def polyline(*corners: ArrayLike, step: float = STEP) -> NDArray[np.float64]:
    """Draw straight lines from corner to corner.

    Parameters
    ----------
    *corners
        Corners in mm, each of shape (2,).
    step
        Distance from point to point in mm, about.

    Returns
    -------
    NDArray[np.float64]
        Points in mm, shape (n, 2).
    """
    sides = [segment(a, b, step)[:-1] for a, b in pairwise(corners)]
    return np.vstack([*sides, np.asarray(corners[-1], np.float64)[None]])


def arc(center: ArrayLike, radius: float, start: float, end: float, step: float = STEP) -> NDArray[np.float64]:
    """Draw an arc of a circle.

    Parameters
    ----------
    center
        Middle of the circle in mm, shape (2,).
    radius
        Its radius in mm.
    start
        Angle of the first point in degrees, counter-clockwise from x.
    end
        Angle of the last point in degrees; before `start` for an arc that runs clockwise.
    step
        Distance from point to point in mm, about.

    Returns
    -------
    NDArray[np.float64]
        Points in mm, shape (n, 2).
    """
    count = max(8, round(abs(np.radians(end - start)) * radius / step))
    turn = np.radians(np.linspace(start, end, count + 1))
    return np.asarray(center, np.float64) + radius * np.column_stack([np.cos(turn), np.sin(turn)])


def bow(
    start: ArrayLike, end: ArrayLike, height: float, pointed: bool = False, step: float = STEP
) -> NDArray[np.float64]:
    """Draw a bow over a chord: half an ellipse, or pointed like a Gothic arch.

    Parameters
    ----------
    start
        First point in mm, shape (2,).
    end
        Last point in mm, shape (2,).
    height
        Height over the middle of the chord in mm, to the left of the way from start to end; negative to the right.
    pointed
        Whether its height is 1 - abs(t)^1.3 (`GOTHIC`), t from -1 to 1 along the chord, and not sqrt(1 - t²).
    step
        Distance from point to point in mm, about.

    Returns
    -------
    NDArray[np.float64]
        Points in mm at equal distances, both ends included, shape (n, 2).
    """
    first, last = np.asarray(start, np.float64), np.asarray(end, np.float64)
    along = last - first
    left = np.array([-along[1], along[0]]) / max(float(np.linalg.norm(along)), 1e-300)
    t = -np.cos(np.linspace(0.0, np.pi, 801))  # dense where half an ellipse is steep
    over = 1.0 - np.abs(t) ** GOTHIC if pointed else np.sqrt(np.maximum(1.0 - t**2, 0.0))
    fine = 0.5 * (first + last) + 0.5 * t[:, None] * along + height * over[:, None] * left
    fine[0], fine[-1] = first, last
    return part(fine, 0.0, length(fine), step)


def bezier(*corners: ArrayLike) -> NDArray[np.float64]:
    """Draw a cubic Bézier curve.

    Parameters
    ----------
    *corners
        Its first point, two points that it is drawn to, and its last point in mm, each of shape (2,).

    Returns
    -------
    NDArray[np.float64]
        801 points in mm, shape (801, 2).
    """
    t = np.linspace(0.0, 1.0, 801)[:, None]
    a, b, c, d = (np.asarray(corner, np.float64) for corner in corners)
    return (1 - t) ** 3 * a + 3 * (1 - t) ** 2 * t * b + 3 * (1 - t) * t**2 * c + t**3 * d


def s_curve(whole: float, around: float, back: float, step: float = STEP) -> NDArray[np.float64]:
    """Draw an S from (0, 0) that leaves along x, turns right and then left again.

    Both arcs have the curvature that makes the length; curvature changes over evenly in the middle tenth.

    Parameters
    ----------
    whole
        Length in mm.
    around
        Angle in degrees by which it turns right.
    back
        Angle in degrees by which it turns left again; 0 for an arc.
    step
        Distance from point to point in mm, about.

    Returns
    -------
    NDArray[np.float64]
        Points in mm, shape (n, 2).
    """
    count = max(8, round(whole / step))
    fine = np.linspace(0.0, 1.0, 40 * count + 1)
    first = around / (around + back)
    over = 0.05 if back > 0.0 else 0.0
    curvature = np.where(fine > first, 1.0, -1.0)
    if over:
        curvature = np.interp(fine, [0.0, first - over, first + over, 1.0], [-1.0, -1.0, 1.0, 1.0])
    heading = np.cumsum(curvature) / len(fine) * np.radians(around + back)
    steps = whole / (40 * count) * np.column_stack([np.cos(heading), np.sin(heading)])
    return np.vstack([np.zeros((1, 2)), np.cumsum(steps, axis=0)[39::40]])
