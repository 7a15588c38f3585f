"""The nasolabial flap: a finger of the cheek's skin along its fold is turned onto a round defect of the ala.

In the design's plane the pivot P is the origin and the defect's middle lies two radii r away on the x axis. As in the
bilobed flap, two lines from P touch the defect, and the skin between them, a standing cone to come, is cut out with it.
The flap stands on the chord from the defect's widest place S (sqrt(5) r from P) to E, which is S turned about P. Its
donor site is pointed like a Gothic arch, so that it closes in a line, the fold. The flap itself is trimmed to half an
ellipse as long as the defect's far side is from P, three radii: what the arch has beyond it is cut out.

When the flap is turned E comes to S, and the flap's rounded end to the far half of the defect. The spike of skin
between defect and donor site goes the other way, to E.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import Carry, Corner, FlapDesign, Seam, Spot
from lappet.designs.flat_curves import GOTHIC, NICK, arc, part, segment
from lappet.designs.flat_curves import length as length_of
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.tissue.placement import Place

_STEP = 0.5  # mm from point to point


def nasolabial_flap(
    center: ArrayLike,
    direction: ArrayLike,
    diameter: float,
    angle: float = 60.0,
    height: float = 2.5,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design a nasolabial flap.

    Parameters
    ----------
    center
        Middle of the defect in mm, shape (3,).
    direction
        Direction from the pivot to the defect, shape (3,).
    diameter
        Diameter of the defect in mm.
    angle
        Angle by which the flap turns about the pivot in degrees.
    height
        Height of the donor site over the flap's base, in radii of the defect.
    normal
        Outwards from the skin at the middle, shape (3,).
    mirrored
        Whether the flap lies on the right of the direction.
    project
        Maps points (k, 3) onto a curved skin, as `draped_on` gives, or None.

    Returns
    -------
    FlapDesign
        The design.

    Raises
    ------
    RefusedError
        If a length is not positive, or the donor site is no higher than the flap is long.
    """
    require_lengths("nasolabial", diameter=diameter, angle=angle, height=height)
    r = 0.5 * diameter
    plane = DesignPlane.at(center, skin_axes(direction, normal, "nasolabial"), mirrored, project, (2.0 * r, 0.0))
    pivot, middle = np.zeros(2), np.array([2.0 * r, 0.0])
    touch = np.sqrt(3.0) * r * np.array([np.cos(np.pi / 6.0), np.sin(np.pi / 6.0)])
    start = np.array([2.0 * r, r])  # S
    end = _turned(start, angle)  # E
    foot = 0.5 * (start + end)
    out = foot / np.linalg.norm(foot)
    long = 3.0 * r - float(np.linalg.norm(foot))
    if not height * r > 1.2 * long:
        least = f"more than {1.2 * long / r:.2f} radii"
        raise refused(ProblemCode.DESIGN_RANGE, "nasolabial", f"{height:g}", name="height", range=least)
    rise, fall, cap, tip = _arch(start, end, out, long, height * r)
    far = arc(middle, r, -90.0, 90.0, step=_STEP)
    near = np.vstack([segment(pivot, touch), arc(middle, r, 120.0, 90.0, step=_STEP)[1:]])  # from P to S
    across = near * np.array([1.0, -1.0])
    lobe = np.vstack([rise[:-1], cap[:-1], fall])
    up, down = np.vstack([rise[:-1], tip[: len(tip) // 2 + 1]]), np.vstack([tip[len(tip) // 2 : -1], fall])
    flap = 1.05 * foot
    high = part(lobe, 0.0, 0.5 * length_of(lobe))[-1]
    seed = 0.5 * (cap[len(cap) // 2] + tip[len(tip) // 2])
    spike = _unit(_unit(rise[1] - rise[0]) + np.array([1.0, 0.0]))
    inside = [(start + NICK * _unit(middle - start))[None], (fall[0] + NICK * _unit(seed - fall[0]))[None]]
    return FlapDesign(
        (
            plane.excised("defect", np.vstack([across[:-1], far[:-1], near[:0:-1]]), middle),
            plane.excised("tip", np.vstack([cap[:-1], tip[:0:-1]]), seed),
        ),
        (
            plane.points(np.vstack([inside[0], rise, (rise[-1] + NICK * _unit(seed - rise[-1]))[None]])),
            plane.points(np.vstack([inside[1], fall])),
        ),
        (
            Seam("donor", (plane.edge(up, -1), plane.edge(down[::-1], 1))),
            Seam("base", (plane.edge(near, 1), plane.edge(across, -1))),
            Seam("defect", (plane.edge(lobe, 1), plane.edge(far, -1))),
        ),
        (Corner("donor", plane.spot(start, start + spike), plane.spot(end, end + 0.3 * (end - flap))),),
        (
            Carry(
                "flap",
                plane.spot(high, flap),
                plane.point(pivot),
                Spot(plane.point((3.0 * r, 0.0)), plane.point(middle)),
            ),
        ),
        (plane.point(flap),),
    )


def _arch(
    start: NDArray[np.float64], end: NDArray[np.float64], out: NDArray[np.float64], long: float, high: float
) -> tuple[NDArray[np.float64], ...]:
    """The sides of the donor site up to where the flap is trimmed and down from there; the trimmed flap's end; the tip.

    The arch is high (1 - abs(t)^GOTHIC) over the chord from start to end, t from -1 to 1, the ellipse long
    sqrt(1 - t²). Each is of points (k, 2), from the side of start to that of end.
    """
    t = -np.cos(np.linspace(0.0, np.pi, 2001))
    pointed, round_end = high * (1.0 - np.abs(t) ** GOTHIC), long * np.sqrt(np.maximum(1.0 - t**2, 0.0))
    over = np.flatnonzero(pointed > round_end)
    first, last = over[0], over[-1]
    chord = 0.5 * (start + end) + 0.5 * t[:, None] * (end - start)

    def curve(height: NDArray[np.float64], low: int, top: int) -> NDArray[np.float64]:
        fine = chord[low : top + 1] + height[low : top + 1, None] * out
        return part(fine, 0.0, length_of(fine), _STEP)

    ends = curve(pointed, 0, first), curve(pointed, last, len(t) - 1)
    half = len(t) // 2
    tip = np.vstack([curve(pointed, first, half)[:-1], curve(pointed, half, last)])
    cap = curve(round_end, first, last)
    cap[0], cap[-1] = ends[0][-1], ends[1][0]
    return ends[0], ends[1], cap, tip


def _turned(point: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
    turn = np.radians(angle)
    return np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]) @ point


def _unit(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    return vector / np.linalg.norm(vector)


_BAKER = "S. R. Baker, Local Flaps in Facial Reconstruction, on melolabial flaps (not read)"
_TRIMMED = (
    "J. Sciegienka et al., Plast. Aesthet. Res. 9 (2022) 1, figure 8: a superiorly based flap, trimmed to the defect"
)
NASOLABIAL = LibraryDesign(
    "nasolabial",
    "Nasolabial flap",
    "A round defect of the ala or the side of the nose, filled with skin of the fold beside it.",
    (
        Parameter("diameter", "diameter of the defect", "mm", 12.0, 3.0, 25.0, "chosen: what the fold can give"),
        Parameter("angle", "angle by which the flap turns", "°", 60.0, 50.0, 75.0, "chosen: between fold and ala"),
        Parameter("height", "height of the donor site, in radii", "", 2.5, 1.75, 4.0, "what closes without a dog-ear"),
    ),
    nasolabial_flap,
    "the middle of the defect",
    "from the pivot to the defect",
    "",
    _TRIMMED + " (its caption was read); after " + _BAKER + ".",
)
