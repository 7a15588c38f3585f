"""The paramedian forehead flap: a paddle of the forehead's skin is turned onto the nose on a pedicle, in stages.

In the design's plane the pivot P, where the supratrochlear vessels come over the brow, is the origin; the defect's
middle lies at (-d, 0), radius r. The flap's axis u leaves P so that a turn by the angle t takes it to the defect. The
pedicle, of the width b, lies along it, and at its end the paddle, a circle as large as the defect about the point
(d + s) u: the pedicle is longer by s than the way that it has to bridge, as it passes over skin.

First stage: the flap is raised, turned about P with its skin outside and its paddle sewn into the defect, but for
where the pedicle leaves it. A hook holds the pedicle off the skin below. The donor site is closed side to side as far
as the paddle, whose place heals by itself.

Second stage: the pedicle is cut off at the paddle, whose last edge is sewn in, and at the brow, where a triangle of it
stays: it goes back between the ends of the donor site, as an inverted V.

Third stage, where a thickness is given: the paddle is thinned to it and comes to rest on the nose.

The brow's side of P stays on its bed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import Carry, Corner, Division, Edge, FlapDesign, Seam, Spot, Thinned
from lappet.designs.flat_curves import arc, polyline
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.tissue.placement import Place

WIDER = 1.1  # the paddle than the pedicle, at least
FREED = 10.0  # mm beside the flap, so that its donor site can be closed
RIM = 4.0  # mm around the defect
LIFT = 1.4  # of the usual height: the pedicle passes over skin
HOLDS = 0.35  # of that height: where the pedicle is held
_NAME = "paramedian-forehead"
_STEP = 0.5  # mm from point to point of the defect


def paramedian_forehead_flap(
    center: ArrayLike,
    direction: ArrayLike,
    diameter: float,
    distance: float = 36.0,
    width: float = 12.0,
    spare: float = 6.0,
    turn: float = 180.0,
    stump: float = 8.0,
    thinned: float = 0.0,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design a paramedian forehead flap.

    Parameters
    ----------
    center
        Pivot, above the inner end of the brow, in mm, shape (3,).
    direction
        Direction from the defect to the pivot, and on, shape (3,).
    diameter
        Diameter of the defect in mm.
    distance
        Distance from the defect's middle to the pivot in mm.
    width
        Width of the pedicle in mm.
    spare
        How much longer the flap is than the distance in mm.
    turn
        Angle by which the flap turns about the pivot in degrees.
    stump
        Length of what of the pedicle goes back in mm.
    thinned
        Thickness of the paddle that a third stage leaves in mm, or 0 for no such stage.
    normal
        Outwards from the skin at the pivot, shape (3,).
    mirrored
        Whether it turns the other way.
    project
        Maps points (k, 3) onto a curved skin, as `draped_on` gives, or None.

    Returns
    -------
    FlapDesign
        The design.

    Raises
    ------
    RefusedError
        If a length is not positive, the paddle is hardly wider than the pedicle, the defect reaches the pivot, or the
        stump the paddle.
    """
    r, half, long = 0.5 * diameter, 0.5 * width, distance + spare
    neck = _require_fit(diameter, distance, width, spare, stump)
    middle = np.array([-distance, 0.0])
    plane = DesignPlane.at(center, skin_axes(direction, normal, _NAME), mirrored, project)
    flap = _Flap(np.radians(180.0 - turn), long, r, half, neck)
    arcs = flap.rim(0.0, 180.0 - flap.wide)[::-1], flap.rim(0.0, flap.wide - 180.0)  # to the tip, and on
    insets = [
        Seam(f"inset_{name}", (plane.edge(edge, side), plane.edge(flap.laid(edge, middle), -side)))
        for name, edge, side in (("left", arcs[0], -1), ("right", arcs[1][::-1], 1))
    ]
    over = flap(0.5 * neck, 0.0)
    held = plane.spot(over, flap.paddle), plane.spot((-0.5 * neck, 0.0), middle)
    about, by = plane.point((0.0, 0.0)), -turn if mirrored else turn
    tip, *sides = (flap(long + x, y) for x, y in ((r, 0.0), (0.0, r), (0.0, -r)))
    carries = [
        Carry(
            name,
            plane.spot(at, flap.paddle),
            about,
            plane.spot(flap.laid(at, middle), middle),
            LIFT,
            by,
        )
        for name, at in (("tip", tip), ("left", sides[0]), ("right", sides[1]))
    ]
    return FlapDesign(
        (plane.excised("defect", flap.laid(flap.rim(0.0, 360.0)[:-1], middle), middle),),
        (plane.points(flap.outline()),),
        (*insets, Seam("donor", _sides(plane, flap, stump, neck))),
        tuple(
            Corner(name, plane.spot(at, flap.paddle), _outside(plane, flap.laid(at, middle), middle))
            for name, at in (("tip", tip), ("left", arcs[0][0]), ("right", arcs[1][-1]))
        ),
        (*carries, Carry("pedicle", held[0], about, held[1], LIFT, by, HOLDS)),
        (plane.point(flap.paddle),),
        freed=(
            plane.outline(flap.around(FREED)),
            plane.outline(middle + arc(np.zeros(2), r + RIM, 0.0, 360.0)[:-1]),
        ),
        division=_division(plane, flap, middle, stump),
        thinned=Thinned(plane.points(flap.rim(0.0, 360.0)[:-1]), thinned) if thinned > 0.0 else None,
    )


def _require_fit(diameter: float, distance: float, width: float, spare: float, stump: float) -> float:
    """How long the pedicle is in mm; refuse measures that contradict each other."""
    require_lengths(_NAME, diameter=diameter, distance=distance, width=width, stump=stump)
    r = 0.5 * diameter
    if diameter < WIDER * width:
        _refuse("diameter", diameter, f"at least {WIDER * width:.3g} mm, more than the pedicle's width")
    if distance < r + width:
        _refuse("distance", distance, f"at least {r + width:.3g} mm, or the defect reaches the pivot")
    neck = distance + spare - float(np.sqrt(r**2 - 0.25 * width**2))
    if stump > 0.5 * neck:
        _refuse("stump", stump, f"at most {0.5 * neck:.3g} mm, half of the pedicle")
    return neck


@dataclass(frozen=True, eq=False)
class _Flap:
    """The flap in its own axes: x from the pivot to the paddle's middle. Lengths are mm.

    Parameters
    ----------
    angle
        From the plane's x to its own, in radians.
    long
        From the pivot to the paddle's middle.
    r
        Radius of the paddle.
    half
        Half of the pedicle's width.
    neck
        From the pivot to where the pedicle ends in the paddle.
    """

    angle: float
    long: float
    r: float
    half: float
    neck: float

    def __call__(self, x: float, y: float) -> NDArray[np.float64]:
        """A point in the plane, shape (2,)."""
        return self._placed(np.array([[x, y]]))[0]

    @property
    def paddle(self) -> NDArray[np.float64]:
        """The paddle's middle."""
        return self(self.long, 0.0)

    @property
    def wide(self) -> float:
        """Half of the angle, in degrees about the paddle's middle, over which the pedicle joins it."""
        return float(np.degrees(np.arcsin(self.half / self.r)))

    def rim(self, start: float, end: float, step: float = _STEP) -> NDArray[np.float64]:
        """A part of the paddle's rim, from angle to angle in degrees, 0 at the tip."""
        return self._placed(arc((self.long, 0.0), self.r, start, end, step))

    def line(self, *corners: ArrayLike) -> NDArray[np.float64]:
        """Straight lines from corner to corner of its own axes."""
        return self._placed(polyline(*corners))

    def outline(self) -> NDArray[np.float64]:
        """The cut around it, from the pivot's one side to its other."""
        far = 180.0 - self.wide
        up, down = (self.line((0.0, side), (self.neck, side)) for side in (self.half, -self.half))
        return np.vstack([up[:-1], self.rim(far, -far), down[-2::-1]])

    def around(self, beyond: float) -> NDArray[np.float64]:
        """A line beyond it, closed, counter-clockwise, that ends at the pivot."""
        end = arc((self.long, 0.0), self.r + beyond, -90.0, 90.0)
        return self._placed(np.vstack([end, [(0.0, self.half + beyond), (0.0, -self.half - beyond)]]))

    def laid(self, points: NDArray[np.float64], middle: NDArray[np.float64]) -> NDArray[np.float64]:
        """Where points of the paddle come to lie in the defect: it turns by half a turn less its own angle."""
        return middle + _turned(points - self.paddle, np.pi - self.angle)

    def _placed(self, own: NDArray[np.float64]) -> NDArray[np.float64]:
        return _turned(own, self.angle)


def _turned(points: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
    return points @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])


def _sides(plane: DesignPlane, flap: _Flap, start: float, end: float) -> tuple[Edge, Edge]:
    """The lips on both sides of the pedicle, which close over its bed."""
    left, right = (flap.line((start, side), (end, side)) for side in (flap.half, -flap.half))
    return plane.edge(left, 1), plane.edge(right, -1)


def _outside(plane: DesignPlane, at: NDArray[np.float64], middle: NDArray[np.float64]) -> Spot:
    """A point of the defect's rim, whose tissue lies outside."""
    return plane.spot(at, 2.0 * at - middle)


def _division(plane: DesignPlane, flap: _Flap, middle: NDArray[np.float64], stump: float) -> Division:
    """Cut the pedicle off at the paddle and, pointed, at the brow; sew the paddle's last edge and the stump."""
    half, neck = flap.half, flap.neck
    last = flap.line((neck, half), (neck, -half))
    near = flap.laid(flap.rim(180.0 - flap.wide, 180.0 + flap.wide), middle)
    point = flap.line((0.0, half), (stump, 0.0), (0.0, -half))
    seams = [Seam("rejoined_paddle", (plane.edge(last, 1), plane.edge(near, -1)))]
    for name, side in (("left", 1), ("right", -1)):
        own = flap.line((0.0, side * half), (stump, 0.0))
        lip = flap.line((0.0, side * half), (stump, side * half))
        seams.append(Seam(f"rejoined_{name}", (plane.edge(own, -side), plane.edge(lip, side))))
    seed = plane.point(flap(0.5 * (stump + neck), 0.0))
    return Division((plane.points(last), plane.points(point)), (seed,), tuple(seams))


def _refuse(name: str, value: float, possible: str) -> NoReturn:
    raise refused(ProblemCode.DESIGN_RANGE, _NAME, f"{value:g}", name=name, range=possible)


_STAGES = "chosen; Menick thins before the pedicle is divided, others afterwards (not read)"
_DHAWAN = "I. K. Dhawan and N. C. Madan, Supratrochlear artery (off-midline) forehead skin flap, plasticsurgerykey.com"
_CHOSEN = "chosen: what lies between a brow and a nose"
PARAMEDIAN_FOREHEAD = LibraryDesign(
    _NAME,
    "Paramedian forehead flap",
    "A defect of the nose wider than 15 mm, filled with skin of the forehead on a pedicle that is divided later.",
    (
        Parameter("diameter", "diameter of the defect", "mm", 16.0, 8.0, 40.0, "wider than 15 mm: Menick, as quoted"),
        Parameter("distance", "from the defect's middle to the pivot", "mm", 36.0, 20.0, 90.0, _CHOSEN),
        Parameter("width", "width of the pedicle", "mm", 10.0, 5.0, 20.0, "5 to 10 mm: Dhawan and Madan"),
        Parameter("spare", "how much longer the flap is than the distance", "mm", 6.0, 0.0, 25.0, _CHOSEN),
        Parameter("turn", "angle by which the flap turns", "°", 180.0, 120.0, 180.0, "180°: Dhawan and Madan"),
        Parameter("stump", "length of what of the pedicle goes back", "mm", 8.0, 3.0, 20.0, _CHOSEN),
        Parameter("thinned", "thickness that a third stage leaves, 0 for none", "mm", 0.0, 0.0, 10.0, _STAGES),
    ),
    paramedian_forehead_flap,
    "the pivot, above the inner end of the brow",
    "from the defect to the pivot, and on",
    "",
    _DHAWAN + " (an excerpt was read).",
    "What is measured as open is the paddle's place on the forehead, which is left to heal by itself.",
)
