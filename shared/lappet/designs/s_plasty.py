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

Flap 1 lies below the defect, its tip at the right end P; flap 2 above, its tip at the left end Q. Each tip goes up its
neighbor's half of the rim by the `advance` s, each flap slides along its own incision by as much, less and less
towards the end of the cut, and the two leading edges meet in the middle.

What meets, as lengths along the curves: the first s of flap 2's rim at P and then the outer lip of incision 1 meet the
inner lip of incision 1 (a length ratio of 1 + s / length of the incision, spread evenly, as surgeons suture it by
halves); so at Q; and the rest of one half of the rim meets the rest of the other.

The operation is named in N. Mitchell, C. Cutting, E. Sifakis, "GRIDiron", ACM Trans. Graph. 34 (2015), figure 4 ("a
large oval-shape defect is patched by transposing two S-shaped flaps"), without measures. The construction here is
that of opposed double rotation flaps (O to Z, O to S; S. R. Baker, "Local Flaps in Facial Reconstruction").
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.design_axes import DesignPlane, skin_axes
from lappet.designs.flap_design import Carry, Corner, FlapDesign, Seam
from lappet.tissue.placement import Place

STEP = 1.0  # mm between the points of a curve
NICK = 0.3  # mm by which an incision begins inside the defect
# Half a turn takes what is said of flap 1 to flap 2. The upper half rim from P on is the lower one from Q turned.
FLAPS = (("first", 1.0), ("second", -1.0))


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
    _refuse_lengths(length=length, width=width, incision=incision, advance=advance)
    if width > length:
        raise refused(ProblemCode.DESIGN_OVAL, "dual_s_plasty", f"{width:g}", length=length)
    rim = _half_rim(length, width)
    whole = _length(rim)
    if advance > 0.5 * whole:
        raise refused(ProblemCode.DESIGN_ADVANCE, "dual_s_plasty", f"{advance:g}", half=0.5 * whole)
    plane = DesignPlane.at(center, skin_axes(direction, normal, "dual_s_plasty"), mirrored, project)
    end = np.array([0.5 * length, 0.0])
    cut = end + _s_curve(incision, *turns)
    pivot = np.array([-0.5 * length, -0.5 * width - 0.3 * incision])
    flap = np.array([0.1 * length, -0.5 * width - 0.25 * incision])
    start = np.array([[0.5 * length - NICK, 0.0]])
    met = _at(rim, np.array([advance / whole]))[0]
    tips = [_tip(plane, name, turn, end, met, pivot) for name, turn in FLAPS]
    return FlapDesign(
        defect=plane.outline(np.vstack([rim[:-1], -rim[:-1]])),
        seed=plane.point(np.zeros(2)),
        incisions=tuple(plane.points(turn * np.vstack([start, cut])) for _, turn in FLAPS),
        seams=_seams(plane, rim, cut, advance),
        corners=tuple(corner for corner, _ in tips),
        carries=tuple(carry for _, carry in tips),
        flaps=(plane.point(flap), plane.point(-flap)),
    )


def _refuse_lengths(**lengths: float) -> None:
    """Refuse lengths that are not positive, by their names."""
    for name, value in lengths.items():
        if not (np.isfinite(value) and value > 0.0):
            raise refused(ProblemCode.LENGTH_NOT_POSITIVE, "dual_s_plasty", f"{value:g}", name=name)


def _tip(
    plane: DesignPlane,
    name: str,
    turn: float,
    end: NDArray[np.float64],
    met: NDArray[np.float64],
    pivot: NDArray[np.float64],
) -> tuple[Corner, Carry]:
    """Where the tip of a flap goes, and how: from the end of the oval to the point `met` turned onto the other half."""
    tip, tissue = turn * end, turn * (end + np.array([3.0, -3.0]))
    there = -turn * met
    middle = 0.5 * (there + tip)
    corner = plane.spot(tip, tissue)
    lay = plane.spot(middle, middle + tissue - tip)
    return Corner(name, corner, plane.spot(there, there * 1.4)), Carry(name, corner, plane.point(turn * pivot), lay)


def _seams(
    plane: DesignPlane, rim: NDArray[np.float64], cut: NDArray[np.float64], advance: float
) -> tuple[Seam, Seam, Seam]:
    """The seam along each incision and the one in the middle; `rim` is the lower half, from Q on."""
    whole = _length(rim)
    reached = _at(rim, np.linspace(0.0, advance, max(2, round(advance / STEP)) + 1) / whole)
    rest = _at(rim, np.linspace(advance / whole, 1.0, max(2, round((whole - advance) / STEP)) + 1))
    lip = np.vstack([-reached[::-1], cut[1:]])
    # Flap 1 lies to the right of its incision, seen from P.
    first, second = (
        Seam(name, (plane.edge(turn * cut, -1), plane.edge(turn * lip, 1)), (False, True)) for name, turn in FLAPS
    )
    # The middle: flap 1's leading edge from its tip at P to where flap 2's tip comes, and the other's likewise.
    lower = rest[::-1]
    return first, second, Seam("middle", (plane.edge(lower, 1), plane.edge(-lower[::-1], -1)), (False, False))


def _half_rim(length: float, width: float) -> NDArray[np.float64]:
    """The lower half of the oval from its left end Q to its right end P, points (k, 2) at equal distances."""
    turn = np.linspace(np.pi, 2.0 * np.pi, 1001)
    fine = 0.5 * np.column_stack([length * np.cos(turn), width * np.sin(turn)])
    return _at(fine, np.linspace(0.0, 1.0, max(4, round(_length(fine) / STEP)) + 1))


def _s_curve(length: float, around: float, back: float) -> NDArray[np.float64]:
    """An S from (0, 0) that leaves along x: it turns right by `around` degrees, then left by `back`, points (k, 2).

    Both arcs have the curvature that makes the length; curvature changes over evenly in the middle tenth.
    """
    count = max(8, round(length / STEP))
    fine = np.linspace(0.0, 1.0, 40 * count + 1)
    first = around / (around + back)
    curvature = np.interp(fine, [0.0, first - 0.05, first + 0.05, 1.0], [-1.0, -1.0, 1.0, 1.0])
    heading = np.cumsum(curvature) / len(fine) * np.radians(around + back)
    step = length / (40 * count) * np.column_stack([np.cos(heading), np.sin(heading)])
    return np.vstack([np.zeros((1, 2)), np.cumsum(step, axis=0)[39::40]])


def _at(curve: NDArray[np.float64], shares: NDArray[np.float64]) -> NDArray[np.float64]:
    """The points (k, 2) at these shares of a polyline's length."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))])
    return np.column_stack([np.interp(shares * along[-1], along, curve[:, k]) for k in range(2)])


def _length(curve: NDArray[np.float64]) -> float:
    return float(np.linalg.norm(np.diff(curve, axis=0), axis=1).sum())
