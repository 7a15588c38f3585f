"""The distinct rows of an array: what `numpy.unique(axis=0)` finds, without comparing rows as bytes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def unique_rows(rows: NDArray[Any]) -> tuple[NDArray[Any], NDArray[np.int64]]:
    """Return the distinct rows in ascending order, (u, c), and which of them each row is, (k,).

    rows: (k, c), numbers; -0 and 0 are equal. Of equal rows the first one is returned.
    """
    order = np.lexsort(rows.T[::-1])
    ordered = rows[order]
    fresh = np.ones(len(rows), bool)
    fresh[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    inverse = np.empty(len(rows), np.int64)
    inverse[order] = np.cumsum(fresh) - 1
    return ordered[fresh], inverse
