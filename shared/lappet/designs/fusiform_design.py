"""The fusiform excision of two circular arcs as points on the skin."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.core.problem import RefusedError
from lappet.designs.design_frame import placed_on, skin_frame
from lappet.procedure import Point
from lappet.tissue.placement import Place


@dataclass(frozen=True)
class Fusiform:
    """A fusiform excision of two circular arcs; points in mm.

    curve: around the whole, closed, counter-clockwise about the normal. tips: the two ends of the long axis. pairs:
    points of the two arcs that face each other, evenly along the axis, to suture. seed: the middle, to excise.
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
    """A fusiform of two circular arcs, `length` by `width` mm, its long axis along `direction`.

    Each arc has the radius (length² + width²) / (4 width) and ends at the tips at half the angle 4 atan(width /
    length). samples: points of each arc. sutures: pairs of facing points. Other arguments as in `z_plasty`. Raises
    RefusedError for a length or width that is not positive and a width above the length.
    """
    if not (np.isfinite(length) and np.isfinite(width) and 0.0 < width <= length):
        raise RefusedError(
            f"fusiform: the length is {length:g} mm and the width {width:g} mm; "
            "give 0 < width <= length, for instance 3 : 1"
        )
    if samples < 2:
        raise RefusedError(f"fusiform: {samples} samples cannot follow an arc; give at least 2")
    along, across = skin_frame(direction, normal, "fusiform")
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
