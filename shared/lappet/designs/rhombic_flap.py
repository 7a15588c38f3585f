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

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.design_axes import placed_on, skin_axes
from lappet.designs.flap_design import Carry, Corner, Edge, FlapDesign, Seam, Spot
from lappet.procedure import Point
from lappet.tissue.placement import Place

STEP = 1.5  # mm between the points of a side, so that it follows a curved skin
NICK = 0.3  # mm by which the first limb begins inside the defect


def limberg(
    center: ArrayLike,
    direction: ArrayLike,
    side: float,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
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

    Returns
    -------
    FlapDesign
        The design.

    Raises
    ------
    RefusedError
        If the side is not positive.
    """
    return _rhombic("limberg", center, direction, side, 60.0, (0.0, 240.0), normal, mirrored, project)


def dufourmentel(
    center: ArrayLike,
    direction: ArrayLike,
    side: float,
    angle: float = 75.0,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
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
    return _rhombic("dufourmentel", center, direction, side, angle, limbs, normal, mirrored, project)


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
) -> FlapDesign:
    """The design whose limbs run at these angles (degrees) to the short diagonal."""
    if not (np.isfinite(side) and side > 0.0):
        raise refused(ProblemCode.LENGTH_NOT_POSITIVE, what, f"{side:g}", name="side")
    half = np.radians(angle) / 2.0
    a, c = side * np.array([0.0, np.cos(half)]), side * np.array([0.0, -np.cos(half)])
    b, d = side * np.array([-np.sin(half), 0.0]), side * np.array([np.sin(half), 0.0])
    first, second = (side * np.array([np.cos(t), np.sin(t)]) for t in np.radians(limbs))
    e, f = d + first, d + first + second
    corners = np.stack([a, b, c, d, e, f])
    middle = 0.5 * (corners.min(axis=0) + corners.max(axis=0))

    along, across = skin_axes(direction, normal, what)
    if mirrored:
        across = -across
    origin = np.asarray(center, np.float64)

    def put(flat: NDArray[np.float64]) -> tuple[Point, ...]:
        """Points (k, 2) of the design's plane on the skin."""
        xy = flat - middle
        return placed_on(origin + xy[:, :1] * along + xy[:, 1:] * across, project)

    def one(flat: NDArray[np.float64]) -> Point:
        return put(flat[None])[0]

    def edge(start: NDArray[np.float64], end: NDArray[np.float64], tissue: NDArray[np.float64]) -> Edge:
        """The straight edge from start to end whose tissue lies where `tissue` does."""
        run, beside = end - start, tissue - start
        left = run[0] * beside[1] - run[1] * beside[0] > 0.0
        return Edge(put(_sampled(start, end)), 1 if left != mirrored else -1)

    flap, away = (c + d + e + f) / 4.0, 4.0 * side
    above, below, right = np.array([0.0, away]), np.array([0.0, -away]), np.array([away, 0.0])
    seams = (
        Seam("donor", (edge(e, d, above), edge(e, f, e + right)), (True, False)),
        Seam("near", (edge(c, d, flap), edge(c, b, below)), (True, False)),
        Seam("far", (edge(d, e, flap), edge(b, a, above)), (False, False)),
        Seam("end", (edge(e, f, flap), edge(a, d, above)), (False, False)),
    )
    outwards = (a + e - 2.0 * d) / np.linalg.norm(a + e - 2.0 * d) * side  # halves the corner D' outside of the flap
    flap_d, flap_e = Spot(one(d), one(flap)), Spot(one(e), one(flap))
    wound_a, wound_b = Spot(one(a), one(2.0 * a)), Spot(one(b), one(2.0 * b))
    outline = [_sampled(p, q)[:-1] for p, q in ((a, b), (b, c), (c, d), (d, a))]
    into = d - NICK * first / side
    incision = put(np.vstack([into[None], _sampled(d, e)[:-1], _sampled(e, f)]))
    defect = put(np.vstack(outline))
    return FlapDesign(
        defect=defect[::-1] if mirrored else defect,
        seed=one(np.zeros(2)),
        incisions=(incision,),
        seams=seams,
        corners=(
            Corner("donor", Spot(one(d), one(d + outwards)), Spot(one(f), one(f + second))),
            Corner("shoulder", flap_d, wound_b),
            Corner("tip", flap_e, wound_a),
        ),
        carries=(
            Carry("tip", flap_e, one(c), Spot(wound_a.point, one(np.zeros(2)))),
            Carry("shoulder", flap_d, one(c), Spot(wound_b.point, one(np.zeros(2)))),
        ),
        flaps=(one(flap),),
    )


def _sampled(start: NDArray[np.float64], end: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points (k, 2) from start to end, both included."""
    count = max(1, round(float(np.linalg.norm(end - start)) / STEP))
    return start + np.linspace(0.0, 1.0, count + 1)[:, None] * (end - start)
