"""The trilobed flap: one lobe more than the bilobed flap, so that it borrows skin from farther away.

How it is drawn: `lappet.designs.lobed_flap`. The construction is that of the bilobed flap with a second round lobe.
"""

from __future__ import annotations

from numpy.typing import ArrayLike

from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import FlapDesign
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.designs.lobed_flap import lobed_flap
from lappet.tissue.placement import Place


def trilobed(
    center: ArrayLike,
    direction: ArrayLike,
    diameter: float,
    first: float = 48.0,
    second: float = 45.0,
    third: float = 45.0,
    height: float = 1.5,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design a trilobed flap.

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
    third
        Angle of the third lobe in degrees.
    height
        Height of the third lobe over its chord, in radii of the defect.
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
    require_lengths("trilobed", diameter=diameter, first=first, second=second, third=third, height=height)
    r = 0.5 * diameter
    plane = DesignPlane.at(center, skin_axes(direction, normal, "trilobed"), mirrored, project, (2.0 * r, 0.0))
    return lobed_flap(plane, r, (first, second, third), height)


_ALBERTINI = "J. G. Albertini and J. P. Hansen 2010, on trilobed flaps for the nose (not read)"
_JELLINEK = "N. J. Jellinek and A. B. Findley, Global Dermatol. 3 (2016) 302 (its introduction was read)"
TRILOBED = LibraryDesign(
    "trilobed",
    "Trilobed flap",
    "A round defect of the nasal tip, too low for a bilobed flap to reach the loose skin above.",
    (
        Parameter("diameter", "diameter of the defect", "mm", 11.0, 3.0, 25.0, "that of the bilobed flap"),
        Parameter("first", "angle of the first lobe", "°", 48.0, 35.0, 55.0, "chosen: about 140° in all"),
        Parameter("second", "angle of the second lobe", "°", 45.0, 35.0, 55.0, "chosen"),
        Parameter("third", "angle of the third lobe", "°", 45.0, 30.0, 50.0, "chosen"),
        Parameter("height", "height of the third lobe, in radii", "", 1.5, 1.0, 2.5, "what closes without a dog-ear"),
    ),
    trilobed,
    "the middle of the defect",
    "from the pivot to the defect",
    "",
    _JELLINEK + ", after " + _ALBERTINI + "; drawn as the bilobed flap of J. A. Zitelli with one lobe more.",
)
