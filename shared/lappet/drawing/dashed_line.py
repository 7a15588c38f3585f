"""A line cut into dashes, as a pen draws a border that is not to be cut."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

DASH, GAP = 1.6, 1.1


def dashes(line: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Cut a line into dashes of `DASH` mm with gaps of `GAP` mm, stretched to fit the whole length.

    Parameters
    ----------
    line
        The line in mm, shape (k, 3).

    Returns
    -------
    list[NDArray[np.float64]]
        The dashes in mm, each of shape (4, 3).
    """
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    place = np.concatenate([[0.0], np.cumsum(steps)])
    count = max(1, round(float(place[-1]) / (DASH + GAP)))
    period = place[-1] / count
    share = DASH / (DASH + GAP)
    parts = []
    for k in range(count):
        s = np.linspace(k * period, (k + share) * period, 4)
        parts.append(np.stack([np.interp(s, place, line[:, axis]) for axis in range(3)], axis=-1))
    return parts
