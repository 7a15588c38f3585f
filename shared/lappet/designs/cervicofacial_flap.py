"""The cervicofacial flap: the skin of cheek and neck turns forward and up into a large defect of the cheek.

In the design's plane x runs up the face. The defect is a triangle with its tip at the origin and its base, the lower
eyelid's, above; from the base's outer corner B the incision rises over the cheekbone past the eye's outer corner, comes
down in front of the ear to its lobe, and goes on along the neck, forward again, to its end. The flap turns about its
base in front until B lies at the base's inner corner. The incision's outer lip is longer than the flap's edge by the
base; Burow's triangle at the end takes up a part of that, and the sutures, spread evenly, the rest.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from lappet.designs.burow_triangle import burow_triangle
from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import Carry, Corner, FlapDesign, Seam, Spot
from lappet.designs.flat_curves import NICK, bezier, part, segment
from lappet.designs.flat_curves import length as length_of
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.tissue.placement import Place


def cervicofacial_flap(
    center: ArrayLike,
    direction: ArrayLike,
    width: float,
    length: float,
    reach: float = 40.0,
    drop: float = 60.0,
    burow: float = 0.4,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design a cervicofacial flap.

    Parameters
    ----------
    center
        Middle of the defect in mm, shape (3,).
    direction
        Direction up the face, from the defect's tip to its base, shape (3,).
    width
        Base of the triangular defect in mm.
    length
        Height of the defect in mm.
    reach
        From the defect to in front of the ear in mm.
    drop
        How far the incision comes down from the height of the defect's base in mm.
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
        If a length is not positive.
    """
    what = "cervicofacial"
    require_lengths(what, width=width, length=length, reach=reach, drop=drop)
    plane = DesignPlane.at(center, skin_axes(direction, normal, what), mirrored, project, (2.0 / 3.0 * length, 0.0))
    tip, left, right = np.zeros(2), np.array([length, 0.5 * width]), np.array([length, -0.5 * width])
    corner = {
        "over the cheekbone": (0.3 * reach, -0.35 * reach),
        "temple": (0.35 * reach, -reach),
        "ear": (-0.1 * drop, -reach),
        "lobe": (-0.6 * drop, -reach),
        "below the lobe": (-0.8 * drop, -reach),
        "neck": (-0.88 * drop, -0.92 * reach),
        "end": (-drop, -0.72 * reach),
    }
    at = {name: right + np.array(place) for name, place in corner.items()}
    rise = bezier(right, at["over the cheekbone"], at["temple"], at["ear"])
    neck = bezier(at["lobe"], at["below the lobe"], at["neck"], at["end"])
    fine = np.vstack([rise[:-1], segment(at["ear"], at["lobe"])[:-1], neck])
    cut = part(fine, 0.0, length_of(fine))
    flap = np.array([0.2 * length, -0.6 * reach])
    base = segment(left, right)
    near, far = segment(tip, right), segment(tip, left)
    triangle = burow_triangle(plane, "donor", cut, burow * width, 1) if burow > 0.0 else None
    outer = np.vstack([base[:-1], part(cut, 0.0, length_of(cut) - burow * width)])
    seams = [
        Seam("front", (plane.edge_beside(near, flap), plane.edge_beside(far, 2.0 * left - right))),
        Seam("arc", (plane.edge(cut, -1), plane.edge(outer, 1))),
    ]
    corners = [Corner("tip", plane.spot(right, flap), plane.spot(left, 1.3 * left))]
    excised = [plane.excised("defect", np.vstack([far[:-1], base[:-1], near[:0:-1]]), np.array([0.7 * length, 0.0]))]
    if triangle is not None:
        excised.append(triangle.excised)
        seams.append(triangle.seam)
        corners.append(triangle.corner)
    lay = Spot(plane.point(left), plane.point(0.2 * left + 0.2 * right))
    into = right + NICK * np.array([-0.5, 1.0])
    return FlapDesign(
        tuple(excised),
        (plane.points(np.vstack([into[None], cut])),),
        tuple(seams),
        tuple(corners),
        (Carry("tip", plane.spot(right, flap), plane.point(tip), lay),),
        (plane.point(flap),),
    )


_SCIEGIENKA = "J. Sciegienka et al., Plast. Aesthet. Res. 9 (2022) 1, on cheek rotation flaps (an excerpt was read)"
_PLACE = "chosen: what lies between nose, ear and neck"
CERVICOFACIAL = LibraryDesign(
    "cervicofacial",
    "Cervicofacial flap",
    "A large defect of the cheek or lower eyelid, closed by the skin of cheek and neck turned forward.",
    (
        Parameter("width", "base of the triangular defect", "mm", 18.0, 8.0, 50.0, "that of the defect"),
        Parameter("length", "height of the defect", "mm", 26.0, 10.0, 60.0, "that of the defect"),
        Parameter("reach", "from the defect to in front of the ear", "mm", 40.0, 20.0, 90.0, _PLACE),
        Parameter("drop", "how far the incision comes down", "mm", 60.0, 30.0, 140.0, _PLACE),
        Parameter("burow", "base of Burow's triangle, in widths; 0 for none", "", 0.4, 0.0, 0.8, "chosen"),
    ),
    cervicofacial_flap,
    "the middle of the defect",
    "up the face, from the defect's tip to its base",
    "",
    _SCIEGIENKA + "; S. R. Baker, Local Flaps in Facial Reconstruction (not read).",
)
