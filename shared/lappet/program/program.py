"""The program: what the daemon is told. Epochs of constant topology and, per frame, the constraints."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lappet.anatomy.vessel_crossings import VesselCrossing
from lappet.anatomy.vessel_pieces import VesselPieces
from lappet.core.problem import Problem
from lappet.cutting.epoch import Epoch, no_entries
from lappet.procedure import Suture, Vessel
from lappet.program.settings import SolverSettings


@dataclass(frozen=True, eq=False)
class Bones:
    """What the tissue may not enter: all bones as one closed triangle surface; without triangles: none.

    Parameters
    ----------
    points
        Vertices in mm, shape (b, 3), float64.
    triangles
        Vertex indices, shape (c, 3), int32.
    bodies
        The body of bones that each triangle is of, shape (c,), int32: those that stay are one, each that moves is one.
        Without entries none moves.
    """

    points: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    triangles: NDArray[np.int32] = field(default_factory=lambda: no_entries((0, 3), np.int32))
    bodies: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))


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
    hook_index
        Number of each hook in `Program.hooks`, shape (H,), int32; not told to the daemon.
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
        Stiffness of each as a thread in mN/mm, shape (A,), float64.
    suture_is_thread
        Whether each is a thread (1) or closes exactly (0), shape (A,), uint8; empty where none is a thread, as are the
        next two.
    suture_length
        Length to which a thread is drawn in mm, shape (A,), float64.
    suture_tension
        Tension with which a thread is drawn at most in mN, 0 for as much as it takes, shape (A,), float64.
    suture_inner_bites
        Number of bites of each thread between its ends, shape (A,), int32; empty where no thread has any, as are the
        next two. I are they in all, in the order of the sutures and of each thread.
    inner_bite_anchors
        Rest points of these bites in mm, shape (I, 3), float64.
    inner_bite_triangles
        Triangles under them, shape (I,), int32.
    retractor_index
        Index of each retractor in the procedure, shape (R,), int32.
    retractor_motion
        Motion relative to the retractor's start, shape (R, 4, 4), float64, column-vector convention (the translation is
        the last column, mm).
    load_index
        Number of the faces of each of D loads in `Program.loads`, shape (D,), int32; empty where nothing is loaded, as
        are the next two.
    load_traction
        Traction on them in kPa by their area at rest, shape (D, 3), float64.
    load_pressure
        Pressure on them in kPa, shape (D,), float64.
    activation
        Activation of each material's muscle from 0 to 1, shape (M,), float64; empty where no material has any.
    bone_motion
        Motion of each body of bones from the procedure's start, shape (B, 4, 4), float64, as `retractor_motion`; empty
        where none moves.
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
    suture_is_thread: NDArray[np.uint8] = field(default_factory=lambda: no_entries((0,), np.uint8))
    suture_length: NDArray[np.float64] = field(default_factory=lambda: no_entries((0,), np.float64))
    suture_tension: NDArray[np.float64] = field(default_factory=lambda: no_entries((0,), np.float64))
    suture_inner_bites: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))
    inner_bite_anchors: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    inner_bite_triangles: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))
    retractor_index: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))
    retractor_motion: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 4, 4), np.float64))
    load_index: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))
    load_traction: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    load_pressure: NDArray[np.float64] = field(default_factory=lambda: no_entries((0,), np.float64))
    activation: NDArray[np.float64] = field(default_factory=lambda: no_entries((0,), np.float64))
    bone_motion: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 4, 4), np.float64))


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
    vessel_points
        Rest points of the pieces of vessels in mm, shape (v, 3), float64: the daemon follows them after the landmarks.
    vessel_triangles
        Triangle of the epoch's surface nearest to each, shape (v,), int32.
    """

    index: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))
    points: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    triangles: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))
    vessel_points: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    vessel_triangles: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))


@dataclass(frozen=True, eq=False)
class Program:
    """A compiled procedure (`lappet.program.compile.compile_program`).

    Hooks, sutures and retractors are in order of their start, so that what is added to the end of the timeline
    renumbers nothing before it.

    Parameters
    ----------
    epochs
        Epochs in order of time.
    frames
        Constraints for every integer time code.
    settings
        How the session solves.
    bones
        The bones where they are at the start.
    fps
        Time codes per second.
    hooks
        Names of the hooks.
    stitches
        The sutures, those of suture runs among them.
    retractors
        Names of the retractors.
    landmarks
        A label per landmark point.
    fixed_parts
        Names of the parts of the fixed faces.
    rollers
        Names of the face subsets that slide.
    loads
        Names of the face subsets that loads act on, in order of the first load on each.
    sections
        A label per section.
    grips
        For each epoch the retractor that grips each triangle, or -1, each of shape (m,), int32; only retractors that
        act in the epoch.
    landmarks_at
        Landmarks of each epoch.
    vessels
        The vessels.
    vessels_at
        What each epoch's tissue holds of them.
    vessel_crossings
        Where incisions divide them.
    notes
        What the user should know of it: what is suspicious once it is cut, and what is done otherwise than it is told.
    """

    epochs: tuple[Epoch, ...]
    frames: tuple[FrameConstraints, ...]
    settings: SolverSettings
    bones: Bones = field(default_factory=Bones)
    fps: float = 24.0
    hooks: tuple[str, ...] = ()
    stitches: tuple[Suture, ...] = ()
    retractors: tuple[str, ...] = ()
    landmarks: tuple[str, ...] = ()
    fixed_parts: tuple[str, ...] = ()
    rollers: tuple[str, ...] = ()
    loads: tuple[str, ...] = ()
    sections: tuple[str, ...] = ()
    grips: tuple[NDArray[np.int32], ...] = ()
    landmarks_at: tuple[Landmarks, ...] = ()
    vessels: tuple[Vessel, ...] = ()
    vessels_at: tuple[VesselPieces, ...] = ()
    vessel_crossings: tuple[VesselCrossing, ...] = ()
    notes: tuple[Problem, ...] = ()

    @property
    def sutures(self) -> tuple[str, ...]:
        """Names of the sutures."""
        return tuple(suture.name for suture in self.stitches)
