"""Values as USD keeps them: rounded to single precision where the file holds that, read-only, exact to compare.

What USD holds in single precision (mesh points, texture coordinates, curves, seeds and landmarks) is rounded at once,
so that a procedure built by a script equals the one read back from its file. Arrays are copied and read-only.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

Point = tuple[float, float, float]


def frozen(values: ArrayLike, kind: DTypeLike, width: int = 0) -> NDArray[Any]:
    """Copy an array, read-only, with floating-point values rounded to single precision.

    Parameters
    ----------
    values
        Any array.
    kind
        Kind of the copy's numbers; float64 still holds what single precision can.
    width
        Number of columns: an empty array becomes one of shape (0, width). 0 leaves the shape as it is.

    Returns
    -------
    NDArray[Any]
        The read-only copy.
    """
    if np.dtype(kind) == np.float64:
        with np.errstate(over="ignore"):
            values = np.asarray(values, np.float32)
    array = np.array(values, kind)
    if width and array.size == 0:
        array = array.reshape(0, width)
    array.flags.writeable = False
    return array


def double_point(point: ArrayLike) -> Point:
    """Make a point of three floats in double precision, without negative zeros.

    Parameters
    ----------
    point
        Three coordinates, mm.

    Returns
    -------
    Point
        The point.
    """
    x, y, z = (float(v) + 0.0 for v in np.asarray(point, np.float64))  # + 0.0: there is no negative zero
    return (x, y, z)


def single_points(points: ArrayLike) -> tuple[Point, ...]:
    """Round points to single precision.

    Parameters
    ----------
    points
        Coordinates in mm, shape (n, 3) or flat.

    Returns
    -------
    tuple[Point, ...]
        N points, each exactly representable in single precision.
    """
    with np.errstate(over="ignore"):
        rounded = np.asarray(points, np.float32).reshape(-1, 3)
    return tuple(double_point(point) for point in rounded)


def set_fields(value: object, **fields: object) -> None:
    """Set fields of a frozen dataclass while it is being made.

    Parameters
    ----------
    value
        The dataclass.
    **fields
        New content by name of field.
    """
    for name, content in fields.items():
        object.__setattr__(value, name, content)


def same_array(a: NDArray[Any] | None, b: NDArray[Any] | None) -> bool:
    """Compare arrays by shape and every value; NaN equals NaN.

    Parameters
    ----------
    a
        An array or None.
    b
        An array or None.

    Returns
    -------
    bool
        Whether both are None or hold the same.
    """
    if a is None or b is None:
        return a is b
    return a.shape == b.shape and bool(np.array_equal(a, b, equal_nan=a.dtype.kind == "f"))
