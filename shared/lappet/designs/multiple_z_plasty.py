"""Several Z-plasties in series on one long scar: each lengthens its own part of it, and none needs long limbs.

The scar is the line of all central limbs, P0 to Pn. Limbs leave it upwards at P1 to Pn and downwards at P0 to Pn-1, all
parallel, so that those of two neighbors lie in one line. In each Z the flaps change places as in
`lappet.designs.z_plasty_flaps`; between two of them, at P1 to Pn-1, the corner of skin above on the one side meets the
corner below on the other.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import Corner, FlapDesign
from lappet.designs.flat_curves import polyline
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.designs.z_plasty_flaps import exchanged
from lappet.tissue.placement import Place


def multiple_z_plasty(
    center: ArrayLike,
    direction: ArrayLike,
    limb: float,
    angle: float = 45.0,
    count: float = 3.0,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design Z-plasties in series.

    Parameters
    ----------
    center
        Middle of the scar in mm, shape (3,).
    direction
        Direction of the scar, shape (3,).
    limb
        Length of each limb in mm.
    angle
        Angle of the flaps in degrees, 30 to 75.
    count
        How many Z there are, at least 2.
    normal
        Outwards from the skin at the middle, shape (3,).
    mirrored
        Whether they are the other of the two Z.
    project
        Maps points (k, 3) onto a curved skin, as `draped_on` gives, or None.

    Returns
    -------
    FlapDesign
        The design.

    Raises
    ------
    RefusedError
        If the limb is not positive or the angle is out of range.
    """
    require_lengths("multiple_z_plasty", limb=limb, count=count)
    if not 30.0 <= angle <= 75.0:
        raise refused(ProblemCode.DESIGN_ANGLE, "multiple_z_plasty", f"{angle:g}", least=30, most=75)
    plane = DesignPlane.at(center, skin_axes(direction, normal, "multiple_z_plasty"), mirrored, project)
    turn, number = np.radians(angle), round(count)
    up = limb * np.array([-np.cos(turn), np.sin(turn)])
    along = [np.array([(k - 0.5 * number) * limb, 0.0]) for k in range(number + 1)]
    zs = [exchanged(plane, b + up, b, c, c - up, f"{k + 1}") for k, (c, b) in enumerate(pairwise(along))]
    beside = np.array([np.cos(0.5 * (np.pi - turn)), np.sin(0.5 * (np.pi - turn))])  # halves the corner above
    joints = [
        Corner(f"joint_{k + 1}", plane.spot(at, at - beside), plane.spot(at, at + beside))
        for k, at in enumerate(along[1:-1])
    ]
    return FlapDesign(
        excised=(),
        incisions=(
            plane.points(polyline(along[0] - up, *along, along[-1] + up)),
            *(plane.points(polyline(at - up, at, at + up)) for at in along[1:-1]),
        ),
        seams=tuple(seam for z in zs for seam in z.seams),
        corners=(*(corner for z in zs for corner in z.corners), *joints),
        carries=tuple(carry for z in zs for carry in z.carries),
        flaps=tuple(flap for z in zs for flap in z.flaps),
    )


_MCGREGOR = "I. A. McGregor, Fundamental Techniques of Plastic Surgery, on the multiple Z-plasty (not read)"
MULTIPLE_Z_PLASTY = LibraryDesign(
    "multiple-z-plasty",
    "Multiple Z-plasty",
    "A long contracted scar with little slack skin beside it: several small Z in series instead of a large one.",
    (
        Parameter("limb", "length of each limb", "mm", 14.0, 4.0, 40.0, "chosen: a third of the scar"),
        Parameter("angle", "angle of the flaps", "°", 45.0, 30.0, 75.0, _MCGREGOR),
        Parameter("count", "number of Z", "", 3.0, 2.0, 6.0, _MCGREGOR, whole=True),
    ),
    multiple_z_plasty,
    "the middle of the scar",
    "the scar",
    "across",
    _MCGREGOR + "; each Z as in A. A. Limberg, The planning of local plastic operations on the body surface (1963).",
)
