"""Curves of events, sampled: linear, B-spline, Catmull-Rom and Bézier, open or closed.

The bases are those of `UsdGeomBasisCurves`: open curves are nonperiodic (an open B-spline or Catmull-Rom curve begins
near its second and ends near its last but one point), closed ones are periodic.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Basis

_SIXTH = 1.0 / 6.0
_MATRICES = {
    "bspline": _SIXTH * np.array([[-1.0, 3, -3, 1], [3, -6, 3, 0], [-3, 0, 3, 0], [1, 4, 1, 0]]),
    "catmullRom": 0.5 * np.array([[-1.0, 3, -3, 1], [2, -5, 4, -1], [-1, 0, 1, 0], [0, 2, 0, 0]]),
    "bezier": np.array([[-1.0, 3, -3, 1], [3, -6, 3, 0], [-3, 3, 0, 0], [1, 0, 0, 0]]),
}
_FINE = 64


def sample_curve(
    points: ArrayLike, basis: Basis = "linear", closed: bool = False, step: float = 1.0, prim: str = ""
) -> NDArray[np.float64]:
    """Sample a curve at points that are at most a step apart.

    A linear curve keeps its corners; a cubic one keeps the ends of its segments only where it is open. A closed curve
    does not repeat its first sample.

    Parameters
    ----------
    points
        Control points in mm, shape (n, 3).
    basis
        How the curve runs through or beside its points.
    closed
        Whether it returns to its first point.
    step
        Greatest distance of two samples in mm, above 0.
    prim
        Path of the prim, for the problem of an error.

    Returns
    -------
    NDArray[np.float64]
        Samples in mm, shape (k, 3).

    Raises
    ------
    RefusedError
        If there are fewer than two distinct points (three when closed), a point is not finite, the basis is unknown, an
        open B-spline or Catmull-Rom curve has fewer than four points, or a Bézier curve has not 3k + 1 points (3k when
        closed).
    """
    control = np.asarray(points, np.float64).reshape(-1, 3)
    if not np.isfinite(control).all():
        raise refused(ProblemCode.CURVE_NOT_FINITE, prim, int(np.argmin(np.isfinite(control).all(axis=1))))
    if closed and len(control) > 1 and np.array_equal(control[0], control[-1]):
        control = control[:-1]
    need = 3 if closed else 2
    distinct = len(np.unique(control, axis=0))
    if distinct < need:
        kind = "closed curve" if closed else "curve"
        raise refused(ProblemCode.CURVE_TOO_SHORT, prim, distinct, kind=kind, need=need)
    if basis == "linear":
        return _resample_linear(control, closed, step)
    if basis not in _MATRICES:
        raise refused(ProblemCode.CURVE_UNKNOWN_BASIS, prim, basis)
    return _resample_smooth(_fine_points(control, basis, closed, prim), closed, step)


def _segments(control: NDArray[np.float64], basis: str, closed: bool, prim: str) -> NDArray[np.float64]:
    """The four control points of each cubic segment, (s, 4, 3)."""
    n = len(control)
    if basis == "bezier":
        if (n % 3 != 0) if closed else (n < 4 or n % 3 != 1):
            form = "3k" if closed else "3k + 1"
            raise refused(ProblemCode.CURVE_BEZIER_POINTS, prim, n, form=form)
        first = np.arange(0, n - (0 if closed else 1), 3)
        return control[(first[:, None] + np.arange(4)) % n]
    if closed:
        return control[(np.arange(n)[:, None] + np.arange(-1, 3)) % n]
    if n < 4:
        raise refused(ProblemCode.CURVE_OPEN_POINTS, prim, n, basis=basis)
    return control[np.arange(n - 3)[:, None] + np.arange(4)]


def _fine_points(control: NDArray[np.float64], basis: str, closed: bool, prim: str) -> NDArray[np.float64]:
    t = np.arange(_FINE) / _FINE
    powers = np.stack([t**3, t**2, t, np.ones_like(t)], axis=1)
    segments = _segments(control, basis, closed, prim)
    fine = np.einsum("tp,pq,sqc->stc", powers, _MATRICES[basis], segments).reshape(-1, 3)
    if not closed:
        fine = np.vstack([fine, np.ones(4) @ _MATRICES[basis] @ segments[-1]])
    return fine


def _resample_linear(control: NDArray[np.float64], closed: bool, step: float) -> NDArray[np.float64]:
    path = np.vstack([control, control[:1]]) if closed else control
    pieces = []
    for a, b in pairwise(path):
        length = float(np.linalg.norm(b - a))
        if length == 0.0:
            continue
        count = max(1, int(np.ceil(length / step - 1e-9)))
        pieces.append(a + (b - a) * (np.arange(count) / count)[:, None])
    samples = np.vstack(pieces)
    return samples if closed else np.vstack([samples, path[-1:]])


def _resample_smooth(fine: NDArray[np.float64], closed: bool, step: float) -> NDArray[np.float64]:
    path = np.vstack([fine, fine[:1]]) if closed else fine
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    count = max(8, int(np.ceil(along[-1] / step - 1e-9)))
    at = np.linspace(0.0, along[-1], count + 1)
    samples = np.stack([np.interp(at, along, path[:, axis]) for axis in range(3)], axis=1)
    return samples[:-1] if closed else samples
