"""The surgical events of a timeline: what is cut, freed, pulled, gripped, sewn and followed.

All points are material (rest) coordinates in mm; times are USD time codes; stiffness is in mN/mm.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

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
        Depth along the surface normal in mm, or None to cut through.
    kerf
        Width of the cut in mm.
    basis
        How the curve runs through or beside its points, as USD's `basis`.
    closed
        Whether the curve returns to its first point.
    """

    kind: ClassVar[str] = "Incision"
    name: str
    time: float
    points: tuple[Point, ...]
    depth: float | None = None
    kerf: float = 0.05
    basis: Basis = "linear"
    closed: bool = False

    def __post_init__(self) -> None:
        set_fields(self, points=single_points(self.points))


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
class Hook:
    """A spring from a material point to a moving target.

    Parameters
    ----------
    name
        Name of the event, unique in the procedure.
    anchor
        Material point on the tissue in mm.
    targets
        Samples (time code, position in mm) of the target; linear between them, held before and after.
    start
        Time code at which the hook begins to act.
    release
        Time code at which it lets go.
    stiffness
        Stiffness of the spring in mN/mm.
    """

    kind: ClassVar[str] = "Hook"
    name: str
    anchor: Point
    targets: tuple[tuple[float, Point], ...]
    start: float
    release: float
    stiffness: float = 500.0

    def __post_init__(self) -> None:
        targets = tuple((float(time) + 0.0, double_point(target)) for time, target in self.targets)
        set_fields(self, anchor=double_point(self.anchor), targets=targets)


@dataclass(frozen=True)
class Retractor:
    """A rigid motion of the surface points of a face subset.

    Parameters
    ----------
    name
        Name of the event, unique in the procedure.
    grip
        Name of the tissue's face subset whose points move.
    motion
        Samples (time code, 4 × 4 matrix) of the prim's own transform, 16 numbers, row-major, in USD's row-vector
        convention. What acts on the tissue is the transform relative to its value at `start`.
    start
        Time code at which the grip begins.
    release
        Time code at which it ends.
    """

    kind: ClassVar[str] = "Retractor"
    name: str
    grip: str
    motion: tuple[tuple[float, tuple[float, ...]], ...]
    start: float
    release: float

    def __post_init__(self) -> None:
        motion = tuple(
            (float(time) + 0.0, tuple(float(v) + 0.0 for v in np.asarray(matrix, np.float64).reshape(-1)))
            for time, matrix in self.motion
        )
        set_fields(self, motion=motion)


@dataclass(frozen=True)
class Suture:
    """A stitch that draws two material points together and then holds them.

    Parameters
    ----------
    name
        Name of the event, unique in the procedure.
    anchors
        The two material points in mm.
    start
        Time code at which drawing together begins.
    duration
        How many time codes it takes.
    stiffness
        Stiffness in mN/mm.
    """

    kind: ClassVar[str] = "Suture"
    name: str
    anchors: tuple[Point, Point]
    start: float
    duration: float = 1.0
    stiffness: float = 1000.0

    def __post_init__(self) -> None:
        first, second = self.anchors
        set_fields(self, anchors=(double_point(first), double_point(second)))


@dataclass(frozen=True)
class Landmark:
    """Material points to follow and measure.

    Parameters
    ----------
    name
        Name of the event, unique in the procedure.
    points
        Material points in mm, shape (n, 3), kept in single precision.
    label
        What reports and figures call them.
    """

    kind: ClassVar[str] = "Landmark"
    name: str
    points: tuple[Point, ...]
    label: str

    def __post_init__(self) -> None:
        set_fields(self, points=single_points(self.points))


CUTS = (Incision, Excision, Undermine)  # these begin an epoch at their `time`


HOLDS = (Hook, Retractor)  # these act from `start` to `release`


Event = Incision | Excision | Undermine | Hook | Retractor | Suture | Landmark
