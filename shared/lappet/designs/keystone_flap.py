"""The keystone flap: beside an elliptic defect an island of skin, curved and trapezoid, that is moved into it.

In the design's plane the defect is a fusiform of two circular arcs with its tips A and B on the x axis. The flap lies
above it: its inner edge is the defect's upper arc, its outer edge the arc about the same middle that is farther out by
the flap's breadth, and its two ends are cut from A and B along the radii, square to both arcs. The incisions go around;
what lies below the island is left, and carries it with its vessels.

The flap goes down into the defect by the advance s. Its corners A' and B' pass the tips, so that the inner edge with s
of either end is sewn to the defect's lower arc. Behind the outer corners, C and D, the wound is closed as the stem of a
Y: s of the end's outer lip to s of the outer arc's outer lip. The rest of each end, and of the outer edge, is sewn to
what is left of its own lip.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import Corner, FlapDesign, Seam
from lappet.designs.flat_curves import NICK, arc, part, segment
from lappet.designs.flat_curves import length as length_of
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.tissue.placement import Place


def keystone_flap(
    center: ArrayLike,
    direction: ArrayLike,
    length: float,
    width: float,
    breadth: float = 1.0,
    advance: float = 0.35,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design a keystone flap.

    Parameters
    ----------
    center
        Middle of the defect in mm, shape (3,).
    direction
        Direction of the defect's long axis, shape (3,); the flap is to its left.
    length
        Length of the defect from tip to tip in mm.
    width
        Width of the defect in mm, at most the length.
    breadth
        Breadth of the flap in widths of the defect.
    advance
        How far the flap goes into the defect, in widths of the defect; less than its breadth.
    normal
        Outwards from the skin at the middle, shape (3,).
    mirrored
        Whether the flap is to the right of the direction.
    project
        Maps points (k, 3) onto a curved skin, as `draped_on` gives, or None.

    Returns
    -------
    FlapDesign
        The design. Nothing is undermined.

    Raises
    ------
    RefusedError
        If a length is not positive or the width is above the length.
    """
    require_lengths("keystone", length=length, width=width, breadth=breadth, advance=advance)
    if width > length:
        raise refused(ProblemCode.DESIGN_OVAL, "keystone", f"{width:g}", length=length)
    plane = DesignPlane.at(center, skin_axes(direction, normal, "keystone"), mirrored, project)
    island = keystone_island(plane, length, width, breadth * width, advance * width)
    return keystone_design(plane, length, island, island.seams, island.corners)


@dataclass(frozen=True, eq=False)
class KeystoneIsland:
    """An island beside an elliptic defect.

    Parameters
    ----------
    inner
        The arc that it has in common with the defect, in the plane in mm, shape (k, 2).
    front
        The edge that goes into the defect: the inner arc with the first mm of both ends, shape (k, 2).
    ends
        Those first mm of the left and right end, from the defect's tips on, each of shape (k, 2).
    cut
        The incision around it, shape (k, 2).
    middle
        Its middle, shape (2,).
    seams
        Those of its ends and of its back.
    corners
        Where its outer corners go.
    """

    inner: NDArray[np.float64]
    front: NDArray[np.float64]
    ends: tuple[NDArray[np.float64], NDArray[np.float64]]
    cut: NDArray[np.float64]
    middle: NDArray[np.float64]
    seams: tuple[Seam, ...]
    corners: tuple[Corner, ...]


def keystone_island(
    plane: DesignPlane, length: float, width: float, broad: float, moved: float, side: float = 1.0, what: str = ""
) -> KeystoneIsland:
    """Draw the island beside a defect of two arcs about the origin.

    Parameters
    ----------
    plane
        The plane of the design.
    length
        Length of the defect in mm.
    width
        Width of the defect in mm.
    broad
        Breadth of the island in mm.
    moved
        How far it goes into the defect in mm.
    side
        1 for an island above the defect, -1 for one below.
    what
        What the names of its seams and corners begin with.

    Returns
    -------
    KeystoneIsland
        The island.
    """
    flip = np.array([1.0, side])
    radius = (length**2 + width**2) / (4.0 * width)
    middle = np.array([0.0, 0.5 * width - radius])
    half = float(np.degrees(2.0 * np.arctan2(width, length)))  # half the opening angle of an arc
    inner = arc(middle, radius, 90.0 + half, 90.0 - half) * flip  # from A to B
    outer = arc(middle, radius + broad, 90.0 + half, 90.0 - half) * flip  # from C to D
    middle = middle * flip
    flap = np.array([0.0, 0.5 * width + 0.5 * broad]) * flip
    seams, corners, taken = [], [], []
    for end, name in ((0, "left"), (-1, "right")):
        own_side, rim = segment(inner[end], outer[end]), outer if end == 0 else outer[::-1]
        beyond = own_side.mean(axis=0) + 4.0 * (own_side.mean(axis=0) - flap)
        above = outer[len(outer) // 2] + np.array([0.0, side * length])
        whole = length_of(own_side)
        stem = part(own_side[::-1], 0.0, moved), part(rim, 0.0, moved)
        seams.append(
            Seam(f"{what}stem_{name}", (plane.edge_beside(stem[0], beyond), plane.edge_beside(stem[1], above)))
        )
        own, rest = part(own_side, moved, whole), part(own_side, 0.0, whole - moved)
        seams.append(Seam(f"{what}{name}", (plane.edge_beside(own, flap), plane.edge_beside(rest, beyond))))
        tip = plane.spot(outer[end], flap)
        for which, lip, away in (
            ("tip", stem[0][-1], beyond - stem[0][-1]),
            ("rim", stem[1][-1], stem[1][-1] - middle),
        ):
            into = lip + 0.2 * whole * away / np.linalg.norm(away)
            corners.append(Corner(f"{what}{which}_{name}", tip, plane.spot(lip, into)))
        taken.append(part(own_side, 0.0, moved))
    front = np.vstack([taken[0][::-1][:-1], inner[:-1], taken[1]])
    back = part(outer, moved, length_of(outer) - moved)
    nick = NICK * np.array([1.0, 0.0])
    ends = segment(inner[0], outer[0])[:-1], segment(outer[-1], inner[-1])
    cut = np.vstack([(inner[0] + nick)[None], ends[0], outer[:-1], ends[1], (inner[-1] - nick)[None]])
    behind = plane.edge_beside(outer, flap), plane.edge_beside(back, np.array([0.0, 4.0 * side * length]))
    return KeystoneIsland(
        inner, front, (taken[0], taken[1]), cut, flap, (*seams, Seam(f"{what}back", behind)), tuple(corners)
    )


def keystone_design(
    plane: DesignPlane, length: float, island: KeystoneIsland, seams: tuple[Seam, ...], corners: tuple[Corner, ...]
) -> FlapDesign:
    """Draw the defect and the island above it, whose front goes into the defect.

    Parameters
    ----------
    plane
        The plane of the design.
    length
        Length of the defect in mm.
    island
        The island.
    seams
        Those besides the one of its front.
    corners
        Where its corners go.

    Returns
    -------
    FlapDesign
        The design. Nothing is undermined.
    """
    lower = island.inner * np.array([1.0, -1.0])
    ring = np.vstack([lower[:-1], island.inner[:0:-1]])
    closed = plane.edge_beside(lower, np.array([0.0, -length]))
    return FlapDesign(
        (plane.excised("defect", ring, np.zeros(2)),),
        (plane.points(island.cut),),
        (Seam("defect", (plane.edge_beside(island.front, island.middle), closed)), *seams),
        corners,
        (),
        (plane.point(island.middle),),
        undermined=0.0,
    )


_BEHAN = "F. C. Behan, ANZ J. Surg. 73 (2003) 112"
KEYSTONE = LibraryDesign(
    "keystone",
    "Keystone flap (type I)",
    "An elliptic defect of a limb or the trunk that cannot be closed directly: an island on its perforators beside it.",
    (
        Parameter("length", "length of the defect", "mm", 42.0, 10.0, 150.0, "chosen: 3:1 to the width"),
        Parameter("width", "width of the defect", "mm", 14.0, 3.0, 60.0, "that of the lesion with its margin"),
        Parameter(
            "breadth",
            "breadth of the flap, in widths of the defect",
            "",
            1.0,
            0.75,
            2.0,
            "chosen: as broad as the defect",
        ),
        Parameter("advance", "how far the flap goes into the defect, in widths", "", 0.35, 0.1, 0.6, "chosen"),
    ),
    keystone_flap,
    "the middle of the defect",
    "the defect's long axis, the flap to its left",
    "",
    _BEHAN
    + " (its abstract was read, not its figures): a curved trapezoid, its long axis beside the defect's, with V-Y "
    "advancement of each end, on random perforators.",
    "Type II is for larger defects: with a skin graft behind the flap (IIB) it is the design `keystone-ii`; with the "
    "deep fascia divided along the outer edge (IIA) it has this drawing and, as the model has no deep fascia but "
    "springs below the fat, these numbers.",
)
