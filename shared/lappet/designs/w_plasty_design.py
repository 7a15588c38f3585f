"""The W-plasty: a scar is cut out with a zigzag on either side, whose teeth interlock when they are drawn together.

Both zigzags are the same line, moved across the scar by its width, so that every tooth fits a notch. At the ends two
straight sides run from the middle of the zigzags to a tip.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import FlapDesign, Seam
from lappet.designs.flat_curves import polyline
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.tissue.placement import Place


def w_plasty(
    center: ArrayLike,
    direction: ArrayLike,
    length: float,
    width: float,
    side: float = 6.0,
    angle: float = 60.0,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design a W-plasty.

    Parameters
    ----------
    center
        Middle of the scar in mm, shape (3,).
    direction
        Direction of the scar, shape (3,).
    length
        Length of the scar in mm; the teeth fill it as often as they go.
    width
        Width of what is cut out, measured across the scar, in mm.
    side
        Side of a tooth in mm.
    angle
        Angle of a tooth in degrees.
    normal
        Outwards from the skin at the middle, shape (3,).
    mirrored
        Whether the zigzags begin the other way.
    project
        Maps points (k, 3) onto a curved skin, as `draped_on` gives, or None.

    Returns
    -------
    FlapDesign
        The design; it has no flap.

    Raises
    ------
    RefusedError
        If a length is not positive, or not even one tooth fits into the length.
    """
    require_lengths("w_plasty", length=length, width=width, side=side, angle=angle)
    half = np.radians(0.5 * angle)
    base, height = 2.0 * side * np.sin(half), side * np.cos(half)
    teeth = int(length / base + 1e-9)
    if teeth < 1:
        raise refused(ProblemCode.DESIGN_TEETH, "w_plasty", f"{length:g}", base=base)
    plane = DesignPlane.at(center, skin_axes(direction, normal, "w_plasty"), mirrored, project)
    lower, upper = (_zigzag(teeth, base, height, shift, width) for shift in (-0.5 * width, 0.5 * width))
    around = np.vstack([lower[:-1], upper[:0:-1]])
    seam = Seam("closure", (plane.edge(lower, -1), plane.edge(upper, 1)))
    return FlapDesign((plane.excised("defect", around, np.zeros(2)),), (), (seam,))


def _zigzag(teeth: int, base: float, height: float, shift: float, width: float) -> NDArray[np.float64]:
    """A zigzag from tip to tip, its middle moved by `shift`, points (k, 2)."""
    end = 0.5 * teeth * base
    corners = [np.array([-end - width, 0.0]), np.array([-end, shift])]
    for k in range(teeth):
        start = -end + k * base
        corners += [np.array([start + part * base, shift + up * 0.5 * height]) for part, up in ((0.25, 1), (0.75, -1))]
    corners += [np.array([end, shift]), np.array([end + width, 0.0])]
    return polyline(*corners)


_BORGES = (
    "A. F. Borges, Improvement of antitension-lines scar by the W-plastic operation, Br. J. Plast. Surg. 12 (1959) 29"
)
W_PLASTY = LibraryDesign(
    "w-plasty",
    "W-plasty",
    "A long straight scar across the lines of the skin, broken up into a zigzag.",
    (
        Parameter("length", "length of the scar", "mm", 42.0, 6.0, 150.0, _BORGES),
        Parameter("width", "width of what is cut out", "mm", 8.0, 2.0, 30.0, "what clears the scar"),
        Parameter("side", "side of a tooth", "mm", 6.0, 3.0, 12.0, "5 to 6 mm in the face: " + _BORGES),
        Parameter("angle", "angle of a tooth", "°", 60.0, 45.0, 100.0, _BORGES),
    ),
    w_plasty,
    "the middle of the scar",
    "the scar",
    "across",
    _BORGES + ".",
)
