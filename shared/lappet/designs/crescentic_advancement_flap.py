"""The crescentic advancement flap: beside the ala a crescent is cut out, so that the cheek's skin moves into the lip.

In the design's plane the ala is a circle of radius R that touches the x axis at A = (0, 0) from above. The defect of
the upper lip hangs below the axis, left of A: a triangle with its base from L = (-w, 0) to A and its tip below. From A
the incision follows the ala, to the right and up, to B. The crescent lies outside of it, open to the defect and
broadest in its middle; its outer rim is the flap's upper edge. The flap is drawn to the left until its corner lies at
L: its edge is sewn to the defect's base and the ala, which together are a little longer, and its side to the defect's
other side.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import Carry, Corner, FlapDesign, Seam
from lappet.designs.flat_curves import arc, part, segment
from lappet.designs.flat_curves import length as length_of
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.tissue.placement import Place

OPEN = 0.3  # of the crescent's breadth: how wide it opens to the defect


def crescentic_advancement(
    center: ArrayLike,
    direction: ArrayLike,
    width: float,
    height: float = 1.4,
    radius: float = 11.0,
    sweep: float = 130.0,
    crescent: float = 5.0,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design a crescentic advancement flap.

    Parameters
    ----------
    center
        Middle of the defect in mm, shape (3,).
    direction
        Direction from the defect to the flap along the lip, shape (3,).
    width
        Base of the triangular defect in mm.
    height
        Height of the defect in widths.
    radius
        Radius of the ala's rim in mm.
    sweep
        How far around the ala the crescent reaches in degrees.
    crescent
        Greatest breadth of the crescent in mm.
    normal
        Outwards from the skin at the middle, shape (3,).
    mirrored
        Whether the ala is to the right of the direction.
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
    what = "crescentic"
    require_lengths(what, width=width, height=height, radius=radius, sweep=sweep, crescent=crescent)
    middle = np.array([-0.5 * width, -height * width / 3.0])
    plane = DesignPlane.at(center, skin_axes(direction, normal, what), mirrored, project, middle)
    tip, far, start = np.array([-0.5 * width, -height * width]), np.array([-width, 0.0]), np.zeros(2)
    ala = arc((0.0, radius), radius, -90.0, sweep - 90.0)
    share = np.linspace(0.0, 1.0, 801)[:, None]
    turn = np.radians(share * sweep - 90.0)
    # From OPEN at the defect over 1 in the middle to nothing at the end.
    breadth = crescent * (OPEN * (1.0 - share) + (4.0 - 2.0 * OPEN) * share * (1.0 - share))
    fine = np.array([0.0, radius]) + (radius + breadth) * np.hstack([np.cos(turn), np.sin(turn)])
    edge = part(fine, 0.0, length_of(fine))
    corner = edge[0]
    flap = np.array([radius, -0.5 * height * width])
    top = np.vstack([segment(far, start)[:-1], ala])
    sides = segment(tip, corner), segment(tip, far)
    outline = np.vstack([sides[0][:-1], edge[:-1], ala[:0:-1], segment(start, far)[:-1], sides[1][:0:-1]])
    spot = plane.spot(corner, flap)
    return FlapDesign(
        excised=(plane.excised("defect", outline, middle),),
        incisions=(),
        seams=(
            Seam("lip", (plane.edge_beside(sides[0], flap), plane.edge_beside(sides[1], far + (far - start)))),
            Seam("ala", (plane.edge(edge, -1), plane.edge(top, 1))),
        ),
        corners=(Corner("corner", spot, plane.spot(far, far + np.array([-1.0, 0.6]))),),
        carries=(Carry("corner", spot, None, plane.spot(far, middle)),),
        flaps=(plane.point(flap),),
    )


_WEBSTER = (
    "J. P. Webster, Crescentic peri-alar cheek excision for upper lip flap advancement, Plast. Reconstr. Surg. 16 "
    "(1955) 434"
)
_CHOSEN = "chosen: what lies beside a nose"
CRESCENTIC = LibraryDesign(
    "crescentic",
    "Crescentic advancement flap",
    "A defect of the upper lip below the ala: a crescent beside the ala lets the skin of the cheek come in.",
    (
        Parameter("width", "base of the triangular defect", "mm", 10.0, 3.0, 25.0, "chosen: a third of half a lip"),
        Parameter("height", "height of the defect, in widths", "", 1.4, 0.8, 2.5, _CHOSEN),
        Parameter("radius", "radius of the ala's rim", "mm", 11.0, 6.0, 20.0, _CHOSEN),
        Parameter("sweep", "how far around the ala the crescent reaches", "°", 130.0, 80.0, 180.0, _CHOSEN),
        Parameter("crescent", "greatest breadth of the crescent", "mm", 5.0, 2.0, 12.0, "half of the defect's width"),
    ),
    crescentic_advancement,
    "the middle of the defect",
    "from the defect to the flap, along the lip",
    "",
    _WEBSTER + " (not read).",
)
