r"""Webster's 30° flap: a narrower transposition flap than Limberg's, its base closed as a W.

In the design's plane, x from the defect to the flap, the defect is an equilateral triangle ABD of side a, its tip A up,
and below it a W: two triangles of 30°, B W' M and M W D, whose sides BW' and DW, a long, lean inwards by 10°. What lies
in the circle of a lesion is cut out with all of it::

            A
          /   \         E     The flap WDEF turns about W by the W's 30°: DE leaves D at 40° to BD, and EF, as long,
        B       D     /       comes back at 30° to DE. |DE| = |EF| = |DW| = a.
        |   M   |   F
         \ / \ /              The flap's corner D and the defect's corner B meet at M, its tip E comes to A. The flap is
          W'  W               narrower than the defect: the skin beside both shares the rest of the closure.

The donor site closes by drawing the corner that DE leaves outside of the flap to F.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import Carry, Corner, FlapDesign, Seam
from lappet.designs.flat_curves import NICK, polyline, segment
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.tissue.placement import Place

TIP = 30.0  # degrees: the flap's tip, and each half of the W
LEAN, FIRST = 10.0, 40.0  # degrees of the W's sides inwards, and of DE: they leave the flap a base of half its length


def webster_flap(
    center: ArrayLike,
    direction: ArrayLike,
    side: float,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design Webster's flap.

    Parameters
    ----------
    center
        Middle of the circle in the triangle, the lesion's, in mm, shape (3,).
    direction
        Direction from the defect to the flap, shape (3,).
    side
        Side of the triangle and of the flap in mm.
    normal
        Outwards from the skin at the middle, shape (3,).
    mirrored
        Whether the flap's tip is on the other side.
    project
        Maps points (k, 3) onto a curved skin, as `draped_on` gives, or None.

    Returns
    -------
    FlapDesign
        The design.

    Raises
    ------
    RefusedError
        If the side is not positive.
    """
    require_lengths("webster", side=side)
    middle = side * np.array([0.0, np.sqrt(3.0) / 6.0])
    plane = DesignPlane.at(center, skin_axes(direction, normal, "webster"), mirrored, project, middle)
    a, b, d = side * np.array([0.0, 0.5 * np.sqrt(3.0)]), side * np.array([-0.5, 0.0]), side * np.array([0.5, 0.0])
    down = side * _direction(270.0 - LEAN)
    near, far = d + down, b + down * np.array([-1.0, 1.0])  # W and W'
    m = near - near[0] / np.cos(np.radians(90.0 - LEAN + TIP)) * _direction(90.0 - LEAN + TIP)
    e = d + side * _direction(FIRST)
    f = e + side * _direction(FIRST + 180.0 + TIP)
    flap = (d + e + f + near) / 4.0
    away = 4.0 * side
    above, below = np.array([0.0, away]), np.array([0.0, -away])
    out = 0.5 * (e + f) + away * _direction(FIRST + TIP - 90.0)
    pairs = (
        ("donor", (e, d, above), (e, f, out)),
        ("base", (near, d, flap), (near, m, below)),
        ("spur", (far, m, below), (far, b, 0.5 * (far + b) + [-away, 0.0])),
        ("far", (d, e, flap), (b, a, above)),
        ("end", (e, f, flap), (a, d, above)),
    )
    outwards = _direction(0.5 * (120.0 + FIRST))  # halves the corner outside of the flap, between DA and DE
    flap_d, flap_e = plane.spot(d, flap), plane.spot(e, flap)
    return FlapDesign(
        excised=(plane.excised("defect", polyline(a, b, far, m, near, d, a)[:-1], middle),),
        incisions=(plane.points(np.vstack([(d - NICK * _direction(FIRST))[None], polyline(d, e, f)])),),
        seams=tuple(
            Seam(name, (plane.edge_beside(segment(*one[:2]), one[2]), plane.edge_beside(segment(*other[:2]), other[2])))
            for name, one, other in pairs
        ),
        corners=(
            Corner(
                "donor", plane.spot(d, d + side * outwards), plane.spot(f, f + side * _direction(180.0 + FIRST + TIP))
            ),
            Corner("shoulder", flap_d, plane.spot(m, 0.5 * (near + far))),
            Corner("edge", plane.spot(b, b + side * _direction(165.0)), plane.spot(m, 0.5 * (near + far))),
            Corner("tip", flap_e, plane.spot(a, 2.0 * a)),
        ),
        carries=(
            Carry("tip", flap_e, plane.point(near), plane.spot(a, middle)),
            Carry("shoulder", flap_d, plane.point(near), plane.spot(m, 0.5 * (m + near))),
        ),
        flaps=(plane.point(flap),),
    )


def _direction(angle: float) -> NDArray[np.float64]:
    return np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])


_WEBSTER = "R. C. Webster, T. M. Davidson, R. C. Smith, The thirty degree transposition flap, Laryngoscope 88 (1978) 85"
WEBSTER = LibraryDesign(
    "webster",
    "Webster's 30° flap",
    "A defect of cheek, temple or chin where the donor site of a flap of 60° would close under too much tension.",
    (Parameter("side", "side of the triangle and of the flap", "mm", 16.0, 4.0, 50.0, "chosen"),),
    webster_flap,
    "the middle of the lesion",
    "from the defect to the flap",
    "",
    _WEBSTER + " (its abstract was read: a tip of 30°, with an M-plasty); J. Sciegienka et al., Plast. Aesthet. Res. 9 "
    "(2022) 1, figure 4 (its caption was read: a W at the base). Lengths and the place of the W are constructed here.",
)
