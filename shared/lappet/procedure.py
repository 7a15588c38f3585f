"""The procedure: plain values for a tissue, its materials and the timeline of surgical events.

Everything here is immutable and compares by value; an edit makes a new `Procedure` (see `lappet.history`). Units are
mm, kPa, mN and seconds; times are USD time codes; all points are material (rest) coordinates.

What USD holds in single precision (mesh points, texture coordinates, curves, seeds and landmarks) is rounded to single
precision here, at once, so that a procedure built by a script equals the one read back from its file. Arrays are copied
and read-only. Wrong values are accepted here and reported by `lappet.validation`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

Point = tuple[float, float, float]
Basis = Literal["linear", "bspline", "catmullRom", "bezier"]
MODELS = ("corotated", "neoHookean", "stableNeoHookean", "mooneyRivlin")


def _frozen(values: ArrayLike, kind: DTypeLike, width: int = 0) -> NDArray[Any]:
    """A read-only copy; floating-point values pass through single precision; (n, width) if a width is given."""
    if np.dtype(kind) == np.float64:
        with np.errstate(over="ignore"):
            values = np.asarray(values, np.float32)
    array = np.array(values, kind)
    if width and array.size == 0:
        array = array.reshape(0, width)
    array.flags.writeable = False
    return array


def _double(point: ArrayLike) -> Point:
    x, y, z = (float(v) + 0.0 for v in np.asarray(point, np.float64))  # + 0.0: there is no negative zero
    return (x, y, z)


def _single(points: ArrayLike) -> tuple[Point, ...]:
    with np.errstate(over="ignore"):
        rounded = np.asarray(points, np.float32).reshape(-1, 3)
    return tuple(_double(point) for point in rounded)


def _set(value: object, **fields: object) -> None:
    for name, content in fields.items():
        object.__setattr__(value, name, content)


def _same(a: NDArray[Any] | None, b: NDArray[Any] | None) -> bool:
    if a is None or b is None:
        return a is b
    return a.shape == b.shape and bool(np.array_equal(a, b, equal_nan=a.dtype.kind == "f"))


@dataclass(frozen=True)
class Material:
    """A hyperelastic material (`LappetMaterialAPI`); moduli in kPa, density in kg/m³.

    fiber_k1: kPa, 0 = no fibres. prestretch: in-vivo stretch along and across the fibre direction. muscle_stress: kPa,
    the greatest isometric stress of muscle along the fibre direction, 0 = no muscle. muscle_activation: (time, 0 to 1)
    samples, linear between and held at the ends; none = never active.
    """

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
    muscle_stress: float = 0.0
    muscle_activation: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        across = tuple(float(v) for v in self.prestretch)
        active = tuple((float(time) + 0.0, float(value) + 0.0) for time, value in self.muscle_activation)
        _set(self, fiber_direction=_double(self.fiber_direction), prestretch=across, muscle_activation=active)

    @property
    def has_fibers(self) -> bool:
        """Whether fibres stiffen it."""
        return self.fiber_k1 > 0.0

    @property
    def has_muscle(self) -> bool:
        """Whether it holds muscle, active or not."""
        return self.muscle_stress > 0.0

    @property
    def has_prestretch(self) -> bool:
        """Whether it is stretched in vivo."""
        return self.prestretch != (1.0, 1.0)

    @property
    def has_direction(self) -> bool:
        """Whether `fiber_direction` has an effect: it runs along the skin."""
        return self.has_fibers or self.has_muscle or self.has_prestretch


@dataclass(frozen=True)
class Region:
    """A part of the tissue that is of another material (`LappetRegionAPI` on a face subset).

    faces: the name of a subset of the tissue; of its faces those on the skin count. The region is what lies below them,
    from `depth_from` (included) to `depth_to` mm under the skin before any cut.
    """

    faces: str
    material: str
    depth_from: float = 0.0
    depth_to: float = math.inf


@dataclass(frozen=True, eq=False)
class Tissue:
    """A closed skin mesh at rest (`/Procedure/Tissue`).

    points: (n, 3) float64 in mm (float32-representable). face_vertex_counts: (m,) int32.
    face_vertex_indices: (k,) int32. uv: (k, 2) float32 per face corner, or None. subsets: face
    index arrays by name ("fixed", "bed", and those that retractors grip). spacing: lattice edge in
    mm. gravity: m/s² along -z, or None. bed_stiffness: kPa/mm (mN/mm³), the tie of bed faces to
    their rest position. regions: parts of other materials than `material`, one per subset, kept in the order of the
    subsets; where several hold a place, the last one does.
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
    regions: tuple[Region, ...] = ()

    def __post_init__(self) -> None:
        uv = None if self.uv is None else _frozen(self.uv, np.float32, 2)
        subsets = {name: _frozen(faces, np.int32) for name, faces in self.subsets.items()}
        _freeze_mesh(self)
        order = {name: i for i, name in enumerate(subsets)}  # as a stage has them: each on its subset's prim
        regions = tuple(sorted(self.regions, key=lambda region: order.get(region.faces, len(order))))
        _set(self, uv=uv, subsets=subsets, regions=regions)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Tissue):
            return NotImplemented
        return (
            (self.material, self.spacing, self.gravity, self.bed_stiffness, self.regions)
            == (other.material, other.spacing, other.gravity, other.bed_stiffness, other.regions)
            and _same_mesh(self, other)
            and _same(self.uv, other.uv)
            and list(self.subsets) == list(other.subsets)
            and all(_same(faces, other.subsets[name]) for name, faces in self.subsets.items())
        )

    def __hash__(self) -> int:
        return hash((self.points.shape, self.points.tobytes(), self.material, self.spacing))


@dataclass(frozen=True, eq=False)
class Bone:
    """A rigid mesh that the tissue may not enter (`/Procedure/Bone/<name>`)."""

    name: str
    points: NDArray[np.float64]
    face_vertex_counts: NDArray[np.int32]
    face_vertex_indices: NDArray[np.int32]

    def __post_init__(self) -> None:
        _freeze_mesh(self)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Bone):
            return NotImplemented
        return self.name == other.name and _same_mesh(self, other)

    def __hash__(self) -> int:
        return hash((self.name, self.points.shape, self.points.tobytes()))


def _freeze_mesh(mesh: Tissue | Bone) -> None:
    _set(
        mesh,
        points=_frozen(mesh.points, np.float64, 3),
        face_vertex_counts=_frozen(mesh.face_vertex_counts, np.int32),
        face_vertex_indices=_frozen(mesh.face_vertex_indices, np.int32),
    )


def _same_mesh(a: Tissue | Bone, b: Tissue | Bone) -> bool:
    return (
        _same(a.points, b.points)
        and _same(a.face_vertex_counts, b.face_vertex_counts)
        and _same(a.face_vertex_indices, b.face_vertex_indices)
    )


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
        _set(self, points=_single(self.points))


@dataclass(frozen=True)
class Excision:
    """Discards the fragments that hold the seed points."""

    kind: ClassVar[str] = "Excision"
    name: str
    time: float
    seeds: tuple[Point, ...]

    def __post_init__(self) -> None:
        _set(self, seeds=_single(self.seeds))


@dataclass(frozen=True)
class Undermine:
    """Frees the bed faces below the area inside a closed curve on the rest surface."""

    kind: ClassVar[str] = "Undermine"
    name: str
    time: float
    points: tuple[Point, ...]
    basis: Basis = "linear"

    def __post_init__(self) -> None:
        _set(self, points=_single(self.points))


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
        targets = tuple((float(time) + 0.0, _double(target)) for time, target in self.targets)
        _set(self, anchor=_double(self.anchor), targets=targets)


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
        _set(self, motion=motion)


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
        _set(self, anchors=(_double(first), _double(second)))


@dataclass(frozen=True)
class Landmark:
    """Material points to follow and measure."""

    kind: ClassVar[str] = "Landmark"
    name: str
    points: tuple[Point, ...]
    label: str

    def __post_init__(self) -> None:
        _set(self, points=_single(self.points))


CUTS = (Incision, Excision, Undermine)  # these begin an epoch at their `time`
HOLDS = (Hook, Retractor)  # these act from `start` to `release`
Event = Incision | Excision | Undermine | Hook | Retractor | Suture | Landmark


@dataclass(frozen=True, eq=False, repr=False)
class Procedure:
    """A tissue, its materials and the events of an operation; frames are the integer time codes.

    Events keep the order in which they are given (the order of the prims), whatever their times. `==` compares every
    value exactly; `repr` is a storyboard.
    """

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

    def event(self, name: str) -> Event:
        """The event of that name; KeyError if there is none."""
        for event in self.events:
            if event.name == name:
                return event
        raise KeyError(name)

    def material(self, name: str) -> Material:
        """The material of that name; KeyError if there is none."""
        for material in self.materials:
            if material.name == name:
                return material
        raise KeyError(name)

    def materials_in_use(self) -> tuple[Material, ...]:
        """The tissue's material, then those of its regions in their order, each once; names without one are left
        out."""
        names = dict.fromkeys([self.tissue.material, *(region.material for region in self.tissue.regions)])
        known = {material.name: material for material in reversed(self.materials)}
        return tuple(known[name] for name in names if name in known)

    def frames(self) -> range:
        """The frames: every whole time code from `start_time` to `end_time`, both included."""
        if not (math.isfinite(self.start_time) and math.isfinite(self.end_time)):
            return range(0)
        return range(math.ceil(self.start_time), math.floor(self.end_time) + 1)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Procedure):
            return NotImplemented
        return (
            (self.start_time, self.end_time, self.fps) == (other.start_time, other.end_time, other.fps)
            and self.events == other.events
            and self.materials == other.materials
            and self.bones == other.bones
            and self.tissue == other.tissue
        )

    def __hash__(self) -> int:
        return hash((self.tissue, self.materials, self.events, self.start_time, self.end_time))

    def __repr__(self) -> str:
        from lappet.storyboard import storyboard  # the values need no text until somebody asks for it

        return storyboard(self)
