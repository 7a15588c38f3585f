"""Where something that pulls is, and how it is turned: the matrix of a prim, as `Retractor.motion` samples it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.procedure.exact_values import Point

Pose = tuple[float, ...]  # 4 x 4, row-major, in USD's row-vector convention, mm


def pose_at(place: Point) -> Pose:
    """Make the pose of something that is not turned.

    Parameters
    ----------
    place
        Where it is, mm.

    Returns
    -------
    Pose
        Its pose.
    """
    x, y, z = (float(value) for value in place)
    return (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, x, y, z, 1.0)


def place_of(pose: Pose) -> Point:
    """Return the place of a pose.

    Parameters
    ----------
    pose
        The pose.

    Returns
    -------
    Point
        Where it is, mm.
    """
    return (pose[12], pose[13], pose[14])


def pose_matrix(pose: Pose) -> NDArray[np.float64]:
    """Make the matrix of a pose that is applied to columns.

    Parameters
    ----------
    pose
        The pose.

    Returns
    -------
    NDArray[np.float64]
        Shape (4, 4); the translation is its last column.
    """
    return np.array(pose, np.float64).reshape(4, 4).T


def matrix_pose(matrix: NDArray[np.float64]) -> Pose:
    """Make a pose of a matrix that is applied to columns.

    Parameters
    ----------
    matrix
        Shape (4, 4); the translation is its last column.

    Returns
    -------
    Pose
        The pose.
    """
    return tuple(float(value) for value in np.asarray(matrix, np.float64).T.ravel())
