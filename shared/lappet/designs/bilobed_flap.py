"""The bilobed flap of Zitelli: a first lobe fills a round defect, a second, narrower one the first's place.

How it is drawn: `lappet.designs.lobed_flap`. With lobes of 50° and 45° the flap turns about 100°, as in J. A. Zitelli,
"The bilobed flap for nasal reconstruction", Arch. Dermatol. 125 (1989) 957, who asks for 90° to 110°.
"""

from __future__ import annotations

from numpy.typing import ArrayLike

from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import FlapDesign
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.designs.lobed_flap import lobed_flap
from lappet.tissue.placement import Place


def bilobed(
    center: ArrayLike,
    direction: ArrayLike,
    diameter: float,
    first: float = 50.0,
    second: float = 45.0,
    height: float = 1.5,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design a bilobed flap.

    Parameters
    ----------
    center
        Middle of the defect in mm, shape (3,).
    direction
        Direction from the pivot to the defect, shape (3,).
    diameter
        Diameter of the defect in mm.
    first
        Angle of the first lobe about the pivot in degrees.
    second
        Angle of the second lobe in degrees.
    height
        Height of the second lobe over its chord, in radii of the defect.
    normal
        Outwards from the skin at the middle, shape (3,).
    mirrored
        Whether the lobes lie on the right of the direction.
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
    require_lengths("bilobed", diameter=diameter, first=first, second=second, height=height)
    r = 0.5 * diameter
    plane = DesignPlane.at(center, skin_axes(direction, normal, "bilobed"), mirrored, project, (2.0 * r, 0.0))
    return lobed_flap(plane, r, (first, second), height)


_ZITELLI = "J. A. Zitelli, Arch. Dermatol. 125 (1989) 957"
BILOBED = LibraryDesign(
    "bilobed",
    "Bilobed flap",
    "A round defect up to 15 mm wide of the lower third of the nose, filled with the looser skin above it.",
    (
        Parameter("diameter", "diameter of the defect", "mm", 12.0, 3.0, 30.0, "up to 15 mm on the nose: " + _ZITELLI),
        Parameter("first", "angle of the first lobe", "°", 50.0, 40.0, 60.0, "turn of 90° to 110° in all: " + _ZITELLI),
        Parameter("second", "angle of the second lobe", "°", 45.0, 30.0, 55.0, _ZITELLI),
        Parameter("height", "height of the second lobe, in radii", "", 1.5, 1.0, 2.5, "what closes without a dog-ear"),
    ),
    bilobed,
    "the middle of the defect",
    "from the pivot to the defect",
    "",
    "J. A. Zitelli, The bilobed flap for nasal reconstruction, Arch. Dermatol. 125 (1989) 957.",
)
