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

    Parameters
    ----------
    model
        Name of the model.
    youngs_modulus
        Young's modulus in kPa.
    poissons_ratio
        Poisson's ratio.
    density
        Density in kg/m³.
    mooney_ratio
        Ratio μ₀₁/μ₁₀.
    fibre_direction
        Unit vector along the fibers at rest.
    fibre_k1
        Stiffness of the fibers in kPa; 0 for none.
    fibre_k2
        How the fibers stiffen, without unit.
    fibre_dispersion
        Dispersion of the fibers, 0 to 1/3.
    muscle_stress
        Greatest isometric stress of muscle in kPa; 0 for no muscle.
    prestretch
        In-vivo stretch along and across the direction.
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

    Parameters
    ----------
    points
        Vertices in mm, shape (b, 3), float64.
    triangles
        Vertex indices, shape (c, 3), int32.
    """

    points: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    triangles: NDArray[np.int32] = field(default_factory=lambda: no_entries((0, 3), np.int32))


@dataclass(frozen=True)
class SolverSettings:
    """How a session solves: `settings` and `materials` of `open` (PROTOCOL.md).

    Parameters
    ----------
    spacing
        Edge of the lattice's cells in mm.
    fine_ratio
        Fine voxels per lattice edge.
    origin
        A point of the grid in mm.
    quadrature
        Quadrature points of a cell: 1, 4 or 8.
    precision
        Arithmetic of the solver.
    tolerance
        Residual over force scale at which a frame has converged.
    gap_tolerance
        Largest suture and grip gap, as a fraction of the spacing.
    max_newton
        Newton iterations of a frame at most.
    bed_stiffness
        Stiffness of the bed in kPa/mm.
    gravity
        Gravity in m/s².
    time_budget
        Seconds per frame; 0 for no limit.
    memory_budget
        Memory in bytes.
    threads
        Number of threads; 0 for all.
    sutures
        Number of sutures in the whole procedure.
    retractors
        Number of retractors in the whole procedure.
    preconditioner
        The preconditioner; "chebyshev" leaves out the coarse space.
    correction
        Whether frames carry the Newton step left over, from which the algebraic error is estimated.
    strain
        Whether frames carry strain, stress and tension.
    region
        Where a frame is solved: "auto" where its changes reach, "whole" everywhere.
    materials
        The tissue's material first, then those of its regions.
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

    There are H hooks, A sutures that are placed by now, R active retractors and M materials.

    Parameters
    ----------
    time
        Time code.
    epoch
        Index of the epoch that the frame belongs to.
    hook_anchors
        Rest points in mm, shape (H, 3), float64.
    hook_triangles
        Triangle of the epoch's surface under each, shape (H,), int32.
    hook_targets
        Targets in mm, shape (H, 3), float64.
    hook_stiffness
        Stiffness in mN/mm, shape (H,), float64.
    suture_index
        Index of each suture in the procedure, shape (A,), int32.
    suture_anchors
        Rest points in mm, shape (A, 2, 3), float64.
    suture_triangles
        Triangles under them, shape (A, 2), int32.
    suture_closure
        Closure from 0 (as placed) to 1 (drawn together), shape (A,), float64.
    suture_stiffness
        Stiffness in mN/mm, shape (A,), float64.
    retractor_index
        Index of each retractor in the procedure, shape (R,), int32.
    retractor_motion
        Motion relative to the retractor's start, shape (R, 4, 4), float64, column-vector convention (the translation is
        the last column, mm).
    activation
        Activation of each material's muscle from 0 to 1, shape (M,), float64; empty where no material has any.
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

    Parameters
    ----------
    index
        Index of each in `Program.landmarks`, shape (k,), int32.
    points
        Rest points in mm, shape (k, 3), float64.
    triangles
        Triangle of the epoch's surface under each, shape (k,), int32.
    """

    index: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))
    points: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    triangles: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))


@dataclass(frozen=True, eq=False)
class Program:
    """A compiled procedure (`lappet.program.compile.compile_program`).

    Hooks are in the procedure's order; sutures and retractors are in order of their start, so that what is added to the
    end of the timeline renumbers nothing before it.

    Parameters
    ----------
    epochs
        Epochs in order of time.
    frames
        Constraints for every integer time code.
    settings
        How the session solves.
    bones
        The bones, the same in all frames.
    fps
        Time codes per second.
    hooks
        Names of the hooks.
    sutures
        Names of the sutures.
    retractors
        Names of the retractors.
    landmarks
        A label per landmark point.
    active_hooks
        For each frame the indices in `hooks` of the rows of its hook arrays, each of shape (H,).
    grips
        For each epoch the retractor that grips each triangle, or -1, each of shape (m,), int32; only retractors that
        act in the epoch.
    landmarks_at
        Landmarks of each epoch.
    notes
        Sentences about what the procedure holds and the solve leaves out.
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
