"""The island V–Y: a triangle of skin, cut around and left on what is below it, moves into a defect at its base.

In the design's plane the island advances along x. The defect is a band, s high: its upper and lower edges are the same
shallow bow over the width w, so that the island's base, which is the lower edge, fits the upper one when it has moved
by s. The island's sides run from the ends of the lower edge to the tip T. The first s of the wound's lips beside the
defect take the island's sides as they come up; what T leaves is closed side to side, the stem of the Y, as long as s.

Nothing is undermined: the island moves on its bed, with the vessels that come up through it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import Corner, FlapDesign, Seam
from lappet.designs.flat_curves import NICK, part, polyline, segment
from lappet.designs.flat_curves import length as length_of
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.tissue.placement import Place

RISE = 0.15  # of the width: height of the bow of the defect's edges
_LEAST = 1.3  # lengths of the advance: of the island, so that its tip stays below the stem


def island_v_y(
    center: ArrayLike,
    direction: ArrayLike,
    width: float,
    height: float = 0.5,
    length: float = 2.2,
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
        Direction in which the island advances, shape (3,).
    width
        Width of the defect and of the island's base in mm.
    height
        Height of the defect in widths.
    length
        Length of the island in widths.
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
        If a length is not positive, or the island is hardly longer than its way.
    """
    require_lengths("island_v_y", width=width, height=height, length=length)
    if length < _LEAST * height:
        raise refused(
            ProblemCode.DESIGN_RANGE,
            "island-v-y",
            f"{length:g}",
            name="length",
            range=f"at least {_LEAST * height:g} widths",
        )
    plane = DesignPlane.at(center, skin_axes(direction, normal, "island_v_y"), mirrored, project)
    s = height * width
    across = np.linspace(0.5 * width, -0.5 * width, 401)
    fine = np.column_stack([RISE * width * (1.0 - (2.0 * across / width) ** 2) + 0.5 * s, across])
    upper = part(fine, 0.0, length_of(fine))  # from the left to the right
    base = upper - (s, 0.0)
    tip = np.array([-0.5 * s - length * width, 0.0])
    middle = np.array([-0.5 * s - 0.3 * length * width, 0.0])
    arms = [segment(end, tip) for end in (base[0], base[-1])]
    seams, stem, corners = [], [], []
    for arm, end, sign, name in ((arms[0], upper[0], 1.0, "left"), (arms[1], upper[-1], -1.0, "right")):
        beyond = np.array([0.0, 8.0 * sign * width])
        whole = length_of(arm)
        rest, last = part(arm, 0.0, whole - s), part(arm, whole - s, whole)
        lip = np.vstack([segment(end, arm[0])[:-1], rest])
        seams.append(Seam(name, (plane.edge_beside(arm, middle), plane.edge_beside(lip, beyond))))
        stem.append(plane.edge_beside(last[::-1], beyond))
        corners += [
            Corner(f"base_{name}", plane.spot(arm[0], middle), plane.spot(end, end + 0.3 * s * np.array([1.0, sign]))),
            Corner(f"tip_{name}", plane.spot(tip, middle), plane.spot(rest[-1], rest[-1] + 0.02 * beyond)),
        ]
    far = np.array([4.0 * length * width, 0.0])
    front = Seam("defect", (plane.edge_beside(base, middle), plane.edge_beside(upper, far)))
    ring = np.vstack([upper[:-1], segment(upper[-1], base[-1])[:-1], base[:0:-1], segment(base[0], upper[0])[:-1]])
    nicks = [end + NICK * np.array([0.6, -np.sign(end[1])]) for end in (base[0], base[-1])]
    return FlapDesign(
        (plane.excised("defect", ring, np.array([RISE * width, 0.0])),),
        (plane.points(polyline(nicks[0], base[0], tip, base[-1], nicks[1])),),
        (Seam("donor_stem", (stem[0], stem[1])), front, *seams),
        tuple(corners),
        (),
        (plane.point(middle),),
        undermined=0.0,
    )


_APEX = "an apex of 20° to 60°: J. Plast. Reconstr. Aesthet. Surg. 2012, S1748-6815(12)00115-5 (its abstract was read)"
_BAKER = "S. R. Baker, Local Flaps in Facial Reconstruction, on island advancement flaps (not read)"
ISLAND_V_Y = LibraryDesign(
    "island-v-y",
    "Island V–Y advancement",
    "A defect of the cheek, the upper lip or a finger's tip, filled with a triangle of skin on its own fat.",
    (
        Parameter("width", "width of the defect", "mm", 14.0, 4.0, 50.0, "chosen"),
        Parameter("height", "height of the defect, in widths", "", 0.4, 0.15, 0.8, "how far its fat lets it go"),
        Parameter("length", "length of the island, in widths", "", 2.2, 1.0, 3.0, _APEX),
    ),
    island_v_y,
    "the middle of the defect",
    "where the island advances to",
    "",
    _BAKER + "; " + _APEX + ".",
)
