"""The V–Y and its inverse, the Y–V: a triangular flap, attached at its base, slides along its own axis.

In the design's plane the flap's base is its upper side and its tip T below. In a V–Y the flap is drawn up, away from
its tip, by the advance s: what the tip leaves is closed side to side, the stem of the Y, and skin is gained above. In a
Y–V the stem is cut below the tip, and the tip is drawn down to the stem's end, so that the skin across the stem is
spread apart.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import Carry, Corner, FlapDesign, Seam, Spot
from lappet.designs.flat_curves import length as length_of
from lappet.designs.flat_curves import part, polyline, segment
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.tissue.placement import Place


def v_y_plasty(
    center: ArrayLike,
    direction: ArrayLike,
    length: float,
    width: float = 0.8,
    advance: float = 0.3,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design a V–Y.

    Parameters
    ----------
    center
        Middle of the V in mm, shape (3,).
    direction
        Direction in which the flap advances, shape (3,).
    length
        Length of the V from its base to its tip in mm.
    width
        Base of the V in lengths.
    advance
        How far the flap advances, in lengths.
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
    require_lengths("v_y_plasty", length=length, width=width, advance=advance)
    plane = DesignPlane.at(center, skin_axes(direction, normal, "v_y_plasty"), mirrored, project)
    tip, there = np.array([-0.5 * length, 0.0]), np.array([(advance - 0.5) * length, 0.0])
    flap = np.array([0.15 * length, 0.0])
    seams, stem, ends, corners = [], [], [], []
    for sign, name in ((1.0, "left"), (-1.0, "right")):
        base = np.array([0.5 * length, 0.5 * sign * width * length])
        arm = segment(tip, base)
        beyond = np.array([0.0, 4.0 * sign * length])
        used = advance * length  # of the outer lip for the stem
        stem.append(plane.edge_beside(part(arm, 0.0, used), beyond))
        rest = part(arm, used, length_of(arm))
        seams.append(Seam(name, (plane.edge_beside(arm, flap), plane.edge_beside(rest, beyond))))
        ends.append(base)
        corners.append(Corner(f"tip_{name}", plane.spot(tip, flap), plane.spot(rest[0], rest[0] + 0.2 * beyond)))
    return FlapDesign(
        (),
        (plane.points(polyline(ends[0], tip, ends[1])),),
        (Seam("donor_stem", (stem[0], stem[1])), *seams),
        tuple(corners),
        (Carry("tip", plane.spot(tip, flap), None, Spot(plane.point(there), plane.point(flap + there - tip))),),
        (plane.point(flap),),
    )


def y_v_plasty(
    center: ArrayLike,
    direction: ArrayLike,
    length: float,
    width: float = 1.0,
    stem: float = 0.5,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design a Y–V.

    Parameters
    ----------
    center
        The fork of the Y in mm, shape (3,).
    direction
        Direction in which the flap advances, along the stem, shape (3,).
    length
        Length of the flap from its base to the fork in mm.
    width
        Base of the flap in lengths.
    stem
        Length of the stem in lengths.
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
    require_lengths("y_v_plasty", length=length, width=width, stem=stem)
    plane = DesignPlane.at(center, skin_axes(direction, normal, "y_v_plasty"), mirrored, project)
    tip, end = np.zeros(2), np.array([stem * length, 0.0])
    flap = np.array([-0.6 * length, 0.0])
    arms = [np.array([-length, 0.5 * sign * width * length]) for sign in (1.0, -1.0)]
    seams = []
    for arm, sign, name in zip(arms, (1.0, -1.0), ("left", "right"), strict=True):
        beyond = np.array([0.5 * stem * length, sign * 4.0 * length])
        lip = polyline(end, tip, arm)
        seams.append(Seam(name, (plane.edge_beside(segment(tip, arm), flap), plane.edge_beside(lip, beyond))))
    lay = Spot(plane.point(end), plane.point(tip))
    return FlapDesign(
        (),
        (plane.points(polyline(arms[0], tip, arms[1])), plane.points(segment(tip, end))),
        tuple(seams),
        (Corner("tip", plane.spot(tip, flap), plane.spot(end, 2.0 * end)),),
        (Carry("tip", plane.spot(tip, flap), None, lay),),
        (plane.point(flap),),
    )


_BAKER = "S. R. Baker, Local Flaps in Facial Reconstruction, on V–Y and Y–V advancement"
_SHARE = "what the skin gives at the base; the shorter, the looser"
V_Y_PLASTY = LibraryDesign(
    "v-y",
    "V–Y advancement",
    "A notched lip or eyelid, or a contracture, set free by skin pushed forward.",
    (
        Parameter("length", "length of the V", "mm", 24.0, 5.0, 80.0, _BAKER),
        Parameter("width", "base of the V, in lengths", "", 0.8, 0.4, 1.5, _BAKER),
        Parameter("advance", "how far the flap advances, in lengths", "", 0.3, 0.1, 0.5, _SHARE),
    ),
    v_y_plasty,
    "the middle of the V",
    "where the flap advances to",
    "",
    _BAKER + ".",
)
Y_V_PLASTY = LibraryDesign(
    "y-v",
    "Y–V advancement",
    "A short band across the stem, for example of a burn scar, lengthened by a flap drawn into it.",
    (
        Parameter("length", "length of the flap", "mm", 18.0, 5.0, 60.0, _BAKER),
        Parameter("width", "base of the flap, in lengths", "", 1.0, 0.5, 1.8, _BAKER),
        Parameter("stem", "length of the stem, in lengths", "", 0.5, 0.2, 0.8, _SHARE),
    ),
    y_v_plasty,
    "the fork of the Y",
    "where the flap advances to, along the stem",
    "",
    _BAKER + ".",
)
