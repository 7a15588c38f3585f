"""Flap and excision designs as points on the skin: the Z-plasty and the fusiform excision."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.closest_point import ClosestPoint
from lappet.procedure import Point
from lappet.refused import RefusedError

Place = Callable[[NDArray[np.float64]], NDArray[np.float64]]


@dataclass(frozen=True)
class ZPlasty:
    """A Z-plasty on the skin; points in mm.

    curve: the four corners of the Z in drawing order (a limb's base, the central limb's two ends, the other limb's
    base). tips: the tips of the two flaps, each at an end of the central limb. bases: for each flap the end of its
    outer limb, where the other flap's tip goes. After the transposition `tips[i]` lies on `bases[1 - i]`.
    """

    curve: tuple[Point, ...]
    tips: tuple[Point, Point]
    bases: tuple[Point, Point]


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


def z_plasty(
    center: ArrayLike,
    direction: ArrayLike,
    limb: float,
    angle: float = 60.0,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> ZPlasty:
    """A Z-plasty with limbs of `limb` mm at `angle` degrees to the central limb.

    center: the middle of the central limb, mm. direction: along the central limb (the scar). normal: outwards from the
    skin there. mirrored: the other of the two Z. project: places points (k, 3) on a curved skin, see `onto`. The long
    diagonal grows from `limb` to limb sqrt(5 - 4 cos angle). Raises RefusedError for a limb that is not positive and an
    angle outside 10° to 120°.
    """
    if not (np.isfinite(limb) and limb > 0.0):
        raise RefusedError(f"z_plasty: the limb is {limb:g} mm; give a length above 0")
    if not 10.0 <= angle <= 120.0:
        raise RefusedError(f"z_plasty: the angle is {angle:g}°; give one from 10° to 120°")
    along, across = skin_frame(direction, normal, "z_plasty")
    if mirrored:
        across = -across
    middle = np.asarray(center, np.float64)
    turn = np.radians(angle)
    first, second = middle + 0.5 * limb * along, middle - 0.5 * limb * along
    side = limb * (np.cos(turn) * along - np.sin(turn) * across)
    corners = np.stack([first - side, first, second, second + side])
    a, b, c, d = placed_on(corners, project)
    return ZPlasty(curve=(a, b, c, d), tips=(b, c), bases=(a, d))


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


def onto(points: ArrayLike, triangles: ArrayLike) -> Place:
    """A `project` for the designs above: to the closest point of a surface, points (n, 3) and triangles (m, 3)."""
    surface = ClosestPoint(points, triangles)
    return lambda drawn: surface.query(drawn)[1]


def skin_frame(direction: ArrayLike, normal: ArrayLike, what: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Unit vectors along the direction (made square to the normal) and across it, to its left."""
    up = np.asarray(normal, np.float64)
    along = np.asarray(direction, np.float64)
    up = up / max(float(np.linalg.norm(up)), 1e-300)
    flat = along - np.dot(along, up) * up
    size = float(np.linalg.norm(flat))
    if not size > 1e-9 * float(np.linalg.norm(along)) or not np.isfinite(flat).all():
        raise RefusedError(f"{what}: the direction {tuple(along.tolist())} does not lie along the skin; turn it")
    flat = flat / size
    return flat, np.cross(up, flat)


def placed_on(points: NDArray[np.float64], project: Place | None) -> tuple[Point, ...]:
    """The points (k, 3) of a design where `project` puts them on the skin."""
    placed = points if project is None else project(points)
    return tuple((float(x), float(y), float(z)) for x, y, z in placed)
