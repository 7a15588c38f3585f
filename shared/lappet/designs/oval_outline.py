"""An oval around a design, as the outline of what is undermined."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.design_axes import placed_on, skin_axes
from lappet.procedure import Point
from lappet.tissue.placement import Place

_POINTS = 48


def oval(
    center: ArrayLike,
    length: float,
    width: float,
    direction: ArrayLike,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    project: Place | None = None,
) -> tuple[Point, ...]:
    """Draw an ellipse on skin.

    Parameters
    ----------
    center
        Middle of the ellipse in mm, shape (3,).
    length
        Length of its axis along the direction in mm.
    width
        Length of its other axis in mm.
    direction
        Direction of the first axis, shape (3,).
    normal
        Outwards from the skin at the middle, shape (3,).
    project
        Maps points (k, 3) onto a curved skin, as `draped_on` gives, or None.

    Returns
    -------
    tuple[Point, ...]
        48 points of the closed line in mm, counter-clockwise about the normal.

    Raises
    ------
    RefusedError
        If the length or width is not positive, or the direction stands upright on the skin.

    Examples
    --------
    >>> from lappet.designs import oval
    >>> around = oval(center=(0, 0, 4), length=72.0, width=48.0, direction=(1, 0, 0))
    >>> len(around), around[0]
    (48, (36.0, 0.0, 4.0))
    """
    for name, value in (("length", length), ("width", width)):
        if not (np.isfinite(value) and value > 0.0):
            raise refused(ProblemCode.LENGTH_NOT_POSITIVE, "oval", f"{value:g}", name=name)
    along, across = skin_axes(direction, normal, "oval")
    turn = np.linspace(0.0, 2.0 * np.pi, _POINTS, endpoint=False)[:, None]
    around = np.asarray(center, np.float64) + 0.5 * length * np.cos(turn) * along + 0.5 * width * np.sin(turn) * across
    return placed_on(around, project)
