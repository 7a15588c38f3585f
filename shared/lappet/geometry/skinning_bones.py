"""Rigid motions of bones that take weighted vertices nearest to where they are, frame by frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def rigid_fit(
    points: NDArray[np.float64], weights: NDArray[np.float64], targets: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Find in each frame the rotation R and the translation t with the least sum of squares of w (R p + t) - q.

    Le & Deng, Smooth Skinning Decomposition with Rigid Bones, 2012, section 4.3; Kabsch 1976 for the rotation.

    Parameters
    ----------
    points
        Points p in the bind pose, shape (n, 3).
    weights
        Their weights w, more than 0, shape (n,).
    targets
        Where each, times its weight, should be: q, shape (f, n, 3).

    Returns
    -------
    tuple[NDArray[np.float64], NDArray[np.float64]]
        Rotations, shape (f, 3, 3), and translations, shape (f, 3).
    """
    total = float((weights**2).sum())
    center = (weights**2) @ points / total
    goal = np.einsum("n,fnk->fk", weights, targets) / total
    arms = weights[:, None] * (points - center)
    product = np.einsum("ni,fnj->fij", arms, targets - weights[:, None] * goal[:, None])
    # A little of no rotation at all, where points in a line or at one place say nothing of it.
    product += 1e-6 * (1.0 + float((arms**2).sum())) * np.eye(3)
    left, _, right = np.linalg.svd(product)
    turned = right.transpose(0, 2, 1) @ left.transpose(0, 2, 1)
    right[:, 2] *= np.where(np.linalg.det(turned) < 0.0, -1.0, 1.0)[:, None]
    rotation = right.transpose(0, 2, 1) @ left.transpose(0, 2, 1)
    return rotation, goal - rotation @ center


def moved(
    points: NDArray[np.float64], rotation: NDArray[np.float64], shift: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Move points rigidly in each frame.

    Parameters
    ----------
    points
        The points, shape (n, 3).
    rotation
        Rotations, shape (f, 3, 3).
    shift
        Translations, shape (f, 3).

    Returns
    -------
    NDArray[np.float64]
        Where they go, shape (f, n, 3).
    """
    return points @ rotation.transpose(0, 2, 1) + shift[:, None]
