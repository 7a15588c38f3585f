"""The program: what the daemon is told. Epochs of constant topology and, per frame, the constraints."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lappet.cutting.epoch import Epoch, no_entries
from lappet.program.settings import SolverSettings


@dataclass(frozen=True, eq=False)
class Bones:
    """What the tissue may not enter: all bones as one closed triangle surface; without triangles: none.

    points: (b, 3) float64, mm. triangles: (c, 3) int32.
    """

    points: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    triangles: NDArray[np.int32] = field(default_factory=lambda: no_entries((0, 3), np.int32))


@dataclass(frozen=True, eq=False)
class FrameConstraints:
    """What acts on the tissue in one frame: the arrays of the message `solve` (PROTOCOL.md) under their own names.

    time: time code. epoch: index of the epoch that the frame belongs to.

    Hooks (H): hook_index (H,) int32 into `Program.hooks`; hook_anchors (H, 3) float64 rest points in mm; hook_triangles
    (H,) int32, the triangle of the epoch's surface under each; hook_targets (H, 3) float64 mm; hook_stiffness (H,)
    float64 mN/mm.
    Sutures placed by now (A): suture_index (A,) int32 in the procedure; suture_anchors (A, 2, 3) float64 rest points;
    suture_triangles (A, 2) int32; suture_closure (A,) float64, 0 = as placed, 1 = drawn together; suture_stiffness (A,)
    float64 mN/mm.
    Active retractors (R): retractor_index (R,) int32; retractor_motion (R, 4, 4) float64, column-vector convention (the
    translation is the last column, mm), relative to the retractor's start.
    activation (M,) float64, 0 to 1: of each material's muscle; empty where no material has any.
    All but hook_index is told to the daemon.
    """

    time: float
    epoch: int
    hook_index: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))
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

    epochs: in order of time. frames: one per integer time code. bones: the same in all of them. grips: per epoch (m,)
    int32, the retractor that grips each triangle, or -1; only retractors that act in the epoch. landmarks_at: per
    epoch. fps: time codes per second.

    Names of prims: hooks, sutures and retractors in order of their start, so that what is added to the end of the
    timeline renumbers nothing before it. landmarks: a label per landmark point. notes:
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
    grips: tuple[NDArray[np.int32], ...] = ()
    landmarks_at: tuple[Landmarks, ...] = ()
    notes: tuple[str, ...] = ()
