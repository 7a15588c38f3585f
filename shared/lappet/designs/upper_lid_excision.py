"""The excision of an upper eyelid's loose skin: a crescent above the lid's crease, closed in the crease.

In the design's plane the lower line runs from the medial tip at x = -length/2 to the lateral one as a parabola that
rises by the arch in its middle, as the crease does; beside it the lateral end rises by the tail, away from the crease,
towards the eyebrow's end. The upper line is the lower one raised by the width where the crescent is widest, and by
less towards the tips, by half a sine on either side of the widest place. Nothing is undermined.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import FlapDesign, Seam
from lappet.designs.flat_curves import length as length_of
from lappet.designs.flat_curves import part
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.tissue.placement import Place


def upper_lid_excision(
    center: ArrayLike,
    direction: ArrayLike,
    length: float,
    width: float,
    arch: float = 2.5,
    tail: float = 2.0,
    widest: float = 0.55,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design the excision of an upper eyelid's skin.

    Parameters
    ----------
    center
        Middle of the crescent in mm, shape (3,).
    direction
        Direction from its medial to its lateral tip, shape (3,).
    length
        Length from tip to tip in mm.
    width
        Greatest height of what is cut out in mm, at most half the length.
    arch
        How far the lower line rises over its chord in mm.
    tail
        How far the lateral tip lies above the medial one in mm.
    widest
        Where it is widest, as a share of the length from the medial tip.
    normal
        Outwards from the skin at the middle, shape (3,).
    mirrored
        Whether the eyebrow is to the right of the direction, as on a right eye; on a left one it is to the left.
    project
        Maps points (k, 3) onto a curved skin, as `draped_on` gives, or None.

    Returns
    -------
    FlapDesign
        The design; it has no flap.

    Raises
    ------
    RefusedError
        If a length is not positive or the width is above half the length.
    """
    require_lengths("upper_lid", length=length, width=width)
    if width > 0.5 * length:
        raise refused(
            ProblemCode.DESIGN_RANGE, "upper-lid", f"{width:g}", name="width", range=f"at most {0.5 * length:g} mm"
        )
    share = np.linspace(0.0, 1.0, 401)
    lower = np.column_stack([(share - 0.5) * length, 4.0 * arch * share * (1.0 - share) + tail * share**2])
    high = np.sin(0.5 * np.pi * np.where(share < widest, share / widest, (1.0 - share) / (1.0 - widest)))
    upper = lower + np.column_stack([np.zeros_like(share), width * high])
    middle = 0.5 * (lower[200] + upper[200])
    plane = DesignPlane.at(center, skin_axes(direction, normal, "upper_lid"), mirrored, project, middle)
    below, above = (part(line, 0.0, length_of(line)) for line in (lower, upper))
    seam = Seam("closure", (plane.edge(below, -1), plane.edge(above, 1)))
    around = np.vstack([below[:-1], above[:0:-1]])
    return FlapDesign((plane.excised("defect", around, middle),), (), (seam,), undermined=0.0)


_MARKING = "marked on the patient, by pinching the skin"
_BURKAT = "C. N. Burkat, Skin marking in upper blepharoplasty (2008), doi 10.1007/978-0-387-69007-0_20"
UPPER_LID = LibraryDesign(
    "upper-lid",
    "Upper eyelid skin excision",
    "Loose skin of an upper eyelid (blepharoplasty), closed in the lid's crease.",
    (
        Parameter(
            "length", "length from tip to tip", "mm", 30.0, 15.0, 50.0, "from above the punctum past the canthus"
        ),
        Parameter("width", "greatest height of what is cut out", "mm", 8.0, 2.0, 20.0, _MARKING),
        Parameter("arch", "rise of the lower line over its chord", "mm", 2.5, 0.0, 6.0, "follows the crease"),
        Parameter("tail", "height of the lateral tip over the medial one", "mm", 2.0, 0.0, 8.0, "along a smile line"),
        Parameter("widest", "where it is widest, from the medial tip, in lengths", "", 0.55, 0.3, 0.7, _MARKING),
    ),
    upper_lid_excision,
    "the middle of the crescent",
    "from the medial to the lateral tip",
    "along",
    "Crease 8 to 11 mm above the lashes in women, 6 to 8 in men: abstract of " + _BURKAT + "; the drawing itself is "
    "free, after no figure.",
)
