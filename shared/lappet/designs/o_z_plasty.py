"""The O–Z: two opposed rotation flaps turned into a round defect, which leaves a scar like a Z.

From both ends of a diameter an incision leaves outwards and curves about its flap with one radius. How it closes:
`lappet.designs.opposed_flaps`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import FlapDesign
from lappet.designs.flat_curves import s_curve
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.designs.opposed_flaps import opposed_flaps
from lappet.tissue.placement import Place


def o_z_plasty(
    center: ArrayLike,
    direction: ArrayLike,
    diameter: float,
    arc: float = 2.0,
    turn: float = 100.0,
    advance: float = 0.4,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design two opposed rotation flaps for a round defect.

    Parameters
    ----------
    center
        Middle of the defect in mm, shape (3,).
    direction
        Direction of the diameter from whose ends the incisions leave, shape (3,).
    diameter
        Diameter of the defect in mm.
    arc
        Length of each incision, as a multiple of the diameter.
    turn
        Angle by which each incision turns about its flap in degrees.
    advance
        Way of each tip along the other flap's rim, as a share of the diameter.
    normal
        Outwards from the skin at the middle, shape (3,).
    mirrored
        Whether the flaps turn the other way.
    project
        Maps points (k, 3) onto a curved skin, as `draped_on` gives, or None.

    Returns
    -------
    FlapDesign
        The design.

    Raises
    ------
    RefusedError
        If a length is not positive or the advance is too large.
    """
    require_lengths("o_z_plasty", diameter=diameter, arc=arc, turn=turn, advance=advance)
    plane = DesignPlane.at(center, skin_axes(direction, normal, "o_z_plasty"), mirrored, project)
    incision = arc * diameter
    cut = np.array([0.5 * diameter, 0.0]) + s_curve(incision, turn, 0.0)
    pivot = 0.5 * (cut[-1] * np.array([1.0, 1.0]) + np.array([-0.5 * diameter, -0.5 * diameter]))
    flap = 0.5 * (cut[len(cut) // 2] + np.array([0.0, -0.5 * diameter]))
    return opposed_flaps("o_z_plasty", plane, diameter, diameter, cut, advance * diameter, pivot, flap)


_BAKER = "S. R. Baker, Local Flaps in Facial Reconstruction, on O-to-Z flaps"
O_Z_PLASTY = LibraryDesign(
    "o-z",
    "O–Z plasty",
    "A round defect of scalp, forehead, temple or trunk where one rotation flap would be too large.",
    (
        Parameter("diameter", "diameter of the defect", "mm", 16.0, 3.0, 60.0, _BAKER),
        Parameter("arc", "length of each incision, in diameters", "", 2.0, 1.0, 5.0, _BAKER),
        Parameter("turn", "turn of each incision about its flap", "°", 100.0, 45.0, 170.0, _BAKER),
        Parameter("advance", "way of each tip, in diameters", "", 0.4, 0.1, 0.75, "what closes half the rim"),
    ),
    o_z_plasty,
    "the middle of the defect",
    "the diameter from whose ends the incisions leave",
    "",
    "S. R. Baker, Local Flaps in Facial Reconstruction (O-to-Z, double rotation).",
)
