"""The island V–Y: a triangle of skin, cut free all around, slides on the tissue below it into the defect.

In the design's plane the defect is a square of side w about the origin, and the island lies to its right: its front is
the defect's right side, its two sides run straight to its tip T. Its front is sewn to the defect's left side, half of
the way by the island's advance s, the rest by the skin on the left. Behind the tip the last s of the two outer lips are
sewn to each other, the stem of the Y; the rest of the lips, with the defect's upper and lower side, to the island's
sides, a little shorter. Island and skin around are undermined: the stalk of fat that feeds it is not modeled.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import Corner, FlapDesign, Seam
from lappet.designs.flat_curves import NICK, part, polyline, segment
from lappet.designs.flat_curves import length as length_of
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.tissue.placement import Place


def island_v_y_flap(
    center: ArrayLike,
    direction: ArrayLike,
    width: float,
    length: float = 2.0,
    advance: float = 0.5,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design an island V–Y.

    Parameters
    ----------
    center
        Middle of the defect in mm, shape (3,).
    direction
        Direction from the defect to the island's tip, shape (3,).
    width
        Side of the square defect in mm.
    length
        Length of the island in widths.
    advance
        How far its tip goes, in widths.
    normal
        Outwards from the skin at the middle, shape (3,).
    mirrored
        Whether the design is mirrored; it is its own image.
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
    require_lengths("island_v_y", width=width, length=length, advance=advance)
    plane = DesignPlane.at(center, skin_axes(direction, normal, "island_v_y"), mirrored, project)
    half, slid = 0.5 * width, advance * width
    tip = np.array([half + length * width, 0.0])
    flap = np.array([half + 0.35 * length * width, 0.0])
    seams, corners, cuts, stem, front, back = [], [], [], [], [], []
    for sign, name in ((1.0, "upper"), (-1.0, "lower")):
        near, far = np.array([half, sign * half]), np.array([-half, sign * half])
        arm = segment(near, tip)
        beyond = np.array([0.0, 4.0 * sign * length * width])
        whole = length_of(np.vstack([far[None], arm]))
        lip = polyline(far, near, tip)
        seams.append(
            Seam(name, (plane.edge_beside(arm, flap), plane.edge_beside(part(lip, 0.0, whole - slid), beyond)))
        )
        stem.append(plane.edge_beside(part(lip, whole - slid, whole), beyond))
        top = plane.spot(near, flap)
        corners.append(Corner(name, top, plane.spot(far, 1.3 * far)))
        end = part(lip, 0.0, whole - slid)[-1]
        corners.append(Corner(f"tip_{name}", plane.spot(tip, flap), plane.spot(end, end + 0.05 * beyond)))
        cuts.append(np.vstack([(near - 0.7 * NICK * np.array([1.0, sign]))[None], arm]))
        front.append(near)
        back.append(far)
    outline = polyline(back[1], front[1], front[0], back[0], back[1])[:-1]
    edges = (
        plane.edge_beside(segment(front[0], front[1]), flap),
        plane.edge_beside(segment(back[0], back[1]), 2.0 * (back[0] + back[1])),
    )
    return FlapDesign(
        (plane.excised("defect", outline, np.zeros(2)),),
        (plane.points(np.vstack([cuts[0], cuts[1][-2::-1]])),),
        (Seam("donor_stem", (stem[0], stem[1])), Seam("front", edges), *seams),
        tuple(corners),
        (),
        (plane.point(flap),),
        undermined=0.5,
    )


_ZOOK = "E. G. Zook et al., V–Y advancement flap for facial defects, Plast. Reconstr. Surg. 65 (1980) 786 (not read)"
_BAKER = "S. R. Baker, Local Flaps in Facial Reconstruction, on island V–Y advancement (not read)"
ISLAND_V_Y = LibraryDesign(
    "island-v-y",
    "Island V–Y advancement",
    "A defect of upper lip, cheek or ala, filled by an island of skin that keeps its stalk of fat below.",
    (
        Parameter("width", "side of the square defect", "mm", 10.0, 3.0, 40.0, _BAKER),
        Parameter("length", "length of the island, in widths", "", 2.2, 1.5, 3.5, "2 to 3 defects long: " + _BAKER),
        Parameter("advance", "how far its tip goes, in widths", "", 0.5, 0.3, 1.0, "chosen: half of the way"),
    ),
    island_v_y_flap,
    "the middle of the defect",
    "from the defect to the island's tip",
    "along",
    _BAKER + "; " + _ZOOK + ".",
)
