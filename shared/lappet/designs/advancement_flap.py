"""Advancement flaps: skin is drawn straight into a square defect, from one side (U) or from two (H).

In the design's plane the defect lies about the origin; the flap of a U lies to its right, between two parallel
incisions that leave the defect's right corners. Its front edge meets the defect's left side. The outer lips are longer
than the flap's sides by what it advances: Burow's triangles at the ends of the incisions take that up. An H has such a
flap on either side, each drawn half as far; their front edges meet in the middle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.designs.burow_triangle import burow_triangle
from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import Carry, Corner, Edge, Excised, FlapDesign, Seam, Spot
from lappet.designs.flat_curves import NICK, part, polyline, segment
from lappet.designs.flat_curves import length as length_of
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.tissue.placement import Place


def u_plasty(
    center: ArrayLike,
    direction: ArrayLike,
    width: float,
    length: float = 2.0,
    burow: float = 0.7,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design a single advancement flap.

    Parameters
    ----------
    center
        Middle of the defect in mm, shape (3,).
    direction
        Direction from the defect to the flap, shape (3,).
    width
        Side of the square defect in mm.
    length
        Length of the flap in widths.
    burow
        Base of Burow's triangles, as a share of what the flap advances; 0 for none.
    normal
        Outwards from the skin at the middle, shape (3,).
    mirrored
        Whether the design is mirrored; it is its own image.
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
    require_lengths("u_plasty", width=width, length=length)
    plane = DesignPlane.at(center, skin_axes(direction, normal, "u_plasty"), mirrored, project)
    half = 0.5 * width
    flap = _Flap.drawn(plane, 1.0, width, length * width, -half, burow * width, "")
    front = Seam("front", (flap.front, plane.edge(segment((-half, -half), (-half, half)), 1)))
    meets = [(-half, half), (-half, -half)]
    corners = [
        Corner(f"{name}", spot, plane.spot(np.array(meet), 1.3 * np.array(meet)))
        for name, spot, meet in zip(("upper", "lower"), flap.ends, meets, strict=True)
    ]
    lay = [Spot(plane.point(np.array(meet)), plane.point((2.0 * half, meet[1] * 0.2))) for meet in meets]
    carries = [
        Carry(name, spot, None, there) for name, spot, there in zip(("upper", "lower"), flap.ends, lay, strict=True)
    ]
    return _design(plane, width, [flap], [front], corners, carries)


def h_plasty(
    center: ArrayLike,
    direction: ArrayLike,
    width: float,
    length: float = 1.25,
    burow: float = 0.7,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design two opposed advancement flaps.

    Parameters
    ----------
    center
        Middle of the defect in mm, shape (3,).
    direction
        Direction from the defect to one of the flaps, shape (3,).
    width
        Side of the square defect in mm.
    length
        Length of each flap in widths.
    burow
        Base of Burow's triangles, as a share of what each flap advances; 0 for none.
    normal
        Outwards from the skin at the middle, shape (3,).
    mirrored
        Whether the design is mirrored; it is its own image.
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
    require_lengths("h_plasty", width=width, length=length)
    plane = DesignPlane.at(center, skin_axes(direction, normal, "h_plasty"), mirrored, project)
    flaps = [
        _Flap.drawn(plane, side, width, length * width, 0.0, 0.5 * burow * width, name)
        for side, name in ((1.0, "right_"), (-1.0, "left_"))
    ]
    front = Seam("front", (flaps[0].front, flaps[1].front))
    corners, carries = [], []
    for k, name in enumerate(("upper", "lower")):
        corners.append(Corner(name, flaps[0].ends[k], flaps[1].ends[k]))
        there = np.array([0.0, 0.5 * width * (1 - 2 * k)])
        for side, own, flap in ((1.0, "right_", flaps[0]), (-1.0, "left_", flaps[1])):
            inside = plane.point(np.array([side * width, 0.2 * there[1]]))
            carries.append(Carry(own + name, flap.ends[k], None, Spot(plane.point(there), inside)))
    return _design(plane, width, flaps, [front], corners, carries)


@dataclass(frozen=True, eq=False)
class _Flap:
    """One flap, on the right of the defect or on its left.

    Parameters
    ----------
    incisions
        Its two incisions, upper and lower, in mm in the plane.
    front
        Its front edge, from its lower to its upper end.
    ends
        The two ends of its front edge, upper and lower.
    seams
        Its sides, and Burow's triangles.
    corners
        Corners of Burow's triangles.
    excised
        Burow's triangles.
    middle
        Its middle in the plane in mm.
    """

    incisions: tuple[NDArray[np.float64], ...]
    front: Edge
    ends: tuple[Spot, Spot]
    seams: tuple[Seam, ...]
    corners: tuple[Corner, ...]
    excised: tuple[Excised, ...]
    middle: NDArray[np.float64]

    @classmethod
    def drawn(
        cls, plane: DesignPlane, side: float, width: float, length: float, met: float, burow: float, name: str
    ) -> _Flap:
        """The flap on one side (1, -1), drawn until its front edge lies at x = side * met."""
        half = 0.5 * width
        middle = np.array([side * (half + 0.5 * length), 0.0])
        incisions, seams, corners, excised = [], [], [], []
        for k, y in enumerate((half, -half)):
            start, end = np.array([side * half, y]), np.array([side * (half + length), y])
            outer = polyline((side * met, y), start, end)
            out = 1 if (side * y) > 0.0 else -1  # the outer lip lies on this side of the way to the end
            which = name + ("upper", "lower")[k]
            if burow > 0.0:
                triangle = burow_triangle(plane, f"donor_{which}", segment(start, end), burow, out)
                excised.append(triangle.excised)
                seams.append(triangle.seam)
                corners.append(triangle.corner)
            lip = part(outer, 0.0, length_of(outer) - burow)
            seams.append(Seam(f"{which}_side", (plane.edge(segment(start, end), -out), plane.edge(lip, out))))
            incisions.append(np.vstack([start - 0.7 * NICK * np.array([side, np.sign(y)]), segment(start, end)]))
        front = segment((side * half, -half), (side * half, half))
        ends = tuple(plane.spot(np.array([side * half, y]), middle) for y in (half, -half))
        return cls(
            tuple(incisions),
            plane.edge(front, -1 if side > 0.0 else 1),
            (ends[0], ends[1]),
            tuple(seams),
            tuple(corners),
            tuple(excised),
            middle,
        )


def _design(
    plane: DesignPlane,
    width: float,
    flaps: list[_Flap],
    seams: list[Seam],
    corners: list[Corner],
    carries: list[Carry],
) -> FlapDesign:
    """The design of a square defect and its flaps."""
    half = 0.5 * width
    square = polyline((-half, -half), (half, -half), (half, half), (-half, half), (-half, -half))[:-1]
    defect = plane.excised("defect", square, np.zeros(2))
    return FlapDesign(
        (defect, *(each for flap in flaps for each in flap.excised)),
        tuple(plane.points(curve) for flap in flaps for curve in flap.incisions),
        (*seams, *(seam for flap in flaps for seam in flap.seams)),
        (*corners, *(corner for flap in flaps for corner in flap.corners)),
        tuple(carries),
        tuple(plane.point(flap.middle) for flap in flaps),
    )


_BAKER = "S. R. Baker, Local Flaps in Facial Reconstruction, on advancement flaps"
_BUROW = Parameter("burow", "base of Burow's triangles, as a share of the advance", "", 0.6, 0.0, 1.0, _BAKER)
U_PLASTY = LibraryDesign(
    "u-plasty",
    "Single advancement flap (U-plasty)",
    "A square defect of forehead or eyebrow, closed by skin drawn in from one side.",
    (
        Parameter("width", "side of the square defect", "mm", 14.0, 3.0, 50.0, _BAKER),
        Parameter(
            "length", "length of the flap, in widths", "", 2.0, 1.0, 4.0, "at most 3 to 4 in the face: " + _BAKER
        ),
        _BUROW,
    ),
    u_plasty,
    "the middle of the defect",
    "from the defect to the flap",
    "along",
    _BAKER + ".",
)
H_PLASTY = LibraryDesign(
    "h-plasty",
    "Bilateral advancement flaps (H-plasty)",
    "A square defect of forehead or upper lip, closed by skin drawn in from two sides.",
    (
        Parameter("width", "side of the square defect", "mm", 14.0, 3.0, 50.0, _BAKER),
        Parameter("length", "length of each flap, in widths", "", 1.25, 0.75, 4.0, _BAKER),
        _BUROW,
    ),
    h_plasty,
    "the middle of the defect",
    "from the defect to one of the flaps",
    "along",
    _BAKER + ".",
)
