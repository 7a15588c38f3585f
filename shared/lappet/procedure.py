"""The procedure: plain values for a tissue, its materials and the timeline of surgical events.

Everything here is immutable; an edit makes a new `Procedure` (see `lappet.history`). Units are mm, kPa,
mN and seconds; times are USD time codes; all points are material (rest) coordinates.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

Point = tuple[float, float, float]
Basis = Literal["linear", "bspline", "catmullRom", "bezier"]
MODELS = ("corotated", "neoHookean", "stableNeoHookean", "mooneyRivlin")


@dataclass(frozen=True)
class Material:
    """A hyperelastic material (`LappetMaterialAPI`); moduli in kPa, density in kg/m³."""

    name: str = "skin"
    model: str = "neoHookean"
    youngs_modulus: float = 50.0
    poissons_ratio: float = 0.45
    mooney_ratio: float = 0.0
    fiber_k1: float = 0.0
    fiber_k2: float = 0.0
    fiber_dispersion: float = 0.0
    fiber_direction: Point = (1.0, 0.0, 0.0)
    prestretch: tuple[float, float] = (1.0, 1.0)
    density: float = 1100.0


@dataclass(frozen=True, eq=False)
class Tissue:
    """A closed skin mesh at rest (`/Procedure/Tissue`).

    points: (n, 3) float64 in mm (float32-representable). face_vertex_counts: (m,) int32.
    face_vertex_indices: (k,) int32. uv: (k, 2) float32 per face corner, or None. subsets: face
    index arrays by name ("fixed", "bed", and those that retractors grip). spacing: lattice edge in
    mm. gravity: m/s² along -z, or None. bed_stiffness: kPa/mm (mN/mm³), the tie of bed faces to
    their rest position.
    """

    points: NDArray[np.float64]
    face_vertex_counts: NDArray[np.int32]
    face_vertex_indices: NDArray[np.int32]
    uv: NDArray[np.float32] | None = None
    subsets: dict[str, NDArray[np.int32]] = field(default_factory=dict)
    material: str = "skin"
    spacing: float = 1.0
    gravity: float | None = None
    bed_stiffness: float = 10.0


@dataclass(frozen=True, eq=False)
class Bone:
    """A rigid mesh that the tissue may not enter (`/Procedure/Bone/<name>`)."""

    name: str
    points: NDArray[np.float64]
    face_vertex_counts: NDArray[np.int32]
    face_vertex_indices: NDArray[np.int32]


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


@dataclass(frozen=True)
class Excision:
    """Discards the fragments that hold the seed points."""

    kind: ClassVar[str] = "Excision"
    name: str
    time: float
    seeds: tuple[Point, ...]


@dataclass(frozen=True)
class Undermine:
    """Frees the bed faces below the area inside a closed curve on the rest surface."""

    kind: ClassVar[str] = "Undermine"
    name: str
    time: float
    points: tuple[Point, ...]
    basis: Basis = "linear"


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


@dataclass(frozen=True)
class Suture:
    """Draws two material points together from `start` over `duration`, then holds them."""

    kind: ClassVar[str] = "Suture"
    name: str
    anchors: tuple[Point, Point]
    start: float
    duration: float = 1.0
    stiffness: float = 1000.0


@dataclass(frozen=True)
class Landmark:
    """Material points to follow and measure."""

    kind: ClassVar[str] = "Landmark"
    name: str
    points: tuple[Point, ...]
    label: str


Event = Incision | Excision | Undermine | Hook | Retractor | Suture | Landmark


@dataclass(frozen=True, eq=False)
class Procedure:
    """A tissue, its materials and the events of an operation; frames are the integer time codes."""

    tissue: Tissue
    materials: tuple[Material, ...] = (Material(),)
    events: tuple[Event, ...] = ()
    bones: tuple[Bone, ...] = ()
    start_time: float = 1.0
    end_time: float = 1.0
    fps: float = 24.0

    def with_events(self, *events: Event) -> Procedure:
        """The same procedure with these events added."""
        return replace(self, events=(*self.events, *events))
