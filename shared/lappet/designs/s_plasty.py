"""The dual S-plasty: two opposed flaps with S-shaped incisions, turned into an oval defect from either side.

The defect is an ellipse. From each end of its long axis an incision leaves along the axis and runs as an S: an arc that
turns around the flap, then a shorter one that turns back and leaves the flap a broad base. The one half of the defect's
rim is the leading edge of the first flap and the other half that of the second; the design is its own image when
turned by 180° about the middle. In the design's plane, x along the long axis::

          _____________
         /   flap 2
        |   ...
         `-Q  defect  P-.
                   ...   |
                flap 1  /
          _____________/

How it closes: `lappet.designs.opposed_flaps`.

The operation is named in N. Mitchell, C. Cutting, E. Sifakis, "GRIDiron", ACM Trans. Graph. 34 (2015), figure 4 ("a
large oval-shape defect is patched by transposing two S-shaped flaps"), without measures. The construction here is
that of opposed double rotation flaps (O to Z, O to S; S. R. Baker, "Local Flaps in Facial Reconstruction").
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import FlapDesign
from lappet.designs.flat_curves import s_curve
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.designs.opposed_flaps import opposed_flaps
from lappet.tissue.placement import Place


def dual_s_plasty(
    center: ArrayLike,
    direction: ArrayLike,
    length: float,
    width: float,
    incision: float,
    advance: float,
    turns: tuple[float, float] = (130.0, 50.0),
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design a dual S-plasty for an oval defect.

    Parameters
    ----------
    center
        Middle of the defect in mm, shape (3,).
    direction
        Direction of the oval's long axis, shape (3,).
    length
        Length of the oval in mm.
    width
        Width of the oval in mm, at most the length.
    incision
        Length of each S in mm.
    advance
        How far each tip goes along the other flap's rim in mm, at most half of the half rim.
    turns
        Angles in degrees by which the S turns around its flap, and back.
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
        If a length is not positive, the width is above the length, or the advance is too large.
    """
    require_lengths("dual_s_plasty", length=length, width=width, incision=incision, advance=advance)
    if width > length:
        raise refused(ProblemCode.DESIGN_OVAL, "dual_s_plasty", f"{width:g}", length=length)
    plane = DesignPlane.at(center, skin_axes(direction, normal, "dual_s_plasty"), mirrored, project)
    cut = np.array([0.5 * length, 0.0]) + s_curve(incision, *turns)
    pivot = np.array([-0.5 * length, -0.5 * width - 0.3 * incision])
    flap = np.array([0.1 * length, -0.5 * width - 0.25 * incision])
    return opposed_flaps("dual_s_plasty", plane, length, width, cut, advance, pivot, flap)


def _draw(center: ArrayLike, direction: ArrayLike, around: float, back: float, **given: Any) -> FlapDesign:
    return dual_s_plasty(center, direction, turns=(around, back), **given)


_BAKER = "O-to-S double rotation, after S. R. Baker, Local Flaps in Facial Reconstruction"
_FIGURE = "drawn as in N. Mitchell et al. 2015, figure 4, which gives no measures"
DUAL_S_PLASTY = LibraryDesign(
    "dual-s-plasty",
    "Dual S-plasty",
    "A large oval defect of scalp or trunk, closed by two opposed flaps with S-shaped incisions.",
    (
        Parameter("length", "length of the oval", "mm", 30.0, 6.0, 80.0, _FIGURE),
        Parameter("width", "width of the oval", "mm", 20.0, 4.0, 60.0, _FIGURE),
        Parameter("incision", "length of each S", "mm", 42.0, 10.0, 120.0, _FIGURE),
        Parameter("advance", "way of each tip along the other's rim", "mm", 12.0, 1.0, 60.0, _BAKER),
        Parameter("around", "turn of the S about its flap", "°", 130.0, 60.0, 170.0, _FIGURE),
        Parameter("back", "turn of the S back", "°", 50.0, 5.0, 90.0, _FIGURE),
    ),
    _draw,
    "the middle of the defect",
    "the long axis of the oval",
    "along",
    "N. Mitchell, C. Cutting, E. Sifakis, GRIDiron, ACM Trans. Graph. 34 (2015), figure 4; S. R. Baker, Local Flaps in "
    "Facial Reconstruction (opposed double rotation flaps).",
)
