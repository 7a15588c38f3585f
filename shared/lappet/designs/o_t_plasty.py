"""The O–T: a round defect beside a border that must not move, closed by two flaps that slide along the border.

In the design's plane the border runs along x, below a circle of radius r about the origin. The skin between the circle
and the two lines that touch it from a tip above (a standing cone to come) is cut out with it. Below, incisions leave
the circle to either side along the border, from where its rim is 45° below the middle. The skin beside the circle is
drawn together: its two rims meet in the stem of the T. The border's lip, with the circle's lowest quarter, is longer
than the flaps' lower edges; Burow's triangles in it, at the ends, take that up in part, and the sutures, spread evenly,
the rest.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.burow_triangle import burow_triangle
from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import Carry, Corner, FlapDesign, Seam, Spot
from lappet.designs.flat_curves import NICK, arc, part, segment
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.tissue.placement import Place

LOW = 45.0  # degrees below the middle at which the incisions leave the circle
_STEP = 0.5  # mm from point to point of the circle


def o_t_plasty(
    center: ArrayLike,
    direction: ArrayLike,
    diameter: float,
    apex: float = 2.4,
    limb: float = 1.1,
    burow: float = 0.25,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design an O–T.

    Parameters
    ----------
    center
        Middle of the defect in mm, shape (3,).
    direction
        Direction along the border, shape (3,); the border is to the right of the defect.
    diameter
        Diameter of the defect in mm.
    apex
        Distance of the tip above from the middle, in radii, more than 1.
    limb
        Length of each incision in diameters.
    burow
        Base of each of Burow's triangles in diameters; 0 for none.
    normal
        Outwards from the skin at the middle, shape (3,).
    mirrored
        Whether the border is to the left of the direction.
    project
        Maps points (k, 3) onto a curved skin, as `draped_on` gives, or None.

    Returns
    -------
    FlapDesign
        The design.

    Raises
    ------
    RefusedError
        If a length is not positive, or the tip lies in the circle.
    """
    require_lengths("o_t_plasty", diameter=diameter, apex=apex, limb=limb)
    if not apex > 1.2:
        raise refused(ProblemCode.DESIGN_RANGE, "o-t", f"{apex:g}", name="apex", range="more than 1.2")
    r, cut = 0.5 * diameter, limb * diameter
    plane = DesignPlane.at(center, skin_axes(direction, normal, "o_t_plasty"), mirrored, project)
    tip, foot = np.array([0.0, apex * r]), np.array([0.0, -r])
    touch = float(np.degrees(np.arcsin(1.0 / apex)))  # angle of the circle at which the line from the tip touches it
    parts = []
    for sign, name in ((1.0, "right"), (-1.0, "left")):
        flip = np.array([sign, 1.0])
        rim = np.vstack([arc((0.0, 0.0), r, -LOW, touch, _STEP)[:-1], segment(r * _at(touch), tip)]) * flip
        low = arc((0.0, 0.0), r, -90.0, -LOW, _STEP) * flip
        start = rim[0]
        parts.append((sign, name, rim, low, segment(start, start + np.array([sign * cut, 0.0]))))
    (*_, right, right_low, _), (*_, left, left_low, _) = parts
    outline = np.vstack([right_low[:-1], right[:-1], left[:0:-1], left_low[:0:-1]])
    excised = [plane.excised("defect", outline, np.zeros(2))]
    incisions, seams, corners, carries, flaps, sides = [], [], [], [], [], []
    for sign, name, rim, low, limb_line in parts:
        start = limb_line[0]
        flap = start + np.array([0.4 * sign * cut, 0.9 * r])
        spot = plane.spot(start, flap)
        incisions.append(plane.points(np.vstack([(start * (1.0 - NICK / r))[None], limb_line])))
        taken = np.vstack([low[:-1], part(limb_line, 0.0, cut - burow * diameter)])
        below = np.array([2.0 * sign * cut, -4.0 * cut])
        seams.append(Seam(f"{name}_bar", (plane.edge_beside(limb_line, flap), plane.edge_beside(taken, below))))
        sides.append(plane.edge_beside(rim, 4.0 * sign * np.array([cut, 0.0])))
        carries.append(Carry(name, spot, None, Spot(plane.point(foot), plane.point((sign * 0.4 * r, 0.0)))))
        flaps.append(plane.point(flap))
        if burow > 0.0:
            triangle = burow_triangle(plane, f"donor_{name}", limb_line, burow * diameter, -int(sign))
            excised.append(triangle.excised)
            seams.append(triangle.seam)
            corners.append(triangle.corner)
        corners.append(Corner(name, spot, plane.spot(foot, foot + np.array([sign * 0.3, -1.0]))))
    return FlapDesign(
        tuple(excised),
        tuple(incisions),
        (Seam("stem", (sides[0], sides[1])), *seams),
        tuple(corners),
        tuple(carries),
        tuple(flaps),
    )


def _at(angle: float) -> NDArray[np.float64]:
    return np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])


_BAKER = "S. R. Baker, Local Flaps in Facial Reconstruction, on O-to-T flaps (not read)"
_SCIEGIENKA = "J. Sciegienka et al., Plast. Aesthet. Res. 9 (2022) 1, figure 2 (its caption was read)"
O_T_PLASTY = LibraryDesign(
    "o-t",
    "O–T plasty",
    "A round defect beside a border that must not move: upper lip, eyebrow, hairline.",
    (
        Parameter("diameter", "diameter of the defect", "mm", 14.0, 3.0, 50.0, _BAKER),
        Parameter("apex", "from the middle to the tip above, in radii", "", 2.4, 1.5, 4.0, "chosen: a tip of 49°"),
        Parameter("limb", "length of each incision, in diameters", "", 1.1, 0.75, 3.0, _BAKER),
        Parameter("burow", "base of each of Burow's triangles, in diameters; 0 for none", "", 0.25, 0.0, 0.5, _BAKER),
    ),
    o_t_plasty,
    "the middle of the defect",
    "along the border, the defect to its left",
    "along",
    _BAKER + "; " + _SCIEGIENKA + ".",
)
