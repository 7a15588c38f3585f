"""What the stability cases are made of: blocks that are held, moved and pulled, and small procedures on a patch."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.checks.validation import check
from lappet.core.problem import RefusedError
from lappet.cutting.epoch import Epoch, Regions
from lappet.procedure import Event, Material, Procedure, Tissue
from lappet.program.anchors import AnchorSearch
from lappet.program.compile import compile_program
from lappet.program.program import Bones, FrameConstraints, Landmarks, Program
from lappet.program.settings import MaterialParameters, SolverSettings
from lappet.reports.box_scenes import grid_box
from lappet.tissue.patch import flat_patch

SKIN = MaterialParameters(model="neoHookean", youngs_modulus=50.0, poissons_ratio=0.45)
Vector = tuple[float, float, float]
Pull = tuple[Vector, Vector, float]  # anchor, target or other anchor, stiffness
# The low and high side of each axis, as `grid_box` numbers them.
LEFT, RIGHT, FRONT, BACK, BELOW, ABOVE = range(6)
MOST_DIVISIONS = 24


def material(model: str = "neoHookean", **changes: Any) -> MaterialParameters:
    """Make skin of another model or with other parameters.

    Parameters
    ----------
    model
        Name of the model.
    **changes
        Other parameters.

    Returns
    -------
    MaterialParameters
        The material.
    """
    return replace(SKIN, model=model, mooney_ratio=0.5 if model == "mooneyRivlin" else 0.0, **changes)


def block(
    size: Vector,
    spacing: float,
    *,
    fixed: Sequence[int] = (),
    gripped: Sequence[int] = (),
    motions: Sequence[Sequence[NDArray[np.float64]]] = ((),),
    hooks: Sequence[Pull] = (),
    sutures: Sequence[Pull] = (),
    materials: Sequence[MaterialParameters] = (SKIN,),
    regions: Regions | None = None,
    bones: Bones | None = None,
    **settings: Any,
) -> Program:
    """Make a box with a corner at the origin.

    Parameters
    ----------
    size
        Extent in mm.
    spacing
        Lattice spacing in mm.
    fixed
        Sides that are held.
    gripped
        A side for each retractor.
    motions
        For each frame a motion, shape (4, 4), for each retractor.
    hooks
        Hooks, the same in every frame.
    sutures
        Sutures, the same in every frame, all drawn together.
    materials
        The materials.
    regions
        Material regions, or None.
    bones
        Bones, or None.
    **settings
        Other fields of `SolverSettings`.

    Returns
    -------
    Program
        The program.
    """
    divisions = [max(1, min(MOST_DIVISIONS, round(length / spacing))) for length in size]
    surface, side = grid_box(size, divisions)
    surface = replace(surface, fixed=np.isin(side, fixed))
    grip = np.full(len(side), -1, np.int32)
    for index, each in enumerate(gripped):
        grip[side == each] = index
    tie = AnchorSearch(surface, 1e-6 * max(size))
    pulled = tie.locate(np.array([pull[0] for pull in hooks]).reshape(-1, 3))
    ends = tie.locate(np.array([end for pull in sutures for end in pull[:2]]).reshape(-1, 3))
    count = len(sutures)
    frames = [
        FrameConstraints(
            float(time),
            0,
            hook_index=np.arange(len(hooks), dtype=np.int32),
            hook_anchors=pulled.point,
            hook_triangles=pulled.triangle,
            hook_targets=np.array([pull[1] for pull in hooks], float).reshape(-1, 3),
            hook_stiffness=np.array([pull[2] for pull in hooks], float),
            suture_index=np.arange(count, dtype=np.int32),
            suture_anchors=ends.point.reshape(-1, 2, 3),
            suture_triangles=ends.triangle.reshape(-1, 2),
            suture_closure=np.ones(count),
            suture_stiffness=np.array([pull[2] for pull in sutures], float),
            retractor_index=np.arange(len(motion), dtype=np.int32),
            retractor_motion=np.array(list(motion), float).reshape(-1, 4, 4),
        )
        for time, motion in enumerate(motions, start=1)
    ]
    chosen = SolverSettings(
        spacing=spacing, sutures=count, retractors=len(gripped), materials=tuple(materials), **settings
    )
    return Program(
        epochs=(Epoch(0, 1.0, surface, 1, regions if regions is not None else Regions()),),
        frames=tuple(frames),
        settings=chosen,
        bones=bones if bones is not None else Bones(),
        grips=(grip,),
        landmarks_at=(Landmarks(),),
    )


def moved(shift: Vector = (0.0, 0.0, 0.0), turn: float = 0.0, center: Vector = (0.0, 0.0, 0.0)) -> NDArray[np.float64]:
    """Make a motion: a turn about the x axis, then a shift.

    Parameters
    ----------
    shift
        Shift in mm.
    turn
        Angle in degrees.
    center
        Point in mm about which it turns.

    Returns
    -------
    NDArray[np.float64]
        Motion, shape (4, 4).
    """
    angle = math.radians(turn)
    motion = np.eye(4)
    motion[1:3, 1:3] = [[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]
    middle = np.asarray(center, float)
    motion[:3, 3] = middle - motion[:3, :3] @ middle + shift
    return motion


def stretched(
    factor: float, *, steps: int = 1, size: Vector = (16.0, 8.0, 8.0), spacing: float = 2.0, **more: Any
) -> Program:
    """Make a bar held at one end whose other end is moved along it, in equal steps.

    Parameters
    ----------
    factor
        How many times as long it becomes.
    steps
        Number of frames.
    size
        Extent in mm.
    spacing
        Lattice spacing in mm.
    **more
        What `block` takes besides.

    Returns
    -------
    Program
        The program.
    """
    shifts = [size[0] * (factor - 1.0) * (step + 1) / steps for step in range(steps)]
    motions = [[moved((shift, 0.0, 0.0))] for shift in shifts]
    return block(size, spacing, fixed=(LEFT,), gripped=(RIGHT,), motions=motions, **more)


def twisted(degrees: float, steps: int, **more: Any) -> Program:
    """Make a bar of 32 x 8 x 8 mm held at one end whose other end is turned, in equal steps.

    Parameters
    ----------
    degrees
        The angle.
    steps
        Number of frames.
    **more
        What `block` takes besides.

    Returns
    -------
    Program
        The program.
    """
    motions = [[moved(turn=degrees * (step + 1) / steps, center=(0.0, 4.0, 4.0))] for step in range(steps)]
    return block((32.0, 8.0, 8.0), 2.0, fixed=(LEFT,), gripped=(RIGHT,), motions=motions, **more)


def box_bone(low: Vector, high: Vector) -> Bones:
    """Make a bone that fills a box.

    Parameters
    ----------
    low
        Lowest corner in mm.
    high
        Highest corner in mm.

    Returns
    -------
    Bones
        The bone.
    """
    size = (high[0] - low[0], high[1] - low[1], high[2] - low[2])
    surface, _ = grid_box(size, (2, 2, 2))
    return Bones(surface.points + low, surface.triangles)


def procedure(tissue: Tissue, *events: Event, end: float = 3.0, **more: Any) -> Procedure:
    """Make a procedure of events on a tissue, from frame 1 on.

    Parameters
    ----------
    tissue
        The tissue.
    *events
        The events.
    end
        Last time code.
    **more
        Other fields of the procedure.

    Returns
    -------
    Procedure
        The procedure.
    """
    return Procedure(tissue=tissue, events=events, start_time=1.0, end_time=end, **more)


def compiled(made: Procedure, **settings: Any) -> Program:
    """Compile a procedure as `lappet solve` does.

    Parameters
    ----------
    made
        The procedure.
    **settings
        Other fields of `SolverSettings`.

    Returns
    -------
    Program
        The program.

    Raises
    ------
    RefusedError
        If the procedure has errors or cannot be compiled.
    """
    errors = [problem for problem in check(made) if problem.severity == "error"]
    if errors:
        raise RefusedError(errors)
    return compile_program(made, settings=SolverSettings(**settings))


def patch(size: Vector = (24.0, 16.0, 2.0), spacing: float = 1.0, **more: Any) -> Tissue:
    """Make a flat patch about the origin, its skin at z = thickness, its rim fixed, its underside on a bed.

    Parameters
    ----------
    size
        Extent in mm.
    spacing
        Lattice spacing in mm.
    **more
        What `flat_patch` takes besides.

    Returns
    -------
    Tissue
        The tissue.
    """
    return flat_patch(size, resolution=2.0 * spacing, spacing=spacing, **more)


def loose(tissue: Tissue, *, rim: bool = True) -> Tissue:
    """Free a tissue from its bed.

    Parameters
    ----------
    tissue
        The tissue.
    rim
        Whether what is fixed stays fixed.

    Returns
    -------
    Tissue
        The loose tissue.
    """
    kept = {name: faces for name, faces in tissue.subsets.items() if name != "bed" and (rim or name != "fixed")}
    return replace(tissue, subsets=kept)


def skin_material(**changes: Any) -> tuple[Material, ...]:
    """List the materials of a procedure whose skin has other parameters.

    Parameters
    ----------
    **changes
        The parameters.

    Returns
    -------
    tuple[Material, ...]
        The materials.
    """
    return (replace(Material(), **changes),)
