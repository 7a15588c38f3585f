"""What an operation is done on: tissue with its materials and material regions, and bones. Units are mm and kPa."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lappet.procedure.exact_values import Point, double_point, frozen, same_array, set_fields
from lappet.procedure.position import POSITIONS

MODELS = ("corotated", "neoHookean", "stableNeoHookean", "mooneyRivlin")


@dataclass(frozen=True)
class Material:
    """A hyperelastic material (`LappetMaterialAPI`).

    Parameters
    ----------
    name
        Name of the material, unique in the procedure.
    model
        One of `MODELS`.
    youngs_modulus
        Young's modulus in kPa.
    poissons_ratio
        Poisson's ratio, 0 to 0.4999.
    mooney_ratio
        Ratio μ₀₁/μ₁₀ of `mooneyRivlin`, at least 0.
    fiber_k1
        Stiffness of the fibers in kPa; 0 for none.
    fiber_k2
        How the fibers stiffen, at least 0, without unit.
    fiber_dispersion
        Dispersion of the fibers, from 0 (aligned) to 1/3 (isotropic).
    fiber_slack
        Stretch from which the fibers bear load, at least 1: crimped fibers are straightened before.
    fiber_angle
        Angle in degrees, 0 to 90, at which half of the fibers and of the muscle run to the direction, to either side in
        the plane of the skin; 0 for one family.
    fiber_direction
        Direction of fibers, muscle and prestretch at rest.
    prestretch
        In-vivo stretch along and across the fiber direction, 1 for none.
    density
        Density in kg/m³.
    muscle_stress
        Greatest isometric stress of muscle along the fiber direction in kPa; 0 for no muscle.
    muscle_activation
        Samples (time code, activation from 0 to 1), linear between and held at the ends; none for a muscle that is
        never active.
    """

    name: str = "skin"
    model: str = "neoHookean"
    youngs_modulus: float = 50.0
    poissons_ratio: float = 0.45
    mooney_ratio: float = 0.0
    fiber_k1: float = 0.0
    fiber_k2: float = 0.0
    fiber_dispersion: float = 0.0
    fiber_slack: float = 1.0
    fiber_angle: float = 0.0
    fiber_direction: Point = (1.0, 0.0, 0.0)
    prestretch: tuple[float, float] = (1.0, 1.0)
    density: float = 1100.0
    muscle_stress: float = 0.0
    muscle_activation: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        across = tuple(float(v) for v in self.prestretch)
        active = tuple((float(time) + 0.0, float(value) + 0.0) for time, value in self.muscle_activation)
        set_fields(
            self, fiber_direction=double_point(self.fiber_direction), prestretch=across, muscle_activation=active
        )

    @property
    def has_fibers(self) -> bool:
        """Whether fibers stiffen the material."""
        return self.fiber_k1 > 0.0

    @property
    def has_muscle(self) -> bool:
        """Whether the material holds muscle, active or not."""
        return self.muscle_stress > 0.0

    @property
    def has_prestretch(self) -> bool:
        """Whether the material is stretched in vivo."""
        return self.prestretch != (1.0, 1.0)

    @property
    def has_direction(self) -> bool:
        """Whether `fiber_direction` has an effect."""
        return self.has_fibers or self.has_muscle or self.has_prestretch


# J-shaped: soft until its crimped fibers straighten. `lappet.tissue.presets` says where the numbers come from.
DEFAULT_SKIN = Material(
    "skin", poissons_ratio=0.49, fiber_k1=200.0, fiber_k2=1.0, fiber_dispersion=0.25, fiber_slack=1.05
)


@dataclass(frozen=True)
class Region:
    """A part of the tissue that is of another material (`LappetRegionAPI` on a face subset).

    Parameters
    ----------
    faces
        Name of a face subset of the tissue; of its faces those on the skin count. The region is what lies below them.
    material
        Name of the region's material.
    depth_from
        Least depth below the skin before any cut in mm, included.
    depth_to
        Greatest depth in mm, not included.
    """

    faces: str
    material: str
    depth_from: float = 0.0
    depth_to: float = math.inf


@dataclass(frozen=True)
class Roller:
    """Faces that slide in their plane and do not leave it (`LappetRollerAPI` on a face subset).

    Parameters
    ----------
    faces
        Name of a face subset of the tissue.
    normal
        Direction in which they do not move, of any length: that of a plane of symmetry. None for that of each face's
        normal at rest.
    """

    faces: str
    normal: Point | None = None

    def __post_init__(self) -> None:
        set_fields(self, normal=None if self.normal is None else double_point(self.normal))


@dataclass(frozen=True, eq=False)
class Tissue:
    """A closed mesh of tissue at rest (`/Procedure/Tissue`).

    Parameters
    ----------
    points
        Vertices in mm, shape (n, 3), float64 that single precision can hold.
    face_vertex_counts
        Corners of each face, shape (m,), int32.
    face_vertex_indices
        Vertices of the faces one after another, shape (k,), int32.
    uv
        Texture coordinates of each face corner, shape (k, 2), float32, or None.
    subsets
        Face indices by name: "fixed" (held in space), "bed" (attached to deep tissue), "rim", "underside", those that
        retractors grip, those of regions and rollers, and those that loads act on.
    material
        Name of the material of what no region holds.
    spacing
        Edge of the lattice's cells in mm.
    gravity
        Acceleration of gravity in m/s², 0 for none.
    gravity_direction
        Direction in which gravity pulls, of any length: how the patient lies, see `lappet.procedure.position`.
    bed_stiffness
        Stiffness of the bed along its normal in kPa/mm (mN/mm³): of attached faces both ways, of undermined ones
        where they sink.
    bed_shear
        Stiffness of the bed in its plane in kPa/mm, at most `bed_stiffness`: of attached faces.
    regions
        Parts of other materials, one per subset, kept in the order of the subsets; where several hold a place, the last
        one does.
    rollers
        Faces that slide, one per subset, kept in the order of the subsets.
    self_contact
        Whether its surface is kept from passing through itself.
    """

    points: NDArray[np.float64]
    face_vertex_counts: NDArray[np.int32]
    face_vertex_indices: NDArray[np.int32]
    uv: NDArray[np.float32] | None = None
    subsets: dict[str, NDArray[np.int32]] = field(default_factory=dict)
    material: str = "skin"
    spacing: float = 1.0
    gravity: float = 9.81
    gravity_direction: Point = POSITIONS["upright"]
    bed_stiffness: float = 19.0
    bed_shear: float = 0.375
    regions: tuple[Region, ...] = ()
    rollers: tuple[Roller, ...] = ()
    self_contact: bool = False

    def __post_init__(self) -> None:
        uv = None if self.uv is None else frozen(self.uv, np.float32, 2)
        subsets = {name: frozen(faces, np.int32) for name, faces in self.subsets.items()}
        _freeze_mesh(self)
        order = {name: i for i, name in enumerate(subsets)}  # as a stage has them: each on its subset's prim
        regions = tuple(sorted(self.regions, key=lambda region: order.get(region.faces, len(order))))
        rollers = tuple(sorted(self.rollers, key=lambda roller: order.get(roller.faces, len(order))))
        down = double_point(self.gravity_direction)
        set_fields(self, uv=uv, subsets=subsets, regions=regions, rollers=rollers, gravity_direction=down)

    @property
    def has_gravity(self) -> bool:
        """Whether the tissue has weight."""
        return self.gravity != 0.0

    @property
    def gravity_vector(self) -> Point:
        """Acceleration of gravity in m/s², shape (3,)."""
        length = math.hypot(*self.gravity_direction)
        if not (self.has_gravity and length > 0.0):
            return (0.0, 0.0, 0.0)
        x, y, z = (self.gravity * value / length + 0.0 for value in self.gravity_direction)
        return (x, y, z)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Tissue):
            return NotImplemented
        return (
            all(getattr(self, name) == getattr(other, name) for name in _PLAIN_FIELDS)
            and _same_mesh(self, other)
            and same_array(self.uv, other.uv)
            and list(self.subsets) == list(other.subsets)
            and all(same_array(faces, other.subsets[name]) for name, faces in self.subsets.items())
        )

    def __hash__(self) -> int:
        return hash((self.points.shape, self.points.tobytes(), self.material, self.spacing))


_PLAIN_FIELDS = (
    "material",
    "spacing",
    "gravity",
    "gravity_direction",
    "bed_stiffness",
    "bed_shear",
    "regions",
    "rollers",
    "self_contact",
)


@dataclass(frozen=True, eq=False)
class Bone:
    """A rigid mesh that the tissue may not enter (`/Procedure/Bone/<name>`).

    Parameters
    ----------
    name
        Name of the bone, unique in the procedure.
    points
        Vertices in mm, shape (n, 3), float64 that single precision can hold.
    face_vertex_counts
        Corners of each face, shape (m,), int32.
    face_vertex_indices
        Vertices of the faces one after another, shape (k,), int32.
    motion
        Samples (time code, row-major 4 × 4 matrix in USD's row-vector convention, mm) of its rigid motion from where
        its points are: the identity at the procedure's start. Between samples the translation of its origin is linear
        and it turns along the shortest way; without samples it stays.
    """

    name: str
    points: NDArray[np.float64]
    face_vertex_counts: NDArray[np.int32]
    face_vertex_indices: NDArray[np.int32]
    motion: tuple[tuple[float, tuple[float, ...]], ...] = ()

    def __post_init__(self) -> None:
        _freeze_mesh(self)
        motion = tuple(
            (float(time) + 0.0, tuple(float(v) + 0.0 for v in np.ravel(matrix))) for time, matrix in self.motion
        )
        set_fields(self, motion=motion)

    @property
    def moves(self) -> bool:
        """Whether it is ever elsewhere than its points."""
        return len({matrix for _, matrix in self.motion}) > 1

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Bone):
            return NotImplemented
        return self.name == other.name and self.motion == other.motion and _same_mesh(self, other)

    def __hash__(self) -> int:
        return hash((self.name, self.points.shape, self.points.tobytes()))


def _freeze_mesh(mesh: Tissue | Bone) -> None:
    set_fields(
        mesh,
        points=frozen(mesh.points, np.float64, 3),
        face_vertex_counts=frozen(mesh.face_vertex_counts, np.int32),
        face_vertex_indices=frozen(mesh.face_vertex_indices, np.int32),
    )


def _same_mesh(a: Tissue | Bone, b: Tissue | Bone) -> bool:
    return (
        same_array(a.points, b.points)
        and same_array(a.face_vertex_counts, b.face_vertex_counts)
        and same_array(a.face_vertex_indices, b.face_vertex_indices)
    )
