"""The Z-plasty as a flap design: two triangular flaps change places, and the scar turns and grows longer.

With the corners of `lappet.designs.z_plasty_design`, b and c the ends of the central limb, a and d those of the outer
limbs at b and at c: the flap with the tip b turns about c until b lies at d, that with the tip c about b until c lies
at a. Its edge cb then meets the outer lip of cd, the other's edge bc the outer lip of ba, and the two outer edges ab
and cd meet in the new central limb.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import Carry, Corner, FlapDesign, Seam, Spot
from lappet.designs.flat_curves import polyline, segment
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.tissue.placement import Place

LOW = 0.5  # height of the second flap's way: it passes below the first


def z_plasty_flaps(
    center: ArrayLike,
    direction: ArrayLike,
    limb: float,
    angle: float = 60.0,
    other: float | None = None,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design a Z-plasty with its two flaps.

    Parameters
    ----------
    center
        Middle of the central limb in mm, shape (3,).
    direction
        Direction of the central limb (the scar), shape (3,).
    limb
        Length of each limb in mm.
    angle
        Angle of the first flap in degrees, 10 to 120.
    other
        Angle of the second flap in degrees; None for that of the first.
    normal
        Outwards from the skin at the middle, shape (3,).
    mirrored
        Whether it is the other of the two Z.
    project
        Maps points (k, 3) onto a curved skin, as `draped_on` gives, or None.

    Returns
    -------
    FlapDesign
        The design.

    Raises
    ------
    RefusedError
        If the limb is not positive or an angle is out of range.
    """
    require_lengths("z_plasty", limb=limb)
    angles = (angle, angle if other is None else other)
    for value in angles:
        if not 10.0 <= value <= 120.0:
            raise refused(ProblemCode.DESIGN_ANGLE, "z_plasty", f"{value:g}", least=10, most=120)
    plane = DesignPlane.at(center, skin_axes(direction, normal, "z_plasty"), mirrored, project)
    b, c = np.array([0.5 * limb, 0.0]), np.array([-0.5 * limb, 0.0])
    first, second = (np.radians(value) for value in angles)
    a = b - limb * np.array([np.cos(first), -np.sin(first)])
    d = c + limb * np.array([np.cos(second), -np.sin(second)])
    return exchanged(plane, a, b, c, d)


def exchanged(
    plane: DesignPlane,
    a: NDArray[np.float64],
    b: NDArray[np.float64],
    c: NDArray[np.float64],
    d: NDArray[np.float64],
    number: str = "",
) -> FlapDesign:
    """Let the two flaps of a Z change places.

    Parameters
    ----------
    plane
        The plane of the design.
    a
        End of the outer limb at b in the plane in mm, shape (2,).
    b
        End of the central limb, the first flap's tip, shape (2,).
    c
        The central limb's other end, the second flap's tip, shape (2,).
    d
        End of the outer limb at c, shape (2,).
    number
        What tells this Z from others of one design, for the names of its seams.

    Returns
    -------
    FlapDesign
        The Z.
    """
    one, two = (a + b + c) / 3.0, (b + c + d) / 3.0  # the flap at b lies on the side of a, that at c on the side of d
    first, second, central = (f"{name}_{number}" if number else name for name in ("first", "second", "central"))
    beyond_d, beyond_a = 2.0 * (0.5 * (c + d)) - two, 2.0 * (0.5 * (a + b)) - one
    return FlapDesign(
        excised=(),
        incisions=(plane.points(polyline(a, b, c, d)),),
        seams=(
            Seam(first, (plane.edge_beside(segment(c, b), one), plane.edge_beside(segment(c, d), beyond_d))),
            Seam(second, (plane.edge_beside(segment(b, c), two), plane.edge_beside(segment(b, a), beyond_a))),
            Seam(central, (plane.edge_beside(segment(a, b), one), plane.edge_beside(segment(c, d), two))),
        ),
        corners=(
            Corner(first, plane.spot(b, one), plane.spot(d, 2.0 * d - c)),
            Corner(second, plane.spot(c, two), plane.spot(a, 2.0 * a - b)),
        ),
        carries=(
            Carry(first, plane.spot(b, one), plane.point(c), Spot(plane.point(d), plane.point((a + c + d) / 3.0))),
            Carry(
                second, plane.spot(c, two), plane.point(b), Spot(plane.point(a), plane.point((a + b + d) / 3.0)), LOW
            ),
        ),
        flaps=(plane.point(one), plane.point(two)),
    )


_LIMBERG = "A. A. Limberg 1963; D. W. Furnas and G. W. Fischer 1971: 60° gains 73 % in length on paper"
Z_PLASTY = LibraryDesign(
    "z-plasty",
    "Z-plasty",
    "A contracted straight scar, lengthened and turned; equal or unequal angles.",
    (
        Parameter("limb", "length of each limb", "mm", 20.0, 4.0, 60.0, _LIMBERG),
        Parameter("angle", "angle of the first flap", "°", 60.0, 30.0, 90.0, _LIMBERG),
        Parameter("other", "angle of the second flap", "°", 60.0, 30.0, 90.0, _LIMBERG),
    ),
    z_plasty_flaps,
    "the middle of the scar",
    "the scar",
    "across",
    "A. A. Limberg, The planning of local plastic operations on the body surface (1963); D. W. Furnas and G. W. "
    "Fischer, The Z-plasty: biomechanics and mathematics, Br. J. Plast. Surg. 24 (1971) 144.",
)
