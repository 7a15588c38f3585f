"""The A–T: a triangular defect is closed by two flaps drawn together over its base, which leaves a scar like a T.

In the design's plane the defect's base lies on the x axis and its tip above. From both ends of the base an incision
goes on along the axis. The skin beside the triangle's two sides is drawn together: the sides meet in the stem of the
T. The lower lip is longer than the flaps' lower edges by the base; Burow's triangles in it, at the ends, take that up
in part, and the sutures, spread evenly, the rest.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from lappet.designs.burow_triangle import burow_triangle
from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import Carry, Corner, FlapDesign, Seam, Spot
from lappet.designs.flat_curves import NICK, part, polyline, segment
from lappet.designs.flat_curves import length as length_of
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.tissue.placement import Place


def a_t_plasty(
    center: ArrayLike,
    direction: ArrayLike,
    width: float,
    height: float = 1.2,
    limb: float = 1.25,
    burow: float = 0.4,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design an A–T.

    Parameters
    ----------
    center
        Middle of the defect in mm, shape (3,).
    direction
        Direction along the defect's base, shape (3,); the tip is to its left.
    width
        Base of the triangular defect in mm.
    height
        Height of the defect in widths.
    limb
        Length of each incision in widths.
    burow
        Base of each of Burow's triangles in widths; 0 for none.
    normal
        Outwards from the skin at the middle, shape (3,).
    mirrored
        Whether the tip is to the right of the direction.
    project
        Maps points (k, 3) onto a curved skin, as `draped_on` gives, or None.

    Returns
    -------
    FlapDesign
        The design.

    Raises
    ------
    RefusedError
        If a length is not positive.
    """
    require_lengths("a_t_plasty", width=width, height=height, limb=limb)
    half, tall, cut = 0.5 * width, height * width, limb * width
    plane = DesignPlane.at(center, skin_axes(direction, normal, "a_t_plasty"), mirrored, project, (0.0, tall / 3.0))
    apex, foot = np.array([0.0, tall]), np.zeros(2)
    excised = [
        plane.excised("defect", polyline((-half, 0.0), (half, 0.0), apex, (-half, 0.0))[:-1], np.array([0.0, tall / 3]))
    ]
    incisions, seams, corners, carries, flaps, sides = [], [], [], [], [], []
    for sign, name in ((1.0, "right"), (-1.0, "left")):
        start, end = np.array([sign * half, 0.0]), np.array([sign * (half + cut), 0.0])
        flap = np.array([sign * (half + 0.4 * cut), 0.35 * tall])
        lip = polyline(foot, start, end)
        spot = plane.spot(start, flap)
        inside = np.array([sign * 0.4 * width, 0.3 * width])
        incisions.append(plane.points(np.vstack([start + 0.7 * NICK * np.array([-sign, 1.0]), segment(start, end)])))
        taken = part(lip, 0.0, length_of(lip) - burow * width)
        seams.append(
            Seam(f"{name}_bar", (plane.edge_beside(segment(start, end), flap), plane.edge_beside(taken, -flap)))
        )
        sides.append(plane.edge_beside(segment(start, apex), flap))
        carries.append(Carry(name, spot, None, Spot(plane.point(foot), plane.point(inside))))
        flaps.append(plane.point(flap))
        if burow > 0.0:
            triangle = burow_triangle(plane, f"donor_{name}", segment(start, end), burow * width, -int(sign))
            excised.append(triangle.excised)
            seams.append(triangle.seam)
            corners.append(triangle.corner)
        corners.append(Corner(name, spot, plane.spot(foot, np.array([sign * 0.3, -1.0]))))
    return FlapDesign(
        tuple(excised),
        tuple(incisions),
        (Seam("stem", (sides[0], sides[1])), *seams),
        tuple(corners),
        tuple(carries),
        tuple(flaps),
    )


_BAKER = "S. R. Baker, Local Flaps in Facial Reconstruction, on A-to-T flaps"
A_T_PLASTY = LibraryDesign(
    "a-t",
    "A–T plasty",
    "A triangular defect above a border that must not move: upper lip, eyebrow, hairline.",
    (
        Parameter("width", "base of the triangular defect", "mm", 14.0, 3.0, 50.0, _BAKER),
        Parameter("height", "height of the defect, in widths", "", 1.2, 0.6, 2.5, _BAKER),
        Parameter("limb", "length of each incision, in widths", "", 1.25, 0.75, 3.0, _BAKER),
        Parameter("burow", "base of each of Burow's triangles, in widths; 0 for none", "", 0.4, 0.0, 0.5, _BAKER),
    ),
    a_t_plasty,
    "the middle of the defect",
    "the defect's base, its tip to the left",
    "along",
    _BAKER + ".",
)
