"""The distinct rows of an array: what `numpy.unique(axis=0)` finds, without comparing rows as bytes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def unique_rows(rows: NDArray[Any]) -> tuple[NDArray[Any], NDArray[np.int64]]:
    """Find the distinct rows of an array; -0 and 0 are equal.

    Parameters
    ----------
    rows
        Numbers, shape (k, c).

    Returns
    -------
    tuple[NDArray[Any], NDArray[np.int64]]
        Distinct rows in ascending order, of equal rows the first one, shape (u, c); and which of them each row is,
        shape (k,).
    """
    order = np.lexsort(rows.T[::-1])
    ordered = rows[order]
    fresh = np.ones(len(rows), bool)
    fresh[1:] = np.logical_or.reduce([column[1:] != column[:-1] for column in ordered.T])
    inverse = np.empty(len(rows), np.int64)
    inverse[order] = np.cumsum(fresh) - 1
    return ordered[fresh], inverse
