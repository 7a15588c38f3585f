"""Two opposed rotation flaps that close an oval from either side: the O–Z, and with S-shaped incisions the dual S.

The design is its own image when turned by 180° about the middle. In its plane, x along the long axis of the oval,
flap 1 lies below the defect with its tip at the right end P, flap 2 above with its tip at the left end Q. Each tip
goes up its neighbor's half of the rim by the `advance` s, each flap slides along its own incision by as much, less
and less towards the end of the cut, and the two leading edges meet in the middle.

What meets, as lengths along the curves: the first s of flap 2's rim at P and then the outer lip of incision 1 meet
the inner lip of incision 1 (a length ratio of 1 + s / length of the incision, spread evenly, as surgeons suture it by
halves); so at Q; and the rest of one half of the rim meets the rest of the other.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.design_axes import DesignPlane
from lappet.designs.flap_design import Carry, Corner, FlapDesign, Seam
from lappet.designs.flat_curves import NICK, STEP, at_shares, length, part

# Half a turn takes what is said of flap 1 to flap 2. The upper half rim from P on is the lower one from Q turned.
FLAPS = (("first", 1.0), ("second", -1.0))


def opposed_flaps(
    what: str,
    plane: DesignPlane,
    long: float,
    wide: float,
    cut: NDArray[np.float64],
    advance: float,
    pivot: NDArray[np.float64],
    flap: NDArray[np.float64],
) -> FlapDesign:
    """Design two opposed flaps about an oval.

    Parameters
    ----------
    what
        Name of the design, for the message of an error.
    plane
        The plane of the design, its origin in the middle of the oval.
    long
        Length of the oval along x in mm.
    wide
        Width of the oval in mm.
    cut
        The incision of flap 1 from the right end of the oval on, where it leaves along x, mm, shape (k, 2).
    advance
        How far each tip goes along the other flap's rim in mm, at most half of the half rim.
    pivot
        Point about which flap 1 turns, mm, shape (2,).
    flap
        Middle of flap 1, mm, shape (2,).

    Returns
    -------
    FlapDesign
        The design.

    Raises
    ------
    RefusedError
        If the advance is too large.
    """
    rim = _half_rim(long, wide)
    whole = length(rim)
    if advance > 0.5 * whole:
        raise refused(ProblemCode.DESIGN_ADVANCE, what, f"{advance:g}", half=0.5 * whole)
    end = np.array([0.5 * long, 0.0])
    start = np.array([[0.5 * long - NICK, 0.0]])
    met = at_shares(rim, [advance / whole])[0]
    tips = [_tip(plane, name, turn, end, met, pivot) for name, turn in FLAPS]
    return FlapDesign(
        excised=(plane.excised("defect", np.vstack([rim[:-1], -rim[:-1]]), np.zeros(2)),),
        incisions=tuple(plane.points(turn * np.vstack([start, cut])) for _, turn in FLAPS),
        seams=_seams(plane, rim, cut, advance),
        corners=tuple(corner for corner, _ in tips),
        carries=tuple(carry for _, carry in tips),
        flaps=(plane.point(flap), plane.point(-flap)),
    )


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
    reached = part(rim, 0.0, advance)
    rest = part(rim, advance, length(rim))
    lip = np.vstack([-reached[::-1], cut[1:]])
    # Flap 1 lies to the right of its incision, seen from P.
    first, second = (Seam(name, (plane.edge(turn * cut, -1), plane.edge(turn * lip, 1))) for name, turn in FLAPS)
    # The middle: flap 1's leading edge from its tip at P to where flap 2's tip comes, and the other's likewise.
    lower = rest[::-1]
    return first, second, Seam("middle", (plane.edge(lower, 1), plane.edge(-lower[::-1], -1)))


def _half_rim(long: float, wide: float) -> NDArray[np.float64]:
    """The lower half of the oval from its left end Q to its right end P, points (k, 2) at equal distances."""
    turn = np.linspace(np.pi, 2.0 * np.pi, 1001)
    fine = 0.5 * np.column_stack([long * np.cos(turn), wide * np.sin(turn)])
    return at_shares(fine, np.linspace(0.0, 1.0, max(4, round(length(fine) / STEP)) + 1))
