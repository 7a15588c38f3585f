"""The dorsal nasal flap of Rieger: the skin of the nose's back slides down onto a defect of the tip.

In the design's plane the defect is a circle about the origin, of radius r, and x runs up the nose to the apex G in the
glabella. From D, at 60° on the circle on one side, the incision goes out to the groove between nose and cheek and up it
to G; from there it comes back, the back-cut, to B above the other eye's inner corner. The flap stays attached between B
and the circle's other side.

It turns about B and slides down by s. Its front, the circle's upper third with s of the incision's edge beyond D, is
sewn to the defect's lower two thirds; the rest of the incision's edge to the cheek, s lower. What G leaves is closed
side to side, the stem of a Y in the glabella, with a share of s on the back-cut's outer lip (`STEM`), as the skin
there comes along. At G the two incisions meet at some 30°: from a blunter angle a dog-ear would stand up there.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import Carry, Corner, FlapDesign, Seam, Spot
from lappet.designs.flat_curves import NICK, arc, bezier, part, segment
from lappet.designs.flat_curves import length as length_of
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.tissue.placement import Place

STEM = 0.75  # of the slide: how much of the back-cut's outer lip goes into the stem
OFF = np.radians(17.0)  # of the back-cut from the middle line
_STEP = 0.5  # mm from point to point of the defect


def dorsal_nasal_flap(
    center: ArrayLike,
    direction: ArrayLike,
    diameter: float,
    length: float = 52.0,
    half_width: float = 13.0,
    back_cut: float = 20.0,
    slide: float = 0.6,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design a dorsal nasal flap.

    Parameters
    ----------
    center
        Middle of the defect in mm, shape (3,).
    direction
        Direction from the defect up the nose, shape (3,).
    diameter
        Diameter of the defect in mm.
    length
        Distance from the defect's middle to the apex in the glabella in mm.
    half_width
        How far to the side of the middle the incision lies in mm.
    back_cut
        Length of the back-cut in mm.
    slide
        How far the flap slides along the incision, in diameters of the defect.
    normal
        Outwards from the skin at the middle, shape (3,).
    mirrored
        Whether the incision is on the left of the direction, the patient's right.
    project
        Maps points (k, 3) onto a curved skin, as `draped_on` gives, or None.

    Returns
    -------
    FlapDesign
        The design.

    Raises
    ------
    RefusedError
        If a length is not positive, or the defect leaves no room for the flap above it.
    """
    measures = {"diameter": diameter, "length": length, "half_width": half_width, "back_cut": back_cut, "slide": slide}
    require_lengths("dorsal_nasal", **measures)
    if not length > 2.0 * diameter:
        most = f"less than {0.5 * length:g} mm"
        raise refused(ProblemCode.DESIGN_RANGE, "dorsal-nasal", f"{diameter:g}", name="diameter", range=most)
    r, s = 0.5 * diameter, slide * diameter
    plane = DesignPlane.at(center, skin_axes(direction, normal, "dorsal_nasal"), mirrored, project)
    upper = arc(np.zeros(2), r, 60.0, -60.0, _STEP)  # from the pivot's side to D
    lower = arc(np.zeros(2), r, 60.0, 300.0, _STEP)
    apex = np.array([length, 0.0])
    out, over = upper[-1] + (0.1 * length, -1.25 * half_width), np.array([0.6 * length, -0.5 * half_width])
    first, second, third = _parted(bezier(upper[-1], out, over, apex), s)
    pivot = apex + back_cut * np.array([-np.cos(OFF), np.sin(OFF)])  # B
    fork = apex + STEM * s / back_cut * (pivot - apex)
    back = np.vstack([segment(apex, fork)[:-1], segment(fork, pivot)])
    flap, cheek = np.array([0.45 * length, 0.0]), np.array([0.4 * length, -3.0 * half_width])
    brow = apex + np.array([0.2 * length, 0.5 * half_width])
    front = np.vstack([upper[:-1], first])
    stem = third[::-1], segment(apex, fork)
    tip, lay = plane.spot(apex, flap), Spot(plane.point((-r, 0.0)), plane.point((0.0, 0.0)))
    aside, near_cheek = (0.0, -0.3 * half_width), (-0.05 * length, -0.3 * half_width)
    pairs = (
        ("donor_stem", (stem[0], cheek), (stem[1], brow)),
        ("side", (np.vstack([second[:-1], third]), flap), (np.vstack([first[:-1], second]), cheek)),
        ("back", (back, flap), (segment(fork, pivot), brow)),
    )
    return FlapDesign(
        (plane.excised("defect", np.vstack([lower[:-1], upper[:0:-1]]), np.zeros(2)),),
        (plane.points(np.vstack([upper[-1:] * (1.0 - NICK / r), first[:-1], second[:-1], third[:-1], back])),),
        (
            Seam("front", (plane.edge(front, 1), plane.edge(lower, -1))),
            *(Seam(name, (plane.edge_beside(*one), plane.edge_beside(*other))) for name, one, other in pairs),
        ),
        (
            Corner("side", plane.spot(front[-1], flap), plane.spot(upper[-1], upper[-1] + near_cheek)),
            Corner("tip", tip, plane.spot(stem[0][-1], stem[0][-1] + aside)),
            Corner("rim", tip, plane.spot(stem[1][-1], stem[1][-1] + 0.1 * (brow - apex))),
        ),
        (Carry("front", plane.spot((r, 0.0), (2.0 * r, 0.0)), None, lay),),
        (plane.point(flap),),
        undermined=0.9,
    )


def _parted(curve: NDArray[np.float64], end: float) -> tuple[NDArray[np.float64], ...]:
    """A curve's first mm, what is between, and as many last ones: seams then end at points of the cut."""
    whole = length_of(curve)
    return part(curve, 0.0, end), part(curve, end, whole - end), part(curve, whole - end, whole)


_RIEGER = "R. A. Rieger, Plast. Reconstr. Surg. 40 (1967) 147"
_PLACE = "chosen: what lies on a nose"
_TIP = "chosen: less draws the tip up"
DORSAL_NASAL = LibraryDesign(
    "dorsal-nasal",
    "Dorsal nasal flap (Rieger)",
    "A defect of the nasal tip or dorsum up to 25 mm wide, filled with the skin of the nose's back and the glabella.",
    (
        Parameter("diameter", "diameter of the defect", "mm", 14.0, 4.0, 25.0, "25 mm or less: Sciegienka 2022"),
        Parameter("length", "from the defect's middle to the glabellar apex", "mm", 60.0, 25.0, 90.0, _PLACE),
        Parameter("half_width", "from the middle line to the groove beside the nose", "mm", 14.0, 5.0, 25.0, _PLACE),
        Parameter("back_cut", "length of the back-cut", "mm", 24.0, 8.0, 40.0, "to above the inner canthus"),
        Parameter("slide", "how far it slides, in diameters of the defect", "", 0.6, 0.35, 0.7, _TIP),
    ),
    dorsal_nasal_flap,
    "the middle of the defect",
    "from the defect up the nose",
    "",
    "J. Sciegienka et al., Plast. Aesthet. Res. 9 (2022) 1, on the sliding glabellar flap (an excerpt was read), after "
    + _RIEGER
    + " (not read).",
)
