"""The five-flap Z-plasty ("jumping man"): two opposed Z-plasties and between them a Y–V.

In the design's plane the scar runs from P' = (-L, 0) over O, its middle, to P = (L, 0). Below, limbs OV and OV' leave O
at the angle of the flaps to the scar: between them lies the fifth flap, its tip at O. Above, limbs PU and P'U' leave
the ends, parallel to OV and OV', and the stem OS goes up from O. On either side the flap with its tip at O, below the
scar, and that with its tip at P, above it, change places; the fifth flap's tip is drawn up to S, so that its sides are
sewn to the stem and on to the flaps that came from above.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import Carry, Corner, FlapDesign, Seam
from lappet.designs.flat_curves import polyline, segment
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.designs.z_plasty_flaps import LOW
from lappet.tissue.placement import Place


def five_flap_z_plasty(
    center: ArrayLike,
    direction: ArrayLike,
    limb: float,
    angle: float = 50.0,
    stem: float = 0.3,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design a five-flap Z-plasty.

    Parameters
    ----------
    center
        Middle of the scar in mm, shape (3,).
    direction
        Direction of the scar, shape (3,); the stem is to its left.
    limb
        Length of each limb, half of the scar, in mm.
    angle
        Angle of the flaps in degrees, 45 to 65; that of the fifth is 180° less twice as much.
    stem
        Length of the stem in limbs.
    normal
        Outwards from the skin at the middle, shape (3,).
    mirrored
        Whether the stem is to the right of the direction.
    project
        Maps points (k, 3) onto a curved skin, as `draped_on` gives, or None.

    Returns
    -------
    FlapDesign
        The design.

    Raises
    ------
    RefusedError
        If a length is not positive or the angle is out of range.
    """
    require_lengths("five_flap_z_plasty", limb=limb, stem=stem)
    if not 45.0 <= angle <= 65.0:
        raise refused(ProblemCode.DESIGN_ANGLE, "five_flap_z_plasty", f"{angle:g}", least=45, most=65)
    plane = DesignPlane.at(center, skin_axes(direction, normal, "five_flap_z_plasty"), mirrored, project)
    o, s = np.zeros(2), np.array([0.0, stem * limb])
    turn = np.radians(angle)
    fifth = np.array([0.0, -0.6 * limb])
    incisions, seams, corners, carries, flaps = [], [], [], [], []
    for side, name in ((1.0, "right"), (-1.0, "left")):
        p = np.array([side * limb, 0.0])
        v = limb * np.array([side * np.cos(turn), -np.sin(turn)])
        u = p - v
        below, above = (o + p + v) / 3.0, (o + p + u) / 3.0
        outside = p + u - above
        incisions += [polyline(u, p, o), segment(o, v)]
        pairs = (
            (f"{name}_lip", (segment(p, o), below), (segment(p, u), outside)),
            (f"{name}_flaps", (segment(o, v), below), (segment(u, p), above)),
            (f"{name}_stem", (segment(o, v), fifth), (polyline(s, o, p), 0.5 * (s + above))),
        )
        seams += [Seam(which, (plane.edge_beside(*one), plane.edge_beside(*other))) for which, one, other in pairs]
        low, high = plane.spot(o, below), plane.spot(p, above)
        corners += [
            Corner(f"{name}_low", low, plane.spot(u, 2.0 * u - p)),
            Corner(f"{name}_high", high, plane.spot(v, 2.0 * v)),
        ]
        carries += [
            Carry(f"{name}_low", low, plane.point(p), plane.spot(u, below), LOW),
            Carry(f"{name}_high", high, plane.point(o), plane.spot(v, above)),
        ]
        flaps += [plane.point(below), plane.point(above)]
    tip = plane.spot(o, fifth)
    return FlapDesign(
        excised=(),
        incisions=(
            plane.points(np.vstack([incisions[0], incisions[2][-2::-1]])),
            plane.points(np.vstack([incisions[1][::-1], incisions[3][1:]])),
            plane.points(segment(o, s)),
        ),
        seams=tuple(seams),
        corners=(*corners, Corner("tip", tip, plane.spot(s, 2.0 * s))),
        carries=(*carries, Carry("tip", tip, None, plane.spot(s, o), 0.3)),
        flaps=(*flaps, plane.point(fifth)),
    )


_HIRSHOWITZ = (
    "B. Hirshowitz, A. Karev, M. Rousso, Combined double Z-plasty and Y–V advancement for thumb web contracture, Hand "
    "7 (1975) 291 (not read)"
)
_MUSTARDE = "J. C. Mustardé, on epicanthus: the jumping man (not read)"
FIVE_FLAP_Z_PLASTY = LibraryDesign(
    "five-flap-z-plasty",
    "Five-flap Z-plasty (jumping man)",
    "A web with slack skin on one of its sides: the first web space, the armpit, the fold of an epicanthus.",
    (
        Parameter("limb", "length of each limb, half of the scar", "mm", 16.0, 4.0, 40.0, _HIRSHOWITZ),
        Parameter("angle", "angle of the four outer flaps", "°", 50.0, 45.0, 65.0, _HIRSHOWITZ),
        Parameter("stem", "length of the stem, in limbs", "", 0.3, 0.15, 0.5, "chosen: what the fifth flap gives"),
    ),
    five_flap_z_plasty,
    "the middle of the scar",
    "the scar, the stem to its left",
    "",
    _HIRSHOWITZ + "; " + _MUSTARDE + ".",
)
