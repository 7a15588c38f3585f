"""Several Limberg flaps for one defect: three for a round one, two for an oblong one.

A hexagon around a round defect is three rhombi of 60° and 120° with one corner at its middle; a parallelogram with one
side twice as long as the other is two, beside each other. Each rhombus has its Limberg flap
(`lappet.designs.rhombic_flap`): from its obtuse corner D on the rim the first limb DE extends the short diagonal BD,
the second, EF, runs parallel to the side DC, and the flap turns about C. B is not on the rim: there the flaps meet, the
first limb of one on the first side of the next.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.designs.design_axes import DesignPlane, require_lengths, skin_axes
from lappet.designs.flap_design import Carry, Corner, Edge, FlapDesign, Seam, Spot
from lappet.designs.flat_curves import NICK, polyline, segment
from lappet.designs.library_design import LibraryDesign, Parameter
from lappet.tissue.placement import Place


def triple_rhombic(
    center: ArrayLike,
    direction: ArrayLike,
    diameter: float,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design three Limberg flaps around a round defect.

    Parameters
    ----------
    center
        Middle of the defect in mm, shape (3,).
    direction
        Direction from there to the first limb of one of the flaps, shape (3,).
    diameter
        Diameter of the defect in mm; the hexagon's sides touch it.
    normal
        Outwards from the skin at the middle, shape (3,).
    mirrored
        Whether the flaps turn the other way.
    project
        Maps points (k, 3) onto a curved skin, as `draped_on` gives, or None.

    Returns
    -------
    FlapDesign
        The design.

    Raises
    ------
    RefusedError
        If the diameter is not positive.
    """
    require_lengths("triple_rhombic", diameter=diameter)
    side = diameter / np.sqrt(3.0)
    plane = DesignPlane.at(center, skin_axes(direction, normal, "triple_rhombic"), mirrored, project)
    rim = [side * _direction(60.0 * k) for k in range(6)]
    flaps = [_Flap.beside(rim[2 * k + 1], np.zeros(2), rim[2 * k - 1], rim[2 * k]) for k in range(3)]
    # DE of a flap comes to lie on BA, and there is the side CD of the flap that turns about A.
    between = [
        Seam(f"between_{k + 1}", (flaps[k].first(plane), flaps[(k + 1) % 3].near(plane, from_shoulder=True)))
        for k in range(3)
    ]
    return _design(plane, polyline(*rim, rim[0])[:-1], flaps, between, on_rim=False)


def double_rhombic(
    center: ArrayLike,
    direction: ArrayLike,
    side: float,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    mirrored: bool = False,
    project: Place | None = None,
) -> FlapDesign:
    """Design two opposed Limberg flaps for an oblong defect.

    Parameters
    ----------
    center
        Middle of the defect in mm, shape (3,).
    direction
        Direction of its long sides, shape (3,).
    side
        Short side of the parallelogram in mm; the other is twice as long.
    normal
        Outwards from the skin at the middle, shape (3,).
    mirrored
        Whether the flaps turn the other way.
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
    require_lengths("double_rhombic", side=side)
    plane = DesignPlane.at(center, skin_axes(direction, normal, "double_rhombic"), mirrored, project)
    half = 0.5 * side * _direction(60.0)
    far = side * _direction(0.0)
    a, b, c, d = half, -half, -half - far, half - far  # the left rhombus; A and B are the ends of the common side
    flaps = [_Flap.beside(a, b, c, d), _Flap.beside(-a, -b, -c, -d)]
    between = [Seam("between", (flaps[0].first(plane), flaps[1].first(plane, from_tip=True)))]
    near = [
        Seam(f"near_{k + 1}", (flap.near(plane), plane.edge_beside(segment(flap.c, flap.b), flap.c + flap.b - flap.d)))
        for k, flap in enumerate(flaps)
    ]
    outline = polyline(c, b, -d, -c, a, d, c)[:-1]
    return _design(plane, outline, flaps, [*between, *near], on_rim=True)


@dataclass(frozen=True, eq=False)
class _Flap:
    """A Limberg flap and its rhombus, corners in the plane in mm, shape (2,): a, b, c, d, and e, f of the flap."""

    a: NDArray[np.float64]
    b: NDArray[np.float64]
    c: NDArray[np.float64]
    d: NDArray[np.float64]
    e: NDArray[np.float64]
    f: NDArray[np.float64]

    @classmethod
    def beside(
        cls, a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64], d: NDArray[np.float64]
    ) -> _Flap:
        """The flap at the corner d of a rhombus."""
        return cls(a, b, c, d, 2.0 * d - b, 2.0 * d - b + c - d)

    @property
    def middle(self) -> NDArray[np.float64]:
        return (self.c + self.d + self.e + self.f) / 4.0

    def first(self, plane: DesignPlane, from_tip: bool = False) -> Edge:
        """Its edge along the first limb."""
        ends = (self.e, self.d) if from_tip else (self.d, self.e)
        return plane.edge_beside(segment(*ends), self.middle)

    def near(self, plane: DesignPlane, from_shoulder: bool = False) -> Edge:
        """Its edge along the defect."""
        ends = (self.d, self.c) if from_shoulder else (self.c, self.d)
        return plane.edge_beside(segment(*ends), self.middle)

    def seams(self, plane: DesignPlane, number: int) -> tuple[Seam, Seam]:
        """The donor site's, and that of the second limb with the defect's rim."""

        def lip(start: NDArray[np.float64], end: NDArray[np.float64], across: NDArray[np.float64]) -> Edge:
            return plane.edge_beside(segment(start, end), start + end - across)

        second = plane.edge_beside(segment(self.e, self.f), self.middle)
        donor = lip(self.e, self.d, self.middle), lip(self.e, self.f, self.middle)
        return Seam(f"donor_{number}", donor), Seam(f"end_{number}", (second, lip(self.a, self.d, self.b)))

    def corners(self, plane: DesignPlane, number: int) -> tuple[Corner, Corner]:
        """Those of the donor site, and of the tip with the rim."""
        out = self.a + self.e - self.d  # halves the corner at d outside of the flap
        donor = Corner(f"donor_{number}", plane.spot(self.d, out), plane.spot(self.f, 2.0 * self.f - self.e))
        return donor, Corner(f"tip_{number}", self.tip(plane), plane.spot(self.a, 2.0 * self.a - self.b))

    def tip(self, plane: DesignPlane) -> Spot:
        """Its corner at the end of the first limb."""
        return plane.spot(self.e, self.middle)

    def shoulder(self, plane: DesignPlane) -> Spot:
        """Its corner on the rim."""
        return plane.spot(self.d, self.middle)

    def carries(self, plane: DesignPlane, number: int) -> tuple[Carry, Carry]:
        """How hooks turn it about c."""
        inside, pivot = 0.25 * (self.a + self.b + self.c + self.d), plane.point(self.c)
        return (
            Carry(f"tip_{number}", self.tip(plane), pivot, plane.spot(self.a, inside)),
            Carry(f"shoulder_{number}", self.shoulder(plane), pivot, plane.spot(self.b, inside)),
        )


def _design(
    plane: DesignPlane, outline: NDArray[np.float64], flaps: list[_Flap], seams: list[Seam], on_rim: bool
) -> FlapDesign:
    """The design of a defect and its flaps, whose shoulders meet the rim or each other."""
    numbered = list(enumerate(flaps, 1))
    shoulders = [flap.shoulder(plane) for flap in flaps]
    if on_rim:
        meets = [plane.spot(flap.b, 2.0 * flap.b - flap.a) for flap in flaps]
    else:
        meets = [*shoulders[1:], shoulders[0]]
    pairs = [Corner(f"shoulder_{k}", *pair) for k, pair in enumerate(zip(shoulders, meets, strict=True), 1)]
    cuts = [
        np.vstack([(flap.d + NICK * _unit(flap.b - flap.d))[None], polyline(flap.d, flap.e, flap.f)]) for flap in flaps
    ]
    return FlapDesign(
        excised=(plane.excised("defect", outline, np.zeros(2)),),
        incisions=tuple(plane.points(cut) for cut in cuts),
        seams=(*(seam for k, flap in numbered for seam in flap.seams(plane, k)), *seams),
        corners=(*(corner for k, flap in numbered for corner in flap.corners(plane, k)), *pairs),
        carries=tuple(carry for k, flap in numbered for carry in flap.carries(plane, k)),
        flaps=tuple(plane.point(flap.middle) for flap in flaps),
    )


def _direction(angle: float) -> NDArray[np.float64]:
    return np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])


def _unit(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    return vector / np.linalg.norm(vector)


_LIMBERG = "A. A. Limberg, The planning of local plastic operations on the body surface (1963; not read)"
_BAKER = "S. R. Baker, Local Flaps in Facial Reconstruction, on multiple rhombic flaps (not read)"
DOUBLE_RHOMBIC = LibraryDesign(
    "double-rhombic",
    "Double rhombic flap",
    "An oblong defect of cheek, trunk or limb: two opposed Limberg flaps share its closure.",
    (Parameter("side", "short side of the parallelogram; the other is twice as long", "mm", 13.0, 4.0, 50.0, _BAKER),),
    double_rhombic,
    "the middle of the defect",
    "the long sides of the defect",
    "",
    _BAKER + "; each flap as in " + _LIMBERG + ".",
)
TRIPLE_RHOMBIC = LibraryDesign(
    "triple-rhombic",
    "Triple rhombic flap",
    "A large round defect of scalp, trunk or limb with slack skin all around: three Limberg flaps around a hexagon.",
    (Parameter("diameter", "diameter of the defect, which the hexagon's sides touch", "mm", 20.0, 5.0, 80.0, _BAKER),),
    triple_rhombic,
    "the middle of the defect",
    "from there to the first limb of one of the flaps",
    "",
    _BAKER + "; each flap as in " + _LIMBERG + ".",
)
