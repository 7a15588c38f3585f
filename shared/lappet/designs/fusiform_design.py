"""The fusiform excision of two circular arcs as points on the skin."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.design_axes import placed_on, skin_axes
from lappet.procedure import Point
from lappet.tissue.placement import Place


@dataclass(frozen=True)
class Fusiform:
    """A fusiform excision of two circular arcs.

    Parameters
    ----------
    curve
        Points around the whole in mm, closed, counter-clockwise about the normal.
    tips
        The two ends of the long axis in mm.
    pairs
        Points of the two arcs that face each other in mm, evenly along the axis, to suture.
    seed
        The middle in mm, to excise.
    """

    curve: tuple[Point, ...]
    tips: tuple[Point, Point]
    pairs: tuple[tuple[Point, Point], ...]
    seed: Point


def fusiform(
    center: ArrayLike,
    length: float,
    width: float,
    direction: ArrayLike,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    samples: int = 32,
    sutures: int = 7,
    project: Place | None = None,
) -> Fusiform:
    """Design a fusiform of two circular arcs.

    Each arc has the radius (length² + width²) / (4 width) and ends at the tips at half the angle 4 atan(width /
    length).

    Parameters
    ----------
    center
        Middle of the fusiform in mm, shape (3,).
    length
        Length of the long axis in mm.
    width
        Width in mm, at most the length.
    direction
        Direction of the long axis, shape (3,).
    normal
        Outwards from the skin at the middle, shape (3,).
    samples
        Number of points of each arc, at least 2.
    sutures
        Number of pairs of facing points.
    project
        Maps points (k, 3) onto a curved skin, as `draped_on` gives, or None.

    Returns
    -------
    Fusiform
        The design.

    Raises
    ------
    RefusedError
        If the length or width is not positive, the width is above the length, or there are fewer than 2 samples.

    Examples
    --------
    >>> from lappet.designs import fusiform
    >>> ellipse = fusiform(center=(0, 0, 4), length=36.0, width=12.0, direction=(1, 0, 0), sutures=3)
    >>> ellipse.tips, len(ellipse.pairs)
    (((-18.0, 0.0, 4.0), (18.0, 0.0, 4.0)), 3)
    """
    if not (np.isfinite(length) and np.isfinite(width) and 0.0 < width <= length):
        raise refused(ProblemCode.DESIGN_OVAL, "fusiform", f"{width:g}", length=length)
    if samples < 2:
        raise refused(ProblemCode.DESIGN_SAMPLES, "fusiform", samples)
    along, across = skin_axes(direction, normal, "fusiform")
    middle = np.asarray(center, np.float64)
    radius = (length**2 + width**2) / (4.0 * width)
    half = 2.0 * np.arctan2(width, length)  # half the arc's opening angle

    def arc(turn: NDArray[np.float64], side: float) -> NDArray[np.float64]:
        """Points at the angles `turn` (-half to half) from the arc's middle."""
        x, y = radius * np.sin(turn), radius * np.cos(turn) - (radius - 0.5 * width)
        return middle + x[:, None] * along + side * y[:, None] * across

    turn = np.linspace(-half, half, samples + 1)
    around = np.vstack([arc(turn[:-1], -1.0), arc(-turn[:-1], 1.0)])
    stations = np.arange(1, sutures + 1) / (sutures + 1) * 2.0 - 1.0
    facing = np.arcsin(np.clip(stations * 0.5 * length / radius, -1.0, 1.0))
    left, right = placed_on(arc(facing, 1.0), project), placed_on(arc(facing, -1.0), project)
    tips = placed_on(np.stack([middle - 0.5 * length * along, middle + 0.5 * length * along]), project)
    return Fusiform(
        curve=placed_on(around, project),
        tips=(tips[0], tips[1]),
        pairs=tuple(zip(left, right, strict=True)),
        seed=placed_on(middle[None], project)[0],
    )
