"""Rigid motions between samples: the translation linear, the rotation along the shortest turn."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode

RIGID_TOLERANCE = 1e-4


class RigidMotion:
    """The motion of a prim relative to its first sample.

    Parameters
    ----------
    samples
        Samples (time code, row-major 4 × 4 matrix in USD's row-vector convention, mm), at least one, in any order.
    prim
        Path of the prim, for the problem of an error.

    Raises
    ------
    RefusedError
        If there is no sample, a number is not finite, the first matrix cannot be inverted, or the motion between two
        samples is not rigid (it scales, shears or mirrors by more than 1e-4).
    """

    def __init__(self, samples: Sequence[tuple[float, Sequence[float]]], prim: str = "") -> None:
        if not samples:
            raise refused(ProblemCode.MOTION_NO_SAMPLES, prim)
        ordered = sorted(samples, key=lambda sample: sample[0])
        # Column-vector convention from here on: p' = M p.
        matrices = np.array([np.asarray(matrix, np.float64).reshape(4, 4).T for _, matrix in ordered])
        self._times = np.array([time for time, _ in ordered], np.float64)
        if not (np.isfinite(matrices).all() and np.isfinite(self._times).all()):
            raise refused(ProblemCode.MOTION_NOT_FINITE, prim)
        if abs(np.linalg.det(matrices[0, :3, :3])) < 1e-12:
            raise refused(ProblemCode.MOTION_NOT_INVERTIBLE, prim, f"{self._times[0]:g}")
        self._first = matrices[0]
        motions = matrices @ np.linalg.inv(matrices[0])
        self._rotations = motions[:, :3, :3]
        # Interpolated about the prim's own origin, which so moves along a straight line.
        self._pivot = matrices[0, :3, 3]
        self._offsets = motions[:, :3, 3] + self._rotations @ self._pivot - self._pivot
        for time, rotation in zip(self._times, self._rotations, strict=True):
            strain = np.abs(rotation.T @ rotation - np.eye(3)).max()
            if strain > RIGID_TOLERANCE or np.linalg.det(rotation) < 0.0:
                raise refused(ProblemCode.MOTION_NOT_RIGID, prim, f"{time:g}", strain=strain)

    def at(self, time: float) -> NDArray[np.float64]:
        """Compute the motion from the first sample to a time.

        Parameters
        ----------
        time
            Time code; beyond the ends the motion is held.

        Returns
        -------
        NDArray[np.float64]
            Matrix of shape (4, 4), column-vector convention, mm.
        """
        times = self._times
        after = int(np.searchsorted(times, time, side="right"))
        low, high = max(after - 1, 0), min(after, len(times) - 1)
        span = times[high] - times[low]
        share = min(max((time - times[low]) / span, 0.0), 1.0) if span > 0.0 else 0.0
        turn = _rotation(share * _rotation_vector(self._rotations[low].T @ self._rotations[high]))
        rotation = self._rotations[low] @ turn
        offset = (1.0 - share) * self._offsets[low] + share * self._offsets[high]
        motion = np.eye(4)
        motion[:3, :3] = rotation
        motion[:3, 3] = offset + self._pivot - rotation @ self._pivot
        return motion

    def pose(self, time: float) -> NDArray[np.float64]:
        """Compute where the prim is, and how it is turned.

        Parameters
        ----------
        time
            Time code.

        Returns
        -------
        NDArray[np.float64]
            Its transform, shape (4, 4), column-vector convention, mm.
        """
        pose: NDArray[np.float64] = self.at(time) @ self._first
        return pose

    def between(self, start: float, time: float) -> NDArray[np.float64]:
        """Compute the motion from one time to another.

        Parameters
        ----------
        start
            Time code from which the motion is counted.
        time
            Time code.

        Returns
        -------
        NDArray[np.float64]
            Matrix of shape (4, 4), column-vector convention, mm.
        """
        return self.at(time) @ np.linalg.inv(self.at(start))


def _rotation(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rotation matrix of a rotation vector (axis times angle), by Rodrigues' formula."""
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    rotation: NDArray[np.float64] = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
    return rotation


def _rotation_vector(rotation: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rotation vector (angle at most pi) of a rotation matrix."""
    twist = rotation - rotation.T
    sine = 0.5 * np.array([twist[2, 1], twist[0, 2], twist[1, 0]], np.float64)
    cosine = 0.5 * (np.trace(rotation) - 1.0)
    length = float(np.linalg.norm(sine))
    angle = float(np.arctan2(length, cosine))
    if length > 1e-6 or angle < 1.0:
        return sine * (angle / length if length > 0.0 else 1.0)
    # A half turn: the axis is the column of R + I with the largest diagonal entry.
    symmetric = 0.5 * (rotation + np.eye(3))
    axis: NDArray[np.float64] = symmetric[:, int(np.argmax(np.diag(symmetric)))]
    return axis * (angle / float(np.linalg.norm(axis)))
