"""The fusiform excision closed in a straight line, and the same bent along an S, which breaks up a long scar.

The fusiform's two arcs are circular (`lappet.designs.fusiform_design`). The S-excision has the same width at every
station along a middle line that is an S: a sine with its ends on the axis.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import FlapDesign, Seam
from lappet.designs.flat_curves import length as length_of
from lappet.designs.flat_curves import part
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.tissue.placement import Place


def fusiform_excision(
    center: ArrayLike,
    direction: ArrayLike,
    length: float,
    width: float,
    swing: float = 0.0,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design a fusiform excision, straight or bent along an S.

    Parameters
    ----------
    center
        Middle of the excision in mm, shape (3,).
    direction
        Direction of the long axis, shape (3,).
    length
        Length from tip to tip along the axis in mm.
    width
        Width in mm, at most the length.
    swing
        How far the middle line leaves the axis to either side in mm; 0 for a straight excision.
    normal
        Outwards from the skin at the middle, shape (3,).
    mirrored
        Whether the S is the other way round.
    project
        Maps points (k, 3) onto a curved skin, as `draped_on` gives, or None.

    Returns
    -------
    FlapDesign
        The design; it has no flap.

    Raises
    ------
    RefusedError
        If a length is not positive or the width is above the length.
    """
    require_lengths("fusiform", length=length, width=width)
    if width > length:
        raise refused(ProblemCode.DESIGN_OVAL, "fusiform", f"{width:g}", length=length)
    plane = DesignPlane.at(center, skin_axes(direction, normal, "fusiform"), mirrored, project)
    lower, upper = (_side(length, width, swing, side) for side in (-1.0, 1.0))
    around = np.vstack([lower[:-1], upper[:0:-1]])
    seam = Seam("closure", (plane.edge(lower, -1), plane.edge(upper, 1)))
    return FlapDesign((plane.excised("defect", around, np.zeros(2)),), (), (seam,))


def _side(length: float, width: float, swing: float, side: float) -> NDArray[np.float64]:
    """One side of the excision from its left to its right tip, points (k, 2)."""
    radius = (length**2 + width**2) / (4.0 * width)
    x = np.linspace(-0.5 * length, 0.5 * length, 801)
    half = np.sqrt(np.maximum(radius**2 - x**2, 0.0)) - (radius - 0.5 * width)
    middle = swing * np.sin(2.0 * np.pi * x / length)
    slope = swing * 2.0 * np.pi / length * np.cos(2.0 * np.pi * x / length)
    across = np.column_stack([-slope, np.ones_like(x)]) / np.sqrt(1.0 + slope**2)[:, None]
    fine = np.column_stack([x, middle]) + side * half[:, None] * across
    return part(fine, 0.0, length_of(fine))


_ELLIPSE = "length to width 3:1, for tips of 30° (B. R. Moody et al., Dermatol. Surg. 27 (2001) 61)"
_MEASURES = (
    Parameter("length", "length from tip to tip", "mm", 36.0, 4.0, 150.0, _ELLIPSE),
    Parameter("width", "width", "mm", 12.0, 2.0, 60.0, _ELLIPSE),
)
_SOURCES = (
    "B. R. Moody, J. E. McCarthy, R. D. Sengelmann, The apical angle: a mathematical analysis of the ellipse, "
    "Dermatol. Surg. 27 (2001) 61; A. F. Borges, Elective Incisions and Scar Revision (1973)."
)
FUSIFORM = LibraryDesign(
    "fusiform",
    "Fusiform excision",
    "A small lesion, closed in a straight line along the lines of the skin.",
    _MEASURES,
    fusiform_excision,
    "the middle of the excision",
    "the long axis",
    "along",
    _SOURCES,
)
S_EXCISION = LibraryDesign(
    "s-excision",
    "S-shaped excision",
    "A lesion over a convex surface or across a joint, where a straight scar would contract or dent.",
    (
        *_MEASURES,
        Parameter("swing", "how far the middle line leaves the axis", "mm", 4.0, 0.0, 30.0, "Borges 1973: a lazy S"),
    ),
    fusiform_excision,
    "the middle of the excision",
    "the long axis",
    "along",
    _SOURCES,
)
