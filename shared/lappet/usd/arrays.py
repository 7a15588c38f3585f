"""Arrays of USD from arrays of numpy."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.usd.stage import pxr


def vectors(values: NDArray[Any]) -> Any:
    """Make an array of vectors in single precision.

    Parameters
    ----------
    values
        Vectors, shape (n, 3).

    Returns
    -------
    Vt.Vec3fArray
        The array.
    """
    return pxr().Vt.Vec3fArray.FromNumpy(np.require(values, np.float32, ["C", "A"]))
