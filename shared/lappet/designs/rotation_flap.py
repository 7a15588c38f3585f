"""The rotation flap: a triangular defect is closed by skin that turns along an arc of a circle.

In the design's plane the triangle's tip is the origin, the circle's middle, and its base lies on the circle. From the
base's right corner B the incision follows the circle clockwise to E. The flap turns until its edge OB lies on the
defect's other side; its arc is shorter than the outer lip by the triangle's base, which Burow's triangle at the end
takes up in part, and the sutures, spread evenly, the rest.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.burow_triangle import burow_triangle
from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import Carry, Corner, FlapDesign, Seam, Spot
from lappet.designs.flat_curves import NICK, arc, part, segment
from lappet.designs.flat_curves import length as length_of
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.tissue.placement import Place

MOST_SWEEP = 200  # degrees of the arc: beyond, the flap's base would be narrower than its defect


def rotation_flap(
    center: ArrayLike,
    direction: ArrayLike,
    width: float,
    length: float,
    arc_ratio: float = 4.0,
    burow: float = 0.5,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design a rotation flap.

    Parameters
    ----------
    center
        Middle of the defect in mm, shape (3,).
    direction
        Direction from the triangle's tip to its base, shape (3,).
    width
        Base of the triangular defect in mm.
    length
        Length of the defect from its tip to its base, the radius of the circle, in mm.
    arc_ratio
        Length of the flap's arc in widths of the defect.
    burow
        Base of Burow's triangle in widths of the defect; 0 for none.
    normal
        Outwards from the skin at the middle, shape (3,).
    mirrored
        Whether the flap lies on the left of the direction.
    project
        Maps points (k, 3) onto a curved skin, as `draped_on` gives, or None.

    Returns
    -------
    FlapDesign
        The design.

    Raises
    ------
    RefusedError
        If a length is not positive, or the arc goes around less than 30° or more than 200°.
    """
    require_lengths("rotation", width=width, length=length, arc_ratio=arc_ratio)
    half = float(np.degrees(np.arcsin(min(1.0, 0.5 * width / length))))
    sweep = float(np.degrees(arc_ratio * width / length))
    if not MOST_SWEEP >= sweep >= 30.0:
        raise refused(ProblemCode.DESIGN_ANGLE, "rotation", f"{sweep:.0f}", least=30, most=MOST_SWEEP)
    plane = DesignPlane.at(center, skin_axes(direction, normal, "rotation"), mirrored, project, (0.6 * length, 0.0))
    tip = np.zeros(2)
    base = arc(tip, length, half, -half)  # from the left corner to B, clockwise
    cut = arc(tip, length, -half, -half - sweep)  # from B to E
    left, right = base[0], base[-1]
    flap = 0.5 * arc(tip, length, -half - 0.4 * sweep, -half - 0.4 * sweep)[0]
    lip = np.vstack([base[:-1], cut])
    triangle = burow_triangle(plane, "donor", cut, burow * width, 1) if burow > 0.0 else None
    outer = part(lip, 0.0, length_of(lip) - burow * width)
    near, far = segment(tip, right), segment(tip, left)
    seams = [
        Seam("front", (plane.edge_beside(near, flap), plane.edge_beside(far, 2.0 * left - right))),
        Seam("arc", (plane.edge(cut, -1), plane.edge(outer, 1))),
    ]
    corners = [Corner("tip", plane.spot(right, flap), plane.spot(left, left + (left - 0.5 * right)))]
    excised = [plane.excised("defect", np.vstack([far[:-1], base[:-1], near[:0:-1]]), np.array([0.7 * length, 0.0]))]
    if triangle is not None:
        excised.append(triangle.excised)
        seams.append(triangle.seam)
        corners.append(triangle.corner)
    lay = Spot(plane.point(left), plane.point(0.2 * left + 0.2 * right))
    return FlapDesign(
        tuple(excised),
        (plane.points(np.vstack([(right + NICK * (left - right) / np.linalg.norm(left - right))[None], cut])),),
        tuple(seams),
        tuple(corners),
        (Carry("tip", plane.spot(right, flap), plane.point(tip), lay),),
        (plane.point(flap),),
    )


_BAKER = "S. R. Baker, Local Flaps in Facial Reconstruction, on rotation flaps"
_AHUJA = "R. B. Ahuja, Plast. Reconstr. Surg. 81 (1988) 900"
ROTATION = LibraryDesign(
    "rotation",
    "Rotation flap",
    "A triangular defect of cheek, scalp or sacrum, closed by skin turned along an arc.",
    (
        Parameter("width", "base of the triangular defect", "mm", 12.0, 3.0, 60.0, _BAKER),
        Parameter("length", "length of the defect, the radius of the arc", "mm", 24.0, 4.0, 120.0, _AHUJA),
        Parameter("arc_ratio", "length of the arc, in widths of the defect", "", 4.0, 2.0, 8.0, "4 or more: " + _BAKER),
        Parameter("burow", "base of Burow's triangle, in widths; 0 for none", "", 0.5, 0.0, 1.0, _BAKER),
    ),
    rotation_flap,
    "the middle of the defect",
    "from the defect's tip to its base, where the arc begins",
    "",
    "S. R. Baker, Local Flaps in Facial Reconstruction; R. B. Ahuja, Geometric considerations in the design of "
    "rotation flaps in the scalp and forehead region, Plast. Reconstr. Surg. 81 (1988) 900.",
)
