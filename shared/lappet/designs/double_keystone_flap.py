"""The keystone flap of type III: two keystone islands on either side of one elliptic defect, which meet in its middle.

Each is that of `lappet.designs.keystone_flap`, the second its mirror image; each goes half of the way.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import FlapDesign, Seam
from lappet.designs.keystone_flap import keystone_island
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.tissue.placement import Place


def double_keystone_flap(
    center: ArrayLike,
    direction: ArrayLike,
    length: float,
    width: float,
    breadth: float = 0.75,
    advance: float = 0.3,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design two opposed keystone flaps.

    Parameters
    ----------
    center
        Middle of the defect in mm, shape (3,).
    direction
        Direction of the defect's long axis, shape (3,).
    length
        Length of the defect from tip to tip in mm.
    width
        Width of the defect in mm, at most the length.
    breadth
        Breadth of each flap in widths of the defect.
    advance
        How far each flap goes into the defect, in widths of the defect; less than its breadth.
    normal
        Outwards from the skin at the middle, shape (3,).
    mirrored
        Whether the design is mirrored; it is its own image.
    project
        Maps points (k, 3) onto a curved skin, as `draped_on` gives, or None.

    Returns
    -------
    FlapDesign
        The design. Nothing is undermined.

    Raises
    ------
    RefusedError
        If a length is not positive or the width is above the length.
    """
    require_lengths("double_keystone", length=length, width=width, breadth=breadth, advance=advance)
    if width > length:
        raise refused(ProblemCode.DESIGN_OVAL, "double_keystone", f"{width:g}", length=length)
    plane = DesignPlane.at(center, skin_axes(direction, normal, "double_keystone"), mirrored, project)
    above, below = (
        keystone_island(plane, length, width, breadth * width, advance * width, side, what)
        for side, what in ((1.0, "upper_"), (-1.0, "lower_"))
    )
    ring = np.vstack([below.inner[:-1], above.inner[:0:-1]])
    pairs = (
        ("defect", above.inner, below.inner),
        ("end_left", above.ends[0], below.ends[0]),
        ("end_right", above.ends[1], below.ends[1]),
    )
    fronts = (
        Seam(name, (plane.edge_beside(one, above.middle), plane.edge_beside(other, below.middle)))
        for name, one, other in pairs
    )
    return FlapDesign(
        (plane.excised("defect", ring, np.zeros(2)),),
        (plane.points(above.cut), plane.points(below.cut)),
        (*fronts, *above.seams, *below.seams),
        (*above.corners, *below.corners),
        (),
        (plane.point(above.middle), plane.point(below.middle)),
        undermined=0.0,
    )


_BEHAN = "F. C. Behan, ANZ J. Surg. 73 (2003) 112 (its abstract was read, not its figures)"
KEYSTONE_III = LibraryDesign(
    "keystone-iii",
    "Double keystone flap (type III)",
    "A large elliptic defect of trunk or limb: two opposed islands on their perforators share its closure.",
    (
        Parameter("length", "length of the defect", "mm", 42.0, 10.0, 150.0, "chosen: that of type I"),
        Parameter("width", "width of the defect", "mm", 18.0, 3.0, 80.0, "that of the lesion with its margin"),
        Parameter("breadth", "breadth of each flap, in widths of the defect", "", 0.75, 0.5, 1.5, "chosen"),
        Parameter("advance", "how far each flap goes into the defect, in widths", "", 0.25, 0.1, 0.45, "chosen"),
    ),
    double_keystone_flap,
    "the middle of the defect",
    "the defect's long axis",
    "",
    _BEHAN
    + ": type III is a pair of keystone flaps that face each other. Types II and IV differ from I and III in what is "
    "done below the skin (deep fascia divided, flap undermined), not in their drawing.",
)
