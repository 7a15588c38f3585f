"""Which closed surfaces lie inside which others."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.axis_rays import AxisRays


def outermost_around(points: NDArray[np.float64], parts: Sequence[NDArray[np.int64]]) -> list[int | None]:
    """Find for each closed surface the outermost of those that it lies in.

    Parameters
    ----------
    points
        Vertices in any length unit, shape (n, 3).
    parts
        Vertex indices of the surfaces, each of shape (m, 3); no two cross each other.

    Returns
    -------
    list[int | None]
        The index of that surface for each; None where there is none.
    """
    low = np.array([points[part].min(axis=(0, 1)) for part in parts])
    high = np.array([points[part].max(axis=(0, 1)) for part in parts])
    inside = np.zeros((len(parts), len(parts)), bool)  # whether the first lies in the second
    for outer, part in enumerate(parts):
        asked = np.flatnonzero(((low > low[outer]) & (high < high[outer])).all(axis=1))
        if len(asked):
            starts = np.stack([points[parts[each][0]].mean(axis=0) for each in asked])
            found = AxisRays(points, part, 0).crossings(starts)
            inside[asked, outer] = np.bincount(found.line[found.along > 0.0], minlength=len(asked)) % 2 == 1
    outermost = ~inside.any(axis=1)
    return [int((row & outermost).argmax()) if row.any() else None for row in inside]
