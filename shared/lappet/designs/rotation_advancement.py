"""Millard's rotation–advancement of a unilateral cleft lip.

In the design's plane the top of the cleft T, at the nostril's floor, is the origin, and x runs down its middle. P, at
the red's border on the medial side, is the peak of Cupid's bow that stands too high (Millard's 3), Q its partner on the
lateral side (8). What lies between T, P, Q and the red below them, down to R, is pared away: skin between the margins,
and the red that lines them.

From T the rotation incision runs below the base of the columella to E (5): below it lies flap A, the philtrum with
Cupid's bow, which turns down about E. The other incision runs from T below the ala to N (10): between it and the
lateral margin lies flap B. It is advanced: its tip, at T, comes into the gap that A has left, to E. Then B's margin T Q
is sewn to A's edge E T P, its upper edge T N to the upper lip E T N of both incisions, P to Q, and the red below them.

All is cut through the lip from its front, square to the plane through T, P and Q: on the rolled border of the red a
blade square to the skin would not part the lip.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import Carry, Corner, Edge, Excised, FlapDesign, Seam
from lappet.designs.flat_curves import NICK, segment
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.procedure import Point
from lappet.tissue.placement import Place

TURN = np.radians(50.0)  # from a margin to the incision beside it
LIFT = 0.3  # of the height to which flaps are lifted: these are turned in their plane
_STEP = 0.5  # mm from point to point
_NAME = "millard"


def rotation_advancement(
    center: ArrayLike,
    direction: ArrayLike,
    medial: float = 10.0,
    lateral: float = 12.0,
    gap: float = 9.0,
    rotation: float = 4.5,
    ala: float = 10.0,
    drop: float = 2.5,
    red: float = 7.0,
    narrowing: float = 1.0,
    blade_turn: float = 0.0,
    blade_lift: float = 0.0,
    undermined: float = 0.4,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design a rotation–advancement.

    Parameters
    ----------
    center
        Top of the cleft, at the nostril's floor, in mm, shape (3,).
    direction
        Direction down the middle of the cleft, shape (3,).
    medial
        Length of the medial margin, from the top to the peak of Cupid's bow, in mm.
    lateral
        Length of the lateral margin, from the top to where the red is sewn to the peak, in mm.
    gap
        Distance of the two ends of the margins in mm.
    rotation
        Length of the rotation incision below the columella in mm.
    ala
        Length of the incision below the ala in mm.
    drop
        How far the hook turns the peak of Cupid's bow down in mm.
    red
        How far below P and Q the cuts through the red end, in mm.
    narrowing
        How far the two cuts through the red come together on their way, as a share of the gap: 1 where they meet in a
        point, 0 where they are parallel and the notch of the lip lies between them.
    blade_turn
        By how much the blade is turned about the middle of the cleft from the square to the plane through the margins,
        towards the lateral margin as it goes in, in degrees.
    blade_lift
        By how much the blade is turned up as it goes in, in degrees: away from the other lip.
    undermined
        How far around the cuts the skin is undermined, as a share of what is usual.
    normal
        Outwards from the skin at the top, shape (3,).
    mirrored
        Whether the cleft is on the right: the lateral side lies to the right of the direction as one looks at it.
    project
        Maps points (k, 3) onto a curved skin, as `draped_on` gives, or None.

    Returns
    -------
    FlapDesign
        The design.

    Raises
    ------
    RefusedError
        If a length is not positive, or no triangle has these margins and this gap.
    """
    measures = {"medial": medial, "lateral": lateral, "gap": gap, "rotation": rotation, "ala": ala, "red": red}
    require_lengths(_NAME, **measures)
    if not abs(medial - lateral) < 0.9 * gap < 0.81 * (medial + lateral):
        possible = f"{abs(medial - lateral) / 0.9:.3g} to {0.9 * (medial + lateral):.3g} mm"
        raise refused(ProblemCode.DESIGN_RANGE, _NAME, f"{gap:g}", name="gap", range=possible)
    plane = DesignPlane.at(center, skin_axes(direction, normal, _NAME), mirrored, project)
    half = 0.5 * np.arccos((medial**2 + lateral**2 - gap**2) / (2.0 * medial * lateral))
    p, q = medial * _at(-half), lateral * _at(half)
    e, n = rotation * _at(-half - TURN), ala * _at(half + TURN)
    ends = {"p": p, "q": q, "e": e, "n": n}
    a, b, above = 0.5 * (p + e), 0.5 * (q + n), np.array([-0.5 * rotation, 0.0])
    side = {name: segment(np.zeros(2), end, _STEP) for name, end in ends.items()}
    medial_side, lateral_side = plane.points(side["p"]), plane.points(side["q"])
    front = _Front.through(medial_side[0], medial_side[-1], lateral_side[-1], mirrored)
    reds = tuple(front.red(margin[-1], red, narrowing) for margin in (lateral_side, medial_side))
    far = reds[0][:0:-1] if narrowing < 1.0 else reds[0][-2:0:-1]
    outline = (*medial_side[:-1], *reds[1], *far, *lateral_side[:0:-1])
    left = -1 if mirrored else 1
    from_e = side["e"][::-1]
    lay = e + _turned(p - e, -drop / float(np.linalg.norm(p - e)))
    return FlapDesign(
        (Excised("cleft", outline[::-1] if mirrored else outline, plane.point((2.0, 0.0))),),
        tuple(plane.points(np.vstack([[(NICK, 0.0)], side[name]])) for name in "en"),
        (
            Seam("lip", (plane.edge(side["q"], 1), plane.edge(np.vstack([from_e, side["p"][1:]]), -1))),
            Seam("sill", (plane.edge(side["n"], -1), plane.edge(np.vstack([from_e, side["n"][1:]]), 1))),
            Seam("red", (Edge(reds[0], left), Edge(reds[1], -left))),
        ),
        (
            Corner("tip", plane.spot((0.0, 0.0), b), plane.spot(e, e + above)),
            Corner("bow", plane.spot(q, b), plane.spot(p, a)),
        ),
        (
            Carry("rotation", plane.spot(p, a), plane.point(e), plane.spot(lay, a), LIFT),
            Carry("advancement", plane.spot((0.0, 0.0), b), None, plane.spot(e, e + above), LIFT),
        ),
        (plane.point(a), plane.point(b)),
        undermined=undermined,
        blade=front.blade(-blade_turn if mirrored else blade_turn, blade_lift),
    )


class _Front:
    """The plane through the top of the cleft and the ends of its margins, mm."""

    def __init__(self, into: Point, down: NDArray[np.float64], middle: NDArray[np.float64]) -> None:
        self.into, self._down, self._middle = into, down, middle

    @classmethod
    def through(cls, top: Point, p: Point, q: Point, mirrored: bool) -> _Front:
        corner, middle = np.array(top), 0.5 * (np.array(p) + np.array(q))
        out = np.cross(p - corner, q - corner)
        x, y, z = (out if mirrored else -out) / np.linalg.norm(out)
        return cls((float(x), float(y), float(z)), (middle - corner) / np.linalg.norm(middle - corner), middle)

    def red(self, start: Point, long: float, narrowing: float) -> tuple[Point, ...]:
        """The way through the red from the end of a margin down, and towards the middle by a share of the way there."""
        whole = long * self._down + narrowing * (self._middle - start)
        count = max(2, round(float(np.linalg.norm(whole)) / _STEP))
        line = start + np.linspace(0.0, 1.0, count + 1)[:, None] * whole
        return tuple((float(x), float(y), float(z)) for x, y, z in line)

    def blade(self, turn: float, lift: float) -> Point:
        """The direction of a blade that is turned about the way down, and up, by so many degrees."""
        into, (aside, up) = np.array(self.into), np.radians((turn, lift))
        level = np.cos(aside) * into + np.sin(aside) * np.cross(self._down, into)
        x, y, z = np.cos(up) * level - np.sin(up) * self._down
        return float(x), float(y), float(z)


def _at(angle: float) -> NDArray[np.float64]:
    return np.array([np.cos(angle), np.sin(angle)])


def _turned(point: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]) @ point


_DRAWN = "chosen: what fits the lip of `lappet models` with a cleft"
_MILLARD = "D. R. Millard, Plast. Reconstr. Surg. 25 (1960) 595"
MILLARD = LibraryDesign(
    _NAME,
    "Rotation–advancement (Millard)",
    "A unilateral cleft of the upper lip: Cupid's bow is turned down, the lateral lip advanced into the gap.",
    (
        Parameter("medial", "length of the medial margin", "mm", 10.0, 4.0, 16.0, _DRAWN),
        Parameter("lateral", "length of the lateral margin", "mm", 12.0, 4.0, 18.0, _DRAWN),
        Parameter("gap", "distance of the margins' ends, laid flat", "mm", 9.0, 2.0, 20.0, _DRAWN),
        Parameter("rotation", "length of the incision below the columella", "mm", 4.5, 2.0, 12.0, _DRAWN),
        Parameter("ala", "length of the incision below the ala", "mm", 10.0, 3.0, 16.0, _DRAWN),
        Parameter("drop", "how far the peak of Cupid's bow is turned down", "mm", 2.5, 0.5, 6.0, _DRAWN),
        Parameter("red", "height of what is pared of the red", "mm", 7.0, 2.0, 14.0, _DRAWN),
        Parameter(
            "narrowing",
            "how far the cuts through the red come together",
            "",
            1.0,
            -0.5,
            1.0,
            "1: in a point; 0: not at all, where the lip is notched",
        ),
        Parameter("blade_turn", "turn of the blade to the lateral margin", "°", 0.0, -40.0, 40.0, _DRAWN),
        Parameter("blade_lift", "turn of the blade away from the other lip", "°", 0.0, -40.0, 40.0, _DRAWN),
        Parameter("undermined", "undermining, of the usual", "", 0.4, 0.0, 1.0, "0 for a lip free on its mucosa"),
    ),
    rotation_advancement,
    "the top of the cleft, at the nostril's floor",
    "down the middle of the cleft",
    "",
    "After " + _MILLARD + " (not read), as textbooks draw it, without the C flap and the back-cut.",
)
