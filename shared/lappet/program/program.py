"""The program: what the daemon is told. Epochs of constant topology and, per frame, the constraints."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lappet.cutting.epoch import Epoch, no_entries


@dataclass(frozen=True)
class MaterialParameters:
    """A material as the daemon is told it: a map of the list `materials` of `open` (PROTOCOL.md).

    youngs_modulus, fibre_k1, muscle_stress: kPa. density: kg/m³. fibre_direction: of length 1.
    """

    model: str = "neoHookean"
    youngs_modulus: float = 50.0
    poissons_ratio: float = 0.45
    density: float = 1100.0
    mooney_ratio: float = 0.0
    fibre_direction: tuple[float, float, float] = (1.0, 0.0, 0.0)
    fibre_k1: float = 0.0
    fibre_k2: float = 0.0
    fibre_dispersion: float = 0.0
    muscle_stress: float = 0.0
    prestretch: tuple[float, float] = (1.0, 1.0)


@dataclass(frozen=True, eq=False)
class Bones:
    """What the tissue may not enter: all bones as one closed triangle surface; without triangles: none.

    points: (b, 3) float64, mm. triangles: (c, 3) int32.
    """

    points: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    triangles: NDArray[np.int32] = field(default_factory=lambda: no_entries((0, 3), np.int32))


@dataclass(frozen=True)
class SolverSettings:
    """How a session solves: `settings` and `materials` of `open` (PROTOCOL.md).

    spacing: lattice edge, mm. fine_ratio: fine voxels per lattice edge. origin: a grid point, mm. quadrature: points
    per cell (1, 4 or 8). precision: "float" or "double". tolerance: residual over force scale. gap_tolerance: largest
    suture and grip gap as a fraction of the spacing. bed_stiffness: kPa/mm. gravity: m/s². time_budget: s per frame, 0
    = none. memory_budget: bytes. threads: 0 = all. sutures, retractors: their numbers in the whole procedure.
    preconditioner: "chebyshev" leaves out the coarse space. correction: frames carry the Newton step left over, from
    which the algebraic error is estimated. strain: frames carry strain, stress and tension. region: "auto"
    solves a frame where its changes reach, "whole" everywhere. materials: the tissue's first, then those of its
    regions.
    """

    spacing: float = 1.0
    fine_ratio: int = 4
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    quadrature: int = 1
    precision: Literal["float", "double"] = "float"
    tolerance: float = 1e-3
    gap_tolerance: float = 1e-3
    max_newton: int = 100
    bed_stiffness: float = 10.0
    gravity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    time_budget: float = 0.0
    memory_budget: int = 8 << 30
    threads: int = 0
    sutures: int = 0
    retractors: int = 0
    preconditioner: Literal["twoLevel", "chebyshev"] = "twoLevel"
    correction: bool = False
    strain: bool = True
    region: Literal["auto", "whole"] = "auto"
    materials: tuple[MaterialParameters, ...] = (MaterialParameters(),)


@dataclass(frozen=True, eq=False)
class FrameConstraints:
    """What acts on the tissue in one frame: the arrays of the message `solve` (PROTOCOL.md) under their own names.

    time: time code. epoch: index of the epoch that the frame belongs to.

    Hooks (H): hook_anchors (H, 3) float64 rest points in mm; hook_triangles (H,) int32, the triangle of the epoch's
    surface under each; hook_targets (H, 3) float64 mm; hook_stiffness (H,) float64 mN/mm.
    Sutures placed by now (A): suture_index (A,) int32 in the procedure; suture_anchors (A, 2, 3) float64 rest points;
    suture_triangles (A, 2) int32; suture_closure (A,) float64, 0 = as placed, 1 = drawn together; suture_stiffness (A,)
    float64 mN/mm.
    Active retractors (R): retractor_index (R,) int32; retractor_motion (R, 4, 4) float64, column-vector convention (the
    translation is the last column, mm), relative to the retractor's start.
    activation (M,) float64, 0 to 1: of each material's muscle; empty where no material has any.
    """

    time: float
    epoch: int
    hook_anchors: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    hook_triangles: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))
    hook_targets: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    hook_stiffness: NDArray[np.float64] = field(default_factory=lambda: no_entries((0,), np.float64))
    suture_index: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))
    suture_anchors: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 2, 3), np.float64))
    suture_triangles: NDArray[np.int32] = field(default_factory=lambda: no_entries((0, 2), np.int32))
    suture_closure: NDArray[np.float64] = field(default_factory=lambda: no_entries((0,), np.float64))
    suture_stiffness: NDArray[np.float64] = field(default_factory=lambda: no_entries((0,), np.float64))
    retractor_index: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))
    retractor_motion: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 4, 4), np.float64))
    activation: NDArray[np.float64] = field(default_factory=lambda: no_entries((0,), np.float64))


@dataclass(frozen=True, eq=False)
class Landmarks:
    """The landmarks that an epoch's tissue still holds.

    index: (k,) int32 into `Program.landmarks`. points: (k, 3) float64 rest points, mm. triangles: (k,) int32, the
    triangle of the epoch's surface under each.
    """

    index: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))
    points: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    triangles: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))


@dataclass(frozen=True, eq=False)
class Program:
    """A compiled procedure (`lappet.program.compile.compile_program`).

    epochs: in order of time. frames: one per integer time code. bones: the same in all of them. active_hooks: per frame
    the (H,) indices into `hooks` of the rows of its hook arrays. grips: per epoch (m,) int32, the retractor that grips
    each triangle, or -1; only retractors that act in the epoch. landmarks_at: per epoch. fps: time codes per second.

    Names of prims: hooks in the procedure's order; sutures and retractors in order of their start, so that what is
    added to the end of the timeline renumbers nothing before it. landmarks: a label per landmark point. notes:
    sentences about what the procedure holds and the solve leaves out.
    """

    epochs: tuple[Epoch, ...]
    frames: tuple[FrameConstraints, ...]
    settings: SolverSettings
    bones: Bones = field(default_factory=Bones)
    fps: float = 24.0
    hooks: tuple[str, ...] = ()
    sutures: tuple[str, ...] = ()
    retractors: tuple[str, ...] = ()
    landmarks: tuple[str, ...] = ()
    active_hooks: tuple[NDArray[np.int32], ...] = ()
    grips: tuple[NDArray[np.int32], ...] = ()
    landmarks_at: tuple[Landmarks, ...] = ()
    notes: tuple[str, ...] = ()
