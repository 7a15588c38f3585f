"""The four-flap Z-plasty: the two broad flaps of a Z are halved, and the four change places.

In the design's plane c and b are the left and right end of the scar, L long. Limbs, all of that length, leave b
upwards: bf halves the angle between bc and ba; and c downwards: ce halves that between cb and cd. So the flaps are,
from right to left, A = (tip b, base fa), B = (tip b, base cf), C = (tip c, base be) and D = (tip c, base ed).
Afterwards they lie as C, A, D, B: B's tip comes to d and D's to f, C's to a and A's to e.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import Carry, Corner, FlapDesign, Seam
from lappet.designs.flat_curves import polyline, segment
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.tissue.placement import Place

HEIGHTS = {"a": 0.75, "b": 1.0, "c": 0.5, "d": 0.3}  # of the flaps' ways: they pass over each other


def four_flap_z_plasty(
    center: ArrayLike,
    direction: ArrayLike,
    limb: float,
    angle: float = 90.0,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design a four-flap Z-plasty.

    Parameters
    ----------
    center
        Middle of the scar in mm, shape (3,).
    direction
        Direction of the scar, shape (3,).
    limb
        Length of the scar and of each limb in mm.
    angle
        Angle of the outer limbs to the scar in degrees, which the inner ones halve, 80 to 120.
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
        If the limb is not positive or the angle is out of range.
    """
    require_lengths("four_flap_z_plasty", limb=limb)
    if not 80.0 <= angle <= 120.0:
        raise refused(ProblemCode.DESIGN_ANGLE, "four_flap_z_plasty", f"{angle:g}", least=80, most=120)
    plane = DesignPlane.at(center, skin_axes(direction, normal, "four_flap_z_plasty"), mirrored, project)
    b = np.array([0.5 * limb, 0.0])
    a, f = (b + limb * np.array([-np.cos(t), np.sin(t)]) for t in np.radians([angle, 0.5 * angle]))
    c, d, e = -b, -a, -f
    middle = {"a": (a + b + f) / 3.0, "b": (b + c + f) / 3.0, "c": (b + c + e) / 3.0, "d": (c + d + e) / 3.0}
    return FlapDesign(
        excised=(),
        incisions=(
            plane.points(polyline(a, b, c, d)),
            plane.points(segment(b, f)),
            plane.points(segment(c, e)),
        ),
        seams=_seams(plane, middle, a, b, f),
        corners=(
            Corner("b", plane.spot(b, middle["b"]), plane.spot(d, 2.0 * d - c)),
            Corner("c", plane.spot(c, middle["c"]), plane.spot(a, 2.0 * a - b)),
            Corner("d", plane.spot(c, middle["d"]), plane.spot(f, 2.0 * f - b)),
            Corner("a", plane.spot(b, middle["a"]), plane.spot(e, 2.0 * e - c)),
        ),
        carries=(
            Carry("b", plane.spot(b, middle["b"]), plane.point(c), plane.spot(d, middle["b"]), HEIGHTS["b"]),
            Carry("c", plane.spot(c, middle["c"]), plane.point(b), plane.spot(a, middle["c"]), HEIGHTS["c"]),
            Carry("d", plane.spot(c, middle["d"]), None, plane.spot(f, middle["d"]), HEIGHTS["d"]),
            Carry("a", plane.spot(b, middle["a"]), None, plane.spot(e, middle["a"]), HEIGHTS["a"]),
        ),
        flaps=tuple(plane.point(each) for each in middle.values()),
    )


def _seams(
    plane: DesignPlane,
    middle: dict[str, NDArray[np.float64]],
    a: NDArray[np.float64],
    b: NDArray[np.float64],
    f: NDArray[np.float64],
) -> tuple[Seam, ...]:
    """The two outer lips, each with a flap, and the three seams between the four flaps, from right to left."""
    c, d, e = -b, -a, -f

    def seam(
        name: str,
        one: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]],
        other: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]],
    ) -> Seam:
        first, second = (plane.edge_beside(segment(start, end), tissue) for start, end, tissue in (one, other))
        return Seam(name, (first, second))

    return (
        seam("right", (b, c, middle["c"]), (b, a, a + b - middle["a"])),
        seam("left", (c, b, middle["b"]), (c, d, c + d - middle["d"])),
        seam("c_a", (c, e, middle["c"]), (a, b, middle["a"])),
        seam("b_d", (b, f, middle["b"]), (d, c, middle["d"])),
        seam("a_d", (b, f, middle["a"]), (e, c, middle["d"])),
    )


_LIMBERG = (
    "A. A. Limberg, The planning of local plastic operations on the body surface (1963), on four flaps (not read)"
)
_HALVED = "120° into 60° and 90° into 45° are in use; in flat skin 120° leaves cones of 9 mm at its pivots"
FOUR_FLAP_Z_PLASTY = LibraryDesign(
    "four-flap-z-plasty",
    "Four-flap Z-plasty",
    "A tight web, as of the thumb or the armpit: a broad flap at either end is halved, and all four change places.",
    (
        Parameter("limb", "length of the scar and of each limb", "mm", 20.0, 5.0, 50.0, _LIMBERG),
        Parameter("angle", "angle of the outer limbs, halved by the inner ones", "°", 90.0, 80.0, 120.0, _HALVED),
    ),
    four_flap_z_plasty,
    "the middle of the scar",
    "the scar",
    "",
    _LIMBERG + "; S. H. Woolf and T. R. Broadbent, The four-flap Z-plasty, Plast. Reconstr. Surg. 49 (1972) 48 "
    "(not read).",
)
