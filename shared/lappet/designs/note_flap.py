"""The note flap: a triangle beside a round defect turns into it; circle, stem and flag are drawn like an eighth note.

In the design's plane the circle of radius r lies about the origin, and its tangent at T = (r, 0), the stem, runs up to
E; from there the second limb, the flag, comes back on the other side to F. Two pieces go with the defect: the spike
between circle and stem, too thin to hold a suture, up to where it is `SPIKE` radii wide; and beside T the standing cone
that would come, a triangle on the rim from T to Q, `CONE` below it, with its tip P outwards. The flap turns about P: T
comes to Q, its stem lies on the rim from there on, its flag on the rest, and the skin left of the stem is drawn to F.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import Carry, Corner, FlapDesign, Seam
from lappet.designs.flat_curves import NICK, arc, polyline, segment
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.tissue.placement import Place

SPIKE = 0.15
CONE, TALL = 50.0, 1.2  # degrees of the rim; height of the cone in radii
_STEP = 0.5  # mm from point to point of the circle


def note_flap(
    center: ArrayLike,
    direction: ArrayLike,
    diameter: float,
    stem: float = 1.4,
    flag: float = 1.1,
    angle: float = 50.0,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design a note flap.

    Parameters
    ----------
    center
        Middle of the defect in mm, shape (3,).
    direction
        Direction from the defect to the stem, square to it, shape (3,).
    diameter
        Diameter of the defect in mm.
    stem
        Length of the tangent in diameters.
    flag
        Length of the second limb in diameters.
    angle
        Angle between the two in degrees.
    normal
        Outwards from the skin at the middle, shape (3,).
    mirrored
        Whether the stem runs to the right of the direction.
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
    require_lengths("note", diameter=diameter, stem=stem, flag=flag, angle=angle)
    r = 0.5 * diameter
    plane = DesignPlane.at(center, skin_axes(direction, normal, "note"), mirrored, project)
    foot = np.array([r, 0.0])  # T
    tip = foot + np.array([0.0, stem * diameter])  # E
    turn = np.radians(angle - 90.0)
    end = tip + flag * diameter * np.array([np.cos(turn), np.sin(turn)])  # F
    flap = (foot + tip + end) / 3.0
    spike = r * np.array([1.0 - SPIKE, np.sqrt(1.0 - (1.0 - SPIKE) ** 2)])
    root = np.array([r, spike[1]])  # where the stem leaves what is cut out
    last = float(np.degrees(np.arccos(1.0 - SPIKE))) - 360.0
    split = -CONE + (last + CONE) * stem / (stem + flag)  # where on the rim, clockwise, the flap's tip comes to lie
    lower, upper = arc((0.0, 0.0), r, -CONE, split, _STEP), arc((0.0, 0.0), r, split, last, _STEP)
    out = np.radians(-0.5 * CONE)
    apex = (1.0 + TALL) * r * np.array([np.cos(out), np.sin(out)])  # P
    rim = np.vstack([lower[:-1], upper, root[None], segment(foot, apex)[:-1], segment(apex, lower[0])[:-1]])
    left, beyond = root - np.array([diameter, 0.0]), tip + end - flap
    below = lower[0] + np.array([0.0, -diameter])
    into = root - NICK * np.array([0.5, 1.0])
    top = plane.spot(tip, flap)
    return FlapDesign(
        excised=(plane.excised("defect", rim, np.zeros(2)),),
        incisions=(plane.points(np.vstack([into[None], polyline(root, tip, end)])),),
        seams=(
            Seam("donor", (plane.edge_beside(segment(tip, root), left), plane.edge_beside(segment(tip, end), beyond))),
            Seam(
                "cone",
                (plane.edge_beside(segment(foot, apex), flap), plane.edge_beside(segment(lower[0], apex), below)),
            ),
            Seam("stem", (plane.edge_beside(segment(foot, tip), flap), plane.edge(lower, 1))),
            Seam("flag", (plane.edge_beside(segment(tip, end), flap), plane.edge(upper, 1))),
        ),
        corners=(
            Corner("donor", plane.spot(root, root + np.array([-0.3, 1.0])), plane.spot(end, 2.0 * end - tip)),
            Corner("cone", plane.spot(foot, flap), plane.spot(lower[0], below)),
            Corner("tip", top, plane.spot(lower[-1], 1.5 * lower[-1])),
        ),
        carries=(Carry("tip", top, plane.point(apex), plane.spot(lower[-1], (0.0, 0.0))),),
        flaps=(plane.point(flap),),
    )


_WALIKE = "J. W. Walike and W. F. Larrabee, The 'note flap', Arch. Otolaryngol. 111 (1985) 430 (its abstract was read)"
_MEAN = "mean of 20 patients, where the rule is "
NOTE_FLAP = LibraryDesign(
    "note",
    "Note flap",
    "A small round defect of the face, closed by a triangle of about three quarters of its area.",
    (
        Parameter("diameter", "diameter of the defect", "mm", 14.0, 4.0, 40.0, "chosen"),
        Parameter("stem", "length of the tangent, in diameters", "", 1.4, 1.2, 1.6, f"{_MEAN}1.5: {_WALIKE}"),
        Parameter("flag", "length of the second limb, in diameters", "", 1.1, 0.95, 1.3, f"{_MEAN}1: {_WALIKE}"),
        Parameter("angle", "angle between the two", "°", 50.0, 45.0, 60.0, f"{_MEAN}50° to 60°: {_WALIKE}"),
    ),
    note_flap,
    "the middle of the defect",
    "from the defect to the stem, square to it",
    "across",
    _WALIKE + ". The rule lays the tangent along the lines of the skin.",
)
