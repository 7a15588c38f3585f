"""The bilobed flap of Zitelli: a first lobe fills a round defect, a second, narrower one the first's place.

In the design's plane the pivot P is the origin and the defect's middle lies two radii r away on the x axis, so that P
is one radius from the defect's edge. From P two lines touch the defect: the skin between them (a standing cone to
come) is cut out with it. From the defect's widest place S (at 26.6° and sqrt(5) r from P) the lobes follow each other
about P, each on the chord of its angle:

- the first lobe, over the chord from S to V, is a half ellipse one radius high: it turns onto the far half of the
  defect;
- the second, over the chord from V to E, is pointed, so that its donor site closes in a line; it turns into the
  first's place, and E, the end of the cut, meets the tip of the skin between the lobes.

With lobes of 50° and 45° the flap turns about 100°, as in J. A. Zitelli, "The bilobed flap for nasal reconstruction",
Arch. Dermatol. 125 (1989) 957, who asks for 90° to 110°.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import Carry, Corner, FlapDesign, Seam, Spot
from lappet.designs.flat_curves import NICK, arc, bow, length, part, segment
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.tissue.placement import Place


def bilobed(
    center: ArrayLike,
    direction: ArrayLike,
    diameter: float,
    first: float = 50.0,
    second: float = 45.0,
    height: float = 1.5,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design a bilobed flap.

    Parameters
    ----------
    center
        Middle of the defect in mm, shape (3,).
    direction
        Direction from the pivot to the defect, shape (3,).
    diameter
        Diameter of the defect in mm.
    first
        Angle of the first lobe about the pivot in degrees.
    second
        Angle of the second lobe in degrees.
    height
        Height of the second lobe over its chord, in radii of the defect.
    normal
        Outwards from the skin at the middle, shape (3,).
    mirrored
        Whether the lobes lie on the right of the direction.
    project
        Maps points (k, 3) onto a curved skin, as `draped_on` gives, or None.

    Returns
    -------
    FlapDesign
        The design.

    Raises
    ------
    RefusedError
        If a length is not positive.
    """
    require_lengths("bilobed", diameter=diameter, first=first, second=second, height=height)
    r = 0.5 * diameter
    plane = DesignPlane.at(center, skin_axes(direction, normal, "bilobed"), mirrored, project, (2.0 * r, 0.0))
    pivot, middle = np.zeros(2), np.array([2.0 * r, 0.0])
    touch = np.sqrt(3.0) * r * np.array([np.cos(np.pi / 6.0), np.sin(np.pi / 6.0)])
    start = np.array([2.0 * r, r])  # S
    between, end = _turned(start, first), _turned(start, first + second)  # V, E
    lobe = bow(start, between, -r, step=0.5)
    tall = bow(between, end, -height * r, pointed=True, step=0.5)
    far = arc(middle, r, -90.0, 90.0, step=0.5)
    near = np.vstack([segment(pivot, touch), arc(middle, r, 120.0, 90.0, step=0.5)[1:]])  # from P to S
    across = near * np.array([1.0, -1.0])  # from P to the other side's widest place
    top, tip = _half(lobe), _half(tall)
    flap_one, flap_two = 0.5 * (start + between) * 1.05, 0.5 * (between + end) * 1.05
    around = np.vstack([across[:-1], far[:-1], near[:0:-1]])
    cut = np.vstack([(start + NICK * _unit(middle - start))[None], lobe[:-1], tall])
    corners = (
        Corner("donor", plane.spot(between, 1.4 * between), plane.spot(end, end + 0.3 * (end - flap_two))),
        Corner("first", plane.spot(between, 0.6 * between), plane.spot(start, start + _spike(lobe))),
        Corner("second", plane.spot(tip[0], flap_two), plane.spot(top[0], 1.4 * top[0])),
    )
    carries = (
        Carry(
            "first",
            plane.spot(top[0], flap_one),
            plane.point(pivot),
            Spot(plane.point((3.0 * r, 0.0)), plane.point(middle)),
        ),
        Carry(
            "second", plane.spot(tip[0], flap_two), plane.point(pivot), Spot(plane.point(top[0]), plane.point(flap_one))
        ),
    )
    return FlapDesign(
        (plane.excised("defect", around, middle),),
        (plane.points(cut),),
        _seams(plane, near, across, far, lobe, tall),
        corners,
        carries,
        (plane.point(flap_one), plane.point(flap_two)),
    )


def _seams(
    plane: DesignPlane,
    near: NDArray[np.float64],
    across: NDArray[np.float64],
    far: NDArray[np.float64],
    lobe: NDArray[np.float64],
    tall: NDArray[np.float64],
) -> tuple[Seam, ...]:
    """The flap's base, the first lobe in the defect, the second in the first's place, and the second's donor site."""
    top, tip = _half(lobe)[1], _half(tall)[1]
    lead, trail = part(lobe, 0.0, top), part(lobe, top, length(lobe))
    up, down = part(tall, 0.0, tip), part(tall, tip, length(tall))
    return (
        Seam("donor", (plane.edge(up, -1), plane.edge(down[::-1], 1))),
        Seam("base", (plane.edge(near, 1), plane.edge(across, -1))),
        Seam("defect", (plane.edge(lobe, 1), plane.edge(far, -1))),
        Seam("second_up", (plane.edge(up, 1), plane.edge(lead, -1))),
        Seam("second_down", (plane.edge(down, 1), plane.edge(trail, -1))),
    )


def _turned(point: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
    """A point turned counter-clockwise about the origin, degrees."""
    turn = np.radians(angle)
    return np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]) @ point


def _unit(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    return vector / np.linalg.norm(vector)


def _half(curve: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """The point in the middle of a curve, and its distance along it."""
    half = 0.5 * length(curve)
    return part(curve, 0.0, half)[-1], half


def _spike(lobe: NDArray[np.float64]) -> NDArray[np.float64]:
    """Into the skin between the defect, which runs along x at S, and the first lobe."""
    return _unit(_unit(lobe[1] - lobe[0]) + np.array([1.0, 0.0]))


_ZITELLI = "J. A. Zitelli, Arch. Dermatol. 125 (1989) 957"
BILOBED = LibraryDesign(
    "bilobed",
    "Bilobed flap",
    "A round defect up to 15 mm wide of the lower third of the nose, filled with the looser skin above it.",
    (
        Parameter("diameter", "diameter of the defect", "mm", 12.0, 3.0, 30.0, "up to 15 mm on the nose: " + _ZITELLI),
        Parameter("first", "angle of the first lobe", "°", 50.0, 40.0, 60.0, "turn of 90° to 110° in all: " + _ZITELLI),
        Parameter("second", "angle of the second lobe", "°", 45.0, 30.0, 55.0, _ZITELLI),
        Parameter("height", "height of the second lobe, in radii", "", 1.5, 1.0, 2.5, "what closes without a dog-ear"),
    ),
    bilobed,
    "the middle of the defect",
    "from the pivot to the defect",
    "",
    "J. A. Zitelli, The bilobed flap for nasal reconstruction, Arch. Dermatol. 125 (1989) 957.",
)
