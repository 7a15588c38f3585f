"""The keystone flap of type IIB: the island of type I goes farther into the defect, as the gap behind it is not closed.

A split skin graft lies on that gap; here it stays open, and what stays open is what the graft covers. Only the inner
edge, with the first mm of both ends, and the rest of the ends are sewn.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import Corner, FlapDesign
from lappet.designs.flat_curves import NICK
from lappet.designs.keystone_flap import KeystoneIsland, keystone_design, keystone_island
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.tissue.placement import Place

_NAME = "keystone-ii"


def grafted_keystone_flap(
    center: ArrayLike,
    direction: ArrayLike,
    length: float,
    width: float,
    breadth: float = 1.0,
    advance: float = 0.6,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design a keystone flap behind which a skin graft lies.

    Parameters
    ----------
    center
        Middle of the defect in mm, shape (3,).
    direction
        Direction of the defect's long axis, shape (3,); the flap is to its left.
    length
        Length of the defect from tip to tip in mm.
    width
        Width of the defect in mm, at most the length.
    breadth
        Breadth of the flap in widths of the defect.
    advance
        How far the flap goes into the defect, in widths of the defect; less than its breadth.
    normal
        Outwards from the skin at the middle, shape (3,).
    mirrored
        Whether the flap is to the right of the direction.
    project
        Maps points (k, 3) onto a curved skin, as `draped_on` gives, or None.

    Returns
    -------
    FlapDesign
        The design. Nothing is undermined.

    Raises
    ------
    RefusedError
        If a length is not positive, the width is above the length, or the advance not below the breadth.
    """
    require_lengths(_NAME, length=length, width=width, breadth=breadth, advance=advance)
    if width > length:
        raise refused(ProblemCode.DESIGN_OVAL, _NAME, f"{width:g}", length=length)
    if advance >= breadth:
        raise refused(
            ProblemCode.DESIGN_RANGE, _NAME, f"{advance:g}", name="advance", range=f"less than the breadth, {breadth:g}"
        )
    plane = DesignPlane.at(center, skin_axes(direction, normal, _NAME), mirrored, project)
    island = keystone_island(plane, length, width, breadth * width, advance * width)
    ends = tuple(seam for seam in island.seams if seam.name in ("left", "right"))
    corners = tuple(_corner(plane, island, side, end) for side, end in (("left", 0), ("right", -1)))
    return keystone_design(plane, length, island, ends, corners)


def _corner(plane: DesignPlane, island: KeystoneIsland, side: str, end: int) -> Corner:
    """What of an end of the island comes to lie at the defect's tip."""
    own, tip = island.ends[end], island.inner[end]
    outwards = own.mean(axis=0) - island.middle
    into = tip + NICK * outwards / np.linalg.norm(outwards)
    return Corner(f"tip_{side}", plane.spot(own[-1], island.middle), plane.spot(tip, into))


KEYSTONE_II = LibraryDesign(
    _NAME,
    "Keystone flap with a skin graft (type IIB)",
    "A large elliptic defect of a limb: the gap behind the island is not closed but gets a split skin graft.",
    (
        Parameter("length", "length of the defect", "mm", 54.0, 10.0, 150.0, "chosen: 3:1 to the width"),
        Parameter("width", "width of the defect", "mm", 18.0, 3.0, 60.0, "that of the lesion with its margin"),
        Parameter(
            "breadth", "breadth of the flap, in widths of the defect", "", 1.0, 0.75, 2.0, "chosen: as in type I"
        ),
        Parameter("advance", "how far the flap goes into the defect, in widths", "", 0.6, 0.2, 0.7, "chosen"),
    ),
    grafted_keystone_flap,
    "the middle of the defect",
    "the defect's long axis, the flap to its left",
    "",
    "Types after the abstract of F. C. Behan, ANZ J. Surg. 73 (2003) 112, the chapter on keystone flaps at "
    "pocketdentistry.com and Actas Dermosifiliogr. S1578-2190(17)30369-4 (excerpts were read): type II is for larger "
    "defects of limbs, IIA with the deep fascia divided along the outer edge, IIB with a skin graft behind the flap.",
    "What is measured as open is the gap behind the flap, on which the graft lies; the graft is not drawn. The model "
    "has no deep fascia but springs below the fat: a type IIA, in which it is divided, would give type I's numbers.",
)
