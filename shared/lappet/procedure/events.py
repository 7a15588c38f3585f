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
    """A cut along a curve on the rest surface; depth in mm along the surface normal, None = through."""

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
    """Discards the fragments that hold the seed points."""

    kind: ClassVar[str] = "Excision"
    name: str
    time: float
    seeds: tuple[Point, ...]

    def __post_init__(self) -> None:
        set_fields(self, seeds=single_points(self.seeds))


@dataclass(frozen=True)
class Undermine:
    """Frees the bed faces below the area inside a closed curve on the rest surface."""

    kind: ClassVar[str] = "Undermine"
    name: str
    time: float
    points: tuple[Point, ...]
    basis: Basis = "linear"

    def __post_init__(self) -> None:
        set_fields(self, points=single_points(self.points))


@dataclass(frozen=True)
class Hook:
    """A spring (mN/mm) from a material point to a moving target; targets are (time, position) samples."""

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
    """Moves the surface points of the tissue subset `grip` rigidly.

    motion: (time, 4x4 row-major matrix in USD's row-vector convention) samples of the prim's own
    transform; what acts on the tissue is the transform relative to its value at `start`.
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
    """Draws two material points together from `start` over `duration`, then holds them."""

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
    """Material points to follow and measure."""

    kind: ClassVar[str] = "Landmark"
    name: str
    points: tuple[Point, ...]
    label: str

    def __post_init__(self) -> None:
        set_fields(self, points=single_points(self.points))


CUTS = (Incision, Excision, Undermine)  # these begin an epoch at their `time`


HOLDS = (Hook, Retractor)  # these act from `start` to `release`


Event = Incision | Excision | Undermine | Hook | Retractor | Suture | Landmark
