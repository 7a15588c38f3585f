"""The Z-plasty as points on the skin."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.design_axes import placed_on, skin_axes
from lappet.procedure import Point
from lappet.tissue.placement import Place


@dataclass(frozen=True)
class ZPlasty:
    """A Z-plasty on the skin.

    After the transposition `tips[i]` lies on `bases[1 - i]`.

    Parameters
    ----------
    curve
        The four corners of the Z in mm in drawing order: a limb's base, the central limb's two ends, the other limb's
        base.
    tips
        Tips of the two flaps in mm, each at an end of the central limb.
    bases
        For each flap the end of its outer limb in mm, where the other flap's tip goes.
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
    """Design a Z-plasty.

    The long diagonal grows from `limb` to limb sqrt(5 - 4 cos angle).

    Parameters
    ----------
    center
        Middle of the central limb in mm, shape (3,).
    direction
        Direction of the central limb (the scar), shape (3,).
    limb
        Length of each limb in mm.
    angle
        Angle of the outer limbs to the central one in degrees, 10 to 120.
    normal
        Outwards from the skin at the middle, shape (3,).
    mirrored
        Whether it is the other of the two Z.
    project
        Maps points (k, 3) onto a curved skin, as `draped_on` gives, or None.

    Returns
    -------
    ZPlasty
        The design.

    Raises
    ------
    RefusedError
        If the limb is not positive or the angle is out of range.

    Examples
    --------
    >>> from lappet.designs import z_plasty
    >>> design = z_plasty(center=(0, 0, 4), direction=(1, 0, 0), limb=20.0, angle=60.0)
    >>> design.tips
    ((10.0, 0.0, 4.0), (-10.0, 0.0, 4.0))
    """
    if not (np.isfinite(limb) and limb > 0.0):
        raise refused(ProblemCode.LENGTH_NOT_POSITIVE, "z_plasty", f"{limb:g}", name="limb")
    if not 10.0 <= angle <= 120.0:
        raise refused(ProblemCode.DESIGN_ANGLE, "z_plasty", f"{angle:g}", least=10, most=120)
    along, across = skin_axes(direction, normal, "z_plasty")
    if mirrored:
        across = -across
    middle = np.asarray(center, np.float64)
    turn = np.radians(angle)
    first, second = middle + 0.5 * limb * along, middle - 0.5 * limb * along
    side = limb * (np.cos(turn) * along - np.sin(turn) * across)
    corners = np.stack([first - side, first, second, second + side])
    a, b, c, d = placed_on(corners, project)
    return ZPlasty(curve=(a, b, c, d), tips=(b, c), bases=(a, d))
