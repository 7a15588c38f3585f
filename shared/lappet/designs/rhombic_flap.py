r"""Rhombic transposition flaps: Limberg's, and Dufourmentel and Mouly's.

The defect is a rhombus with sides a and the acute angle α at the ends A and C of its long diagonal; B and D are the
ends of the short one. The flap has the corners C, D, E, F: the first limb DE begins at the defect's obtuse corner D,
the second, EF, ends beside C, and CF is its base. In the design's plane, x along the short diagonal from B to D::

            A
          /   \                Limberg (α = 60°): DE extends the short diagonal, EF is parallel to DC; |DE| = |EF| = a.
        B       D --- E        Turned by 60° about C the flap covers the defect: D comes to B, E to A, F to D.
          \   /      /        Dufourmentel: DE halves the angle between the extended short diagonal and the extended
            C ... F            side CD, EF is parallel to the long diagonal; |DE| = |EF| = a.

The donor site closes by drawing the corner that DE leaves outside of the flap, D', to F.

Sources: A. A. Limberg, "The planning of local plastic operations on the body surface" (1963, English 1984);
C. Dufourmentel, "La fermeture des pertes de substance cutanée limitées", Ann. Chir. Plast. 7 (1962) 61; G. D. Lister
and T. Gibson, "Closure of rhomboid skin defects: the flaps of Limberg and Dufourmentel", Br. J. Plast. Surg. 25 (1972)
300.
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import Carry, Corner, Edge, FlapDesign, Seam, Spot
from lappet.designs.flat_curves import NICK, segment
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.tissue.placement import Place

STEP = 1.5  # mm between the points of a side, so that it follows a curved skin


def limberg(
    center: ArrayLike,
    direction: ArrayLike,
    side: float,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
    at_defect: bool = False,
) -> FlapDesign:
    """Design Limberg's flap for a rhombus of 60° and 120°.

    Parameters
    ----------
    center
        Middle of the defect and its flap together in mm, shape (3,).
    direction
        Direction along the short diagonal, from the defect to the flap, shape (3,).
    side
        Side of the rhombus in mm.
    normal
        Outwards from the skin at the middle, shape (3,).
    mirrored
        Whether the second limb is on the other side.
    project
        Maps points (k, 3) onto a curved skin, as `draped_on` gives, or None.
    at_defect
        Whether the center is the defect's alone.

    Returns
    -------
    FlapDesign
        The design.

    Raises
    ------
    RefusedError
        If the side is not positive.
    """
    return _rhombic("limberg", center, direction, side, 60.0, (0.0, 240.0), normal, mirrored, project, at_defect)


def dufourmentel(
    center: ArrayLike,
    direction: ArrayLike,
    side: float,
    angle: float = 75.0,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
    at_defect: bool = False,
) -> FlapDesign:
    """Design Dufourmentel and Mouly's flap for a rhombus.

    The first limb leaves the short diagonal by 45° - angle / 4; the flap's tip has the angle 45° + angle / 4.

    Parameters
    ----------
    center
        Middle of the defect and its flap together in mm, shape (3,).
    direction
        Direction along the short diagonal, from the defect to the flap, shape (3,).
    side
        Side of the rhombus in mm.
    angle
        Acute angle of the rhombus in degrees, 60 to 90.
    normal
        Outwards from the skin at the middle, shape (3,).
    mirrored
        Whether the second limb is on the other side.
    project
        Maps points (k, 3) onto a curved skin, as `draped_on` gives, or None.
    at_defect
        Whether the center is the defect's alone.

    Returns
    -------
    FlapDesign
        The design.

    Raises
    ------
    RefusedError
        If the side is not positive or the angle is out of range.
    """
    if not 60.0 <= angle <= 90.0:
        raise refused(ProblemCode.DESIGN_ANGLE, "dufourmentel", f"{angle:g}", least=60, most=90)
    limbs = (45.0 - angle / 4.0, 270.0)
    return _rhombic("dufourmentel", center, direction, side, angle, limbs, normal, mirrored, project, at_defect)


def _rhombic(
    what: str,
    center: ArrayLike,
    direction: ArrayLike,
    side: float,
    angle: float,
    limbs: tuple[float, float],
    normal: ArrayLike,
    mirrored: bool,
    project: Place | None,
    at_defect: bool,
) -> FlapDesign:
    """The design whose limbs run at these angles (degrees) to the short diagonal."""
    require_lengths(what, side=side)
    shape = _Shape.drawn(side, angle, limbs)
    corners = np.stack([shape.a, shape.b, shape.c, shape.d, shape.e, shape.f])
    middle = np.zeros(2) if at_defect else 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    plane = DesignPlane.at(center, skin_axes(direction, normal, what), mirrored, project, middle)
    a, b, c, d = shape.a, shape.b, shape.c, shape.d
    outline = [segment(p, q, STEP)[:-1] for p, q in ((a, b), (b, c), (c, d), (d, a))]
    into = d - NICK * shape.first / side
    incision = np.vstack([into[None], segment(d, shape.e, STEP)[:-1], segment(shape.e, shape.f, STEP)])
    pairs, carries = _moves(plane, shape, side)
    return FlapDesign(
        excised=(plane.excised("defect", np.vstack(outline), np.zeros(2)),),
        incisions=(plane.points(incision),),
        seams=_seams(plane, shape, side),
        corners=pairs,
        carries=carries,
        flaps=(plane.point(shape.flap),),
    )


class _Shape(NamedTuple):
    """The corners of the rhombus and its flap, and the limbs DE and EF, in the design's plane: mm, shape (2,)."""

    a: NDArray[np.float64]
    b: NDArray[np.float64]
    c: NDArray[np.float64]
    d: NDArray[np.float64]
    e: NDArray[np.float64]
    f: NDArray[np.float64]
    first: NDArray[np.float64]
    second: NDArray[np.float64]

    @classmethod
    def drawn(cls, side: float, angle: float, limbs: tuple[float, float]) -> _Shape:
        """The shape with these angles in degrees: the rhombus's acute one, those of the limbs to the short diagonal."""
        half = np.radians(angle) / 2.0
        a, c = side * np.array([0.0, np.cos(half)]), side * np.array([0.0, -np.cos(half)])
        b, d = side * np.array([-np.sin(half), 0.0]), side * np.array([np.sin(half), 0.0])
        first, second = (side * np.array([np.cos(t), np.sin(t)]) for t in np.radians(limbs))
        return cls(a, b, c, d, d + first, d + first + second, first, second)

    @property
    def flap(self) -> NDArray[np.float64]:
        """The middle of the flap."""
        return (self.c + self.d + self.e + self.f) / 4.0


def _seams(plane: DesignPlane, shape: _Shape, side: float) -> tuple[Seam, ...]:
    """The edges that are sewn together: those of the donor site, and the flap's with the rhombus's."""
    a, b, c, d, e, f, _, _ = shape
    away = 4.0 * side

    def edge(start: NDArray[np.float64], end: NDArray[np.float64], tissue: NDArray[np.float64]) -> Edge:
        return plane.edge_beside(segment(start, end, STEP), tissue)

    above, below, right = np.array([0.0, away]), np.array([0.0, -away]), np.array([away, 0.0])
    return (
        Seam("donor", (edge(e, d, above), edge(e, f, e + right))),
        Seam("near", (edge(c, d, shape.flap), edge(c, b, below))),
        Seam("far", (edge(d, e, shape.flap), edge(b, a, above))),
        Seam("end", (edge(e, f, shape.flap), edge(a, d, above))),
    )


def _moves(plane: DesignPlane, shape: _Shape, side: float) -> tuple[tuple[Corner, ...], tuple[Carry, ...]]:
    """The corners that meet, and how hooks carry the flap there, about C."""
    a, b, c, d, e, f, _, second = shape
    outwards = (a + e - 2.0 * d) / np.linalg.norm(a + e - 2.0 * d) * side  # halves the corner D' outside of the flap
    flap_d, flap_e = plane.spot(d, shape.flap), plane.spot(e, shape.flap)
    wound_a, wound_b = plane.spot(a, 2.0 * a), plane.spot(b, 2.0 * b)
    pivot, inside = plane.point(c), plane.point(np.zeros(2))
    corners = (
        Corner("donor", plane.spot(d, d + outwards), plane.spot(f, f + second)),
        Corner("shoulder", flap_d, wound_b),
        Corner("tip", flap_e, wound_a),
    )
    carries = (
        Carry("tip", flap_e, pivot, Spot(wound_a.point, inside)),
        Carry("shoulder", flap_d, pivot, Spot(wound_b.point, inside)),
    )
    return corners, carries


_LISTER = "Lister and Gibson 1972"
LIMBERG = LibraryDesign(
    "limberg",
    "Limberg flap",
    "A rhombic defect of cheek, temple, trunk or limb, closed by a transposition flap with angles of 60° and 120°.",
    (
        Parameter(
            "side", "side of the rhombus", "mm", 18.0, 4.0, 60.0, "Limberg 1963: any; the skin's laxity limits it"
        ),
    ),
    partial(limberg, at_defect=True),
    "the middle of the defect",
    "the short diagonal, from the defect to the flap",
    "",
    "A. A. Limberg, The planning of local plastic operations on the body surface (1963); G. D. Lister and T. Gibson, "
    "Br. J. Plast. Surg. 25 (1972) 300.",
)
DUFOURMENTEL = LibraryDesign(
    "dufourmentel",
    "Dufourmentel flap",
    "A rhombic defect of 60° to 90°, closed by a flap that turns less, on a broader base, than Limberg's.",
    (
        Parameter("side", "side of the rhombus", "mm", 17.0, 4.0, 60.0, _LISTER),
        Parameter("angle", "acute angle of the rhombus", "°", 75.0, 60.0, 90.0, _LISTER),
    ),
    partial(dufourmentel, at_defect=True),
    "the middle of the defect",
    "the short diagonal, from the defect to the flap",
    "",
    "C. Dufourmentel, Ann. Chir. Plast. 7 (1962) 61; G. D. Lister and T. Gibson, Br. J. Plast. Surg. 25 (1972) 300.",
)
