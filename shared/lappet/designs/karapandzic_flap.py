"""The Karapandzic flap: what is left of the lips is turned round the mouth into a defect of the lower lip.

In the design's plane x runs along the closed mouth, which is a slit from the commissure C at (-m/2, 0) to (m/2, 0); the
upper lip is above it. The defect is a rectangle as high as the lip, from (-w/2, 0) down to (w/2, -h). From its lower
corners both incisions follow the mouth at the distance h, "equal to the depth of the defect": along the chin's crease,
about the commissures, and back above the upper lip to the wing of the nose. Between an incision and the mouth lies a
flap, which stays joined to the upper lip, with its vessels and nerves.

Both flaps turn round the commissures until they meet in the middle. The outer lip of each cut is longer than the
flap's, by half the defect; the difference is spread over the whole of it. Nothing is added to the lips: the mouth
becomes smaller by the defect.

The flaps are freed and everything else stays on its bed. A sheet of skin has no mucosa, which a surgeon leaves whole:
here the incisions go through the sheet. On skin with a mouth the design is laid around that
(`lappet.designs.opening_drape`); elsewhere the slit is cut.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import Carry, Corner, FlapDesign, Seam, Spot
from lappet.designs.flat_curves import NICK, arc, polyline, segment
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.tissue.placement import Place

MOST_SHARE = 2.0 / 3.0  # of the lower lip that the flaps can replace
BESIDE = 4.0  # mm of skin that is freed beyond the cuts
ABOVE = 1.0  # mm above the mouth: where what is freed ends between the flaps
LIFT = 0.3  # of the height to which flaps are lifted: these slide round the mouth
_NAME = "karapandzic"


def karapandzic_flap(
    center: ArrayLike,
    direction: ArrayLike,
    width: float,
    height: float = 14.0,
    mouth: float = 54.0,
    alar: float = 17.0,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design a Karapandzic flap.

    Parameters
    ----------
    center
        Middle of the defect in mm, shape (3,).
    direction
        Direction along the mouth, shape (3,); the upper lip is to its left.
    width
        Width of the defect, along the mouth, in mm.
    height
        Height of the defect, from the mouth down, and distance of the incisions from the mouth in mm.
    mouth
        Distance of the commissures in mm.
    alar
        Distance of the incisions' ends from the middle of the upper lip in mm.
    normal
        Outwards from the skin at the middle, shape (3,).
    mirrored
        Whether the upper lip is to the right of the direction.
    project
        Maps points (k, 3) onto a curved skin, as `draped_on` gives, or None.

    Returns
    -------
    FlapDesign
        The design.

    Raises
    ------
    RefusedError
        If a length is not positive, the defect is wider than two thirds of the mouth, or the incisions end beyond its
        corners.
    """
    require_lengths(_NAME, width=width, height=height, mouth=mouth, alar=alar)
    if width > MOST_SHARE * mouth:
        most = f"at most {MOST_SHARE * mouth:.3g} mm, two thirds of the mouth"
        raise refused(ProblemCode.DESIGN_RANGE, _NAME, f"{width:g}", name="width", range=most)
    if alar > 0.5 * mouth:
        most = f"at most {0.5 * mouth:.3g} mm, half the mouth"
        raise refused(ProblemCode.DESIGN_RANGE, _NAME, f"{alar:g}", name="alar", range=most)
    half, corner = 0.5 * width, 0.5 * mouth
    plane = DesignPlane.at(center, skin_axes(direction, normal, _NAME), mirrored, project, (0.0, -0.5 * height))
    foot = np.array([0.0, -height])
    corners, incisions, carries, sides, stem, flaps = [], [], [], [], [], []
    for sign, name in ((1.0, "right"), (-1.0, "left")):
        flip = np.array([sign, 1.0])
        start, top = flip * (half, -height), flip * (half, 0.0)
        flaps.append(plane.point(flip * (corner + 0.5 * height, 0.0)))
        cut = flip * _around(half, corner, height, alar)
        outer = np.vstack([segment(foot, start)[:-1], cut])
        beside = flip * (half + 2.0, -0.5 * height)
        sides.append(Seam(f"{name}_side", (plane.edge(cut, int(sign)), plane.edge(outer, -int(sign)))))
        stem.append(plane.edge_beside(segment(start, top), beside))
        incisions.append(plane.points(np.vstack([start + 0.7 * NICK * np.array([-sign, 1.0]), cut])))
        spot = plane.spot(start, beside)
        corners.append(Corner(name, spot, plane.spot(foot, foot + np.array([0.3 * sign, -1.0]))))
        carries.append(Carry(name, spot, None, Spot(plane.point(foot), plane.point((1.0 * sign, -0.5 * height))), LIFT))
    defect = polyline((-half, 0.0), (-half, -height), (half, -height), (half, 0.0))
    return FlapDesign(
        (replace(plane.excised("defect", defect, np.array([0.0, -0.5 * height])), open=True),),
        tuple(incisions),
        (Seam("stem", (stem[0], stem[1])), *sides),
        tuple(corners),
        tuple(carries),
        tuple(flaps),
        freed=(plane.outline(_freed(corner, height, alar)),),
        opening=plane.points(segment((-corner, 0.0), (corner, 0.0))),
    )


def _around(half: float, corner: float, height: float, alar: float) -> NDArray[np.float64]:
    """The incision on the right, at one distance from the mouth: below it, about its corner, above it."""
    below = segment((half, -height), (corner, -height))
    about = arc((corner, 0.0), height, -90.0, 90.0)
    above = segment((corner, height), (alar, height))
    return np.vstack([below[:-1], about, above[1:]])


def _freed(corner: float, height: float, alar: float) -> NDArray[np.float64]:
    """What is freed, counter-clockwise: the flaps with the skin beside their cuts, not the upper lip between them."""
    right = _around(0.0, corner, height + BESIDE, alar)
    inner = polyline(right[-1], (alar, ABOVE), (0.0, ABOVE))
    left = np.vstack([right, inner[1:]])[1:-1] * np.array([-1.0, 1.0])
    return np.vstack([right, inner[1:], left[::-1]])


_SITE = "lipreconstruction.com, on the Karapandzic flap, quoting him"
_TWO_THIRDS = "chosen in it; at most two thirds of the mouth: drmirdamadi.com, on lip reconstruction"
KARAPANDZIC = LibraryDesign(
    _NAME,
    "Karapandzic flap",
    "A defect of up to two thirds of the lower lip, closed with what is left of both lips, which keep their nerves.",
    (
        Parameter("width", "width of the defect", "mm", 22.0, 5.0, 45.0, _TWO_THIRDS),
        Parameter("height", "height of the defect, and distance of the cuts", "mm", 14.0, 6.0, 30.0, _SITE),
        Parameter("mouth", "distance of the commissures", "mm", 54.0, 20.0, 80.0, "50 to 60 mm: plasticsurgerykey.com"),
        Parameter(
            "alar", "from the upper lip's middle to the ends", "mm", 17.0, 5.0, 30.0, "chosen: the wings of the nose"
        ),
    ),
    karapandzic_flap,
    "the middle of the defect",
    "along the mouth, the upper lip to the left",
    "",
    "After M. Karapandzic, Br. J. Plast. Surg. 27 (1974) 93 (not read), as quoted on lipreconstruction.com.",
    "The seam in the middle of the lip ends at the mouth, and most of what is measured as open is its slit.",
)
