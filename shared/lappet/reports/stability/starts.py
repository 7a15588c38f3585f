"""Where the stability cases start from, and the check that the start does not show in the end."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.reports.stability.case import Solved, Start


def at_rest(rest: NDArray[np.float64]) -> NDArray[np.float64]:
    """Start at rest.

    Parameters
    ----------
    rest
        Nodes at rest in mm, shape (N, 3).

    Returns
    -------
    NDArray[np.float64]
        The same positions.
    """
    return rest


def collapsed(rest: NDArray[np.float64]) -> NDArray[np.float64]:
    """Start with everything in one point.

    Parameters
    ----------
    rest
        Nodes at rest in mm, shape (N, 3).

    Returns
    -------
    NDArray[np.float64]
        Positions in mm, shape (N, 3).
    """
    return np.broadcast_to(rest.mean(axis=0), rest.shape)


def flattened(rest: NDArray[np.float64]) -> NDArray[np.float64]:
    """Start pressed into the plane half way up.

    Parameters
    ----------
    rest
        Nodes at rest in mm, shape (N, 3).

    Returns
    -------
    NDArray[np.float64]
        Positions in mm, shape (N, 3).
    """
    return np.column_stack([rest[:, :2], np.full(len(rest), rest[:, 2].mean())])


def inverted(rest: NDArray[np.float64]) -> NDArray[np.float64]:
    """Start turned inside out through the middle.

    Parameters
    ----------
    rest
        Nodes at rest in mm, shape (N, 3).

    Returns
    -------
    NDArray[np.float64]
        Positions in mm, shape (N, 3).
    """
    return 2.0 * rest.mean(axis=0) - rest


def mirrored(rest: NDArray[np.float64]) -> NDArray[np.float64]:
    """Start upside down without having been turned.

    Parameters
    ----------
    rest
        Nodes at rest in mm, shape (N, 3).

    Returns
    -------
    NDArray[np.float64]
        Positions in mm, shape (N, 3).
    """
    return np.column_stack([rest[:, :2], rest[:, 2].max() + rest[:, 2].min() - rest[:, 2]])


def scattered(rest: NDArray[np.float64]) -> NDArray[np.float64]:
    """Start with every node anywhere in the box of the tissue.

    Parameters
    ----------
    rest
        Nodes at rest in mm, shape (N, 3).

    Returns
    -------
    NDArray[np.float64]
        Positions in mm, shape (N, 3).
    """
    low, high = rest.min(axis=0), rest.max(axis=0)
    return low + (high - low) * np.random.default_rng(5).random(rest.shape)


STARTS: dict[str, Start] = {
    "rest": at_rest,
    "collapsed": collapsed,
    "flattened": flattened,
    "inverted": inverted,
    "mirrored": mirrored,
    "random": scattered,
}


def as_from_rest(share: float) -> Any:
    """Make the check that the last frame is the one from rest.

    Parameters
    ----------
    share
        How far it may differ, as a share of the spacing.

    Returns
    -------
    Any
        The check.
    """

    def check(solved: Solved) -> str:
        assert solved.twin is not None
        off = float(np.abs(solved.frames[-1].points - solved.twin.points).max())
        if off <= share * solved.program.settings.spacing:
            return ""
        return f"It is another equilibrium than that from rest: {off:.3g} mm away."

    return check
