"""The rotation flap with a back-cut: its incision turns back into its base at the end, which lets it turn farther.

Defect and arc are those of `lappet.designs.rotation_flap`; in its plane the back-cut runs from the arc's end E to K, on
the way to the circle's middle. The flap turns about K. Its corner at E moves away along the arc by a third of the
back-cut, s: behind it the last s of the arc's outer lip is sewn to the first s of the back-cut's, the stem of a Y, and
the rest of the back-cut's outer lip to the flap's side of it. What the defect's base is longer than s is spread over
the sutures of the arc.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import Carry, Corner, FlapDesign, Seam, Spot
from lappet.designs.flat_curves import NICK, arc, part, segment
from lappet.designs.flat_curves import length as length_of
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.designs.rotation_flap import MOST_SWEEP
from lappet.tissue.placement import Place


def back_cut_rotation_flap(
    center: ArrayLike,
    direction: ArrayLike,
    width: float,
    length: float,
    arc_ratio: float = 4.0,
    back_cut: float = 1.2,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design a rotation flap with a back-cut.

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
    back_cut
        Length of the back-cut in widths of the defect; it ends before the circle's middle.
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
        If a length is not positive, the arc goes around less than 30° or more than 200°, or the back-cut leaves less
        than a third of the flap's base.
    """
    what = "rotation-back-cut"
    require_lengths(what, width=width, length=length, arc_ratio=arc_ratio, back_cut=back_cut)
    half = float(np.degrees(np.arcsin(min(1.0, 0.5 * width / length))))
    sweep = float(np.degrees(arc_ratio * width / length))
    if not MOST_SWEEP >= sweep >= 30.0:
        raise refused(ProblemCode.DESIGN_ANGLE, what, f"{sweep:.0f}", least=30, most=MOST_SWEEP)
    if back_cut * width > 2.0 / 3.0 * length:
        most = f"at most {2.0 / 3.0 * length / width:.2f}"
        raise refused(ProblemCode.DESIGN_RANGE, what, f"{back_cut:g}", name="back_cut", range=most)
    plane = DesignPlane.at(center, skin_axes(direction, normal, what), mirrored, project, (0.6 * length, 0.0))
    tip = np.zeros(2)
    base = arc(tip, length, half, -half)  # from the left corner to B, clockwise
    cut = arc(tip, length, -half, -half - sweep)  # from B to E
    left, right, end = base[0], base[-1], cut[-1]
    slid, deep = back_cut * width / 3.0, back_cut * width
    back = segment(end, end * (1.0 - deep / length))  # from E to K
    flap = 0.5 * arc(tip, length, -half - 0.4 * sweep, -half - 0.4 * sweep)[0]
    past = end + 0.5 * (cut[-1] - cut[-2]) / np.linalg.norm(cut[-1] - cut[-2]) * length
    outside = cut[len(cut) // 2] * 3.0
    lip = np.vstack([base[:-1], cut])
    near, far = segment(tip, right), segment(tip, left)
    stem = part(cut[::-1], 0.0, slid), part(back, 0.0, slid)
    pairs = (
        ("front", (near, flap), (far, 2.0 * left - right)),
        ("donor_stem", (stem[0], outside), (stem[1], past)),
        ("back_cut", (back, flap), (part(back, slid, deep), past)),
    )
    outer = part(lip, 0.0, length_of(lip) - slid)
    heel = plane.spot(end, 0.6 * end + 0.2 * cut[len(cut) // 2])
    lay = Spot(plane.point(left), plane.point(0.2 * left + 0.2 * right))
    incision = np.vstack([(right + NICK * (left - right) / np.linalg.norm(left - right))[None], cut[:-1], back])
    return FlapDesign(
        (plane.excised("defect", np.vstack([far[:-1], base[:-1], near[:0:-1]]), np.array([0.7 * length, 0.0])),),
        (plane.points(incision),),
        (
            Seam("arc", (plane.edge(cut, -1), plane.edge(outer, 1))),
            *(Seam(name, (plane.edge_beside(*one), plane.edge_beside(*other))) for name, one, other in pairs),
        ),
        (
            Corner("tip", plane.spot(right, flap), plane.spot(left, left + (left - 0.5 * right))),
            Corner("heel_arc", heel, plane.spot(stem[0][-1], 1.2 * stem[0][-1])),
            Corner("heel_back", heel, plane.spot(stem[1][-1], stem[1][-1] + 0.3 * (past - end))),
        ),
        (Carry("tip", plane.spot(right, flap), plane.point(back[-1]), lay),),
        (plane.point(flap),),
    )


_BAKER = "S. R. Baker, Local Flaps in Facial Reconstruction, on rotation flaps (not read)"
_RICHARDS = "A. M. Richards, Key Notes on Plastic Surgery, on rotation flaps (an excerpt was read)"
ROTATION_BACK_CUT = LibraryDesign(
    "rotation-back-cut",
    "Rotation flap with a back-cut",
    "A triangular defect of scalp, cheek or sacrum where a plain rotation flap is too tight at its base.",
    (
        Parameter("width", "base of the triangular defect", "mm", 12.0, 3.0, 60.0, _BAKER),
        Parameter("length", "length of the defect, the radius of the arc", "mm", 24.0, 4.0, 120.0, _BAKER),
        Parameter("arc_ratio", "length of the arc, in widths of the defect", "", 4.0, 2.0, 8.0, "4 or more: " + _BAKER),
        Parameter(
            "back_cut", "length of the back-cut, in widths", "", 1.2, 0.8, 3.0, "chosen; at the base: " + _RICHARDS
        ),
    ),
    back_cut_rotation_flap,
    "the middle of the defect",
    "from the defect's tip to its base, where the arc begins",
    "",
    _BAKER + "; " + _RICHARDS + ".",
)
