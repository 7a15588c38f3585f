"""Events that change what the tissue is: what is cut, taken away, freed and thinned. Each begins an epoch.

All points are material (rest) coordinates in mm; times are USD time codes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

from lappet.procedure.exact_values import Point, double_point, set_fields, single_points

Basis = Literal["linear", "bspline", "catmullRom", "bezier"]


@dataclass(frozen=True)
class Incision:
    """A cut along a curve on the skin at rest.

    Parameters
    ----------
    name
        Name of the event, unique in the procedure.
    time
        Time code of the cut; it begins an epoch.
    points
        Control points of the curve in mm, shape (n, 3), kept in single precision.
    depth
        Depth in mm along the surface normal or the direction, or None to cut through.
    kerf
        Width of the cut in mm.
    basis
        How the curve runs through or beside its points, as USD's `basis`.
    closed
        Whether the curve returns to its first point.
    direction
        Direction in which the blade goes into the tissue, of any length, or None to cut square to the skin everywhere.
    """

    kind: ClassVar[str] = "Incision"
    name: str
    time: float
    points: tuple[Point, ...]
    depth: float | None = None
    kerf: float = 0.05
    basis: Basis = "linear"
    closed: bool = False
    direction: Point | None = None

    def __post_init__(self) -> None:
        set_fields(self, points=single_points(self.points))
        if self.direction is not None:
            set_fields(self, direction=double_point(self.direction))


@dataclass(frozen=True)
class Excision:
    """A removal of the fragments that hold the seed points.

    Parameters
    ----------
    name
        Name of the event, unique in the procedure.
    time
        Time code of the removal; it begins an epoch.
    seeds
        Material points in mm, shape (n, 3), kept in single precision; each selects the fragment that it lies in.
    """

    kind: ClassVar[str] = "Excision"
    name: str
    time: float
    seeds: tuple[Point, ...]

    def __post_init__(self) -> None:
        set_fields(self, seeds=single_points(self.seeds))


@dataclass(frozen=True)
class Undermine:
    """A release of the bed faces below the area inside a closed curve on the skin at rest.

    Parameters
    ----------
    name
        Name of the event, unique in the procedure.
    time
        Time code of the release; it begins an epoch.
    points
        Control points of the curve in mm, shape (n, 3), kept in single precision.
    basis
        How the curve runs through or beside its points, as USD's `basis`.
    """

    kind: ClassVar[str] = "Undermine"
    name: str
    time: float
    points: tuple[Point, ...]
    basis: Basis = "linear"

    def __post_init__(self) -> None:
        set_fields(self, points=single_points(self.points))


@dataclass(frozen=True)
class Thin:
    """A removal of the deep tissue below the area inside a closed curve on the skin at rest, as a flap is thinned.

    The tissue hangs on no bed there any more: its new underside rests on the ground that the tissue had before any cut,
    on which a bolster dressing presses it from then on.

    Parameters
    ----------
    name
        Name of the event, unique in the procedure.
    time
        Time code of the removal; it begins an epoch.
    points
        Control points of the curve in mm, shape (n, 3), kept in single precision.
    thickness
        What is left of the tissue below the skin in mm, skin included; where it is thinner nothing is removed.
    basis
        How the curve runs through or beside its points, as USD's `basis`.
    dressing
        Pressure of the dressing on the skin inside the curve in kPa, or 0 for none.
    duration
        How many time codes the dressing takes to press with all of it.
    """

    kind: ClassVar[str] = "Thin"
    name: str
    time: float
    points: tuple[Point, ...]
    thickness: float
    basis: Basis = "linear"
    dressing: float = 1.0
    duration: float = 4.0

    def __post_init__(self) -> None:
        set_fields(self, points=single_points(self.points))

    @property
    def pressed(self) -> str:
        """What the faces are called on which the dressing presses; no face subset can have that name."""
        return f"thin:{self.name}"


CUTS = (Incision, Excision, Undermine, Thin)  # these begin an epoch at their `time`
