"""The Z-plasty as points on the skin."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from lappet.core.problem import RefusedError
from lappet.designs.design_frame import placed_on, skin_frame
from lappet.procedure import Point
from lappet.tissue.placement import Place


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
