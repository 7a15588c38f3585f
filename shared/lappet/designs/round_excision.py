"""The round excision, as by a punch, with repair of its dog-ears: closed in the middle first, trimmed, then closed.

In the design's plane the circle lies about the origin and the scar along x. Its middle is closed first; what then
stands up at either end, from 40° above the scar to as much below, is cut out to the scar's tip and closed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import Corner, FlapDesign, Seam
from lappet.designs.flat_curves import NICK, arc, segment
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.tissue.placement import Place

FROM = 40.0  # degrees above and below the scar at which the dog-ears begin
_STEP = 0.5  # mm from point to point of the circle


def round_excision(
    center: ArrayLike,
    direction: ArrayLike,
    diameter: float,
    length: float = 2.6,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design a round excision whose dog-ears are cut out.

    Parameters
    ----------
    center
        Middle of the excision in mm, shape (3,).
    direction
        Direction of the scar, shape (3,).
    diameter
        Diameter of the circle in mm.
    length
        Length of the scar from tip to tip in diameters, more than 1.4.
    normal
        Outwards from the skin at the middle, shape (3,).
    mirrored
        Whether the design is mirrored; it is its own image.
    project
        Maps points (k, 3) onto a curved skin, as `draped_on` gives, or None.

    Returns
    -------
    FlapDesign
        The design; it has no flap.

    Raises
    ------
    RefusedError
        If a length is not positive, or the scar is hardly longer than the circle.
    """
    require_lengths("round_excision", diameter=diameter, length=length)
    if not length > 1.4:
        raise refused(ProblemCode.DESIGN_RANGE, "round-excision", f"{length:g}", name="length", range="more than 1.4")
    r = 0.5 * diameter
    plane = DesignPlane.at(center, skin_axes(direction, normal, "round_excision"), mirrored, project)
    upper = arc((0.0, 0.0), r, 180.0 - FROM, FROM, _STEP)
    lower = upper * np.array([1.0, -1.0])
    corners: list[Corner] = []
    seams = [Seam("donor_middle", (plane.edge(lower, -1), plane.edge(upper, 1)))]
    excised = [plane.excised("defect", arc((0.0, 0.0), r, 0.0, 360.0, _STEP)[:-1], np.zeros(2))]
    for sign, name in ((1.0, "right"), (-1.0, "left")):
        tip, above = np.array([sign * length * r, 0.0]), upper[-1 if sign > 0.0 else 0]
        below = above * np.array([1.0, -1.0])
        sides = segment(above, tip), segment(below, tip)
        base = arc((0.0, 0.0), r - NICK, -FROM, FROM, _STEP) * np.array([sign, 1.0])  # just inside the circle
        around = np.vstack([base, sides[0], sides[1][-2::-1]])
        excised.append(
            plane.excised(f"cone_{name}", around, np.array([sign * (r + 0.2 * (length - 1.0) * r), 0.0]), True)
        )
        lips = (
            plane.edge_beside(side, side.mean(axis=0) + np.array([0.0, 4.0 * up * length * r]))
            for side, up in zip(sides, (1.0, -1.0), strict=True)
        )
        seams.append(Seam(f"cone_{name}", (next(lips), next(lips))))
        up = np.array([0.0, r])
        corners.append(Corner(f"donor_{name}", plane.spot(above, above + up), plane.spot(below, below - up)))
    return FlapDesign(tuple(excised), (), tuple(seams), tuple(corners))


_REPAIR = "a scar 14 % shorter than a fusiform's of 3:1 is published for a round excision with repair of its dog-ears"
ROUND_EXCISION = LibraryDesign(
    "round-excision",
    "Round excision with repair of its dog-ears",
    "A lesion taken out by a punch or in a circle: no more skin goes than stands up once the wound is closed.",
    (
        Parameter("diameter", "diameter of the circle", "mm", 14.0, 3.0, 50.0, "that of the lesion with its margin"),
        Parameter("length", "length of the scar, in diameters", "", 2.6, 1.6, 4.0, _REPAIR),
    ),
    round_excision,
    "the middle of the excision",
    "the scar",
    "along",
    "S. R. Baker, Local Flaps in Facial Reconstruction, on standing cutaneous deformities (not read).",
)
