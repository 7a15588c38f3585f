"""What each feature is measured on: a bar without any, and the same bar with one.

The bar is 16 x 4 x 4 cells, a whole number of blocks, so that every lane of every kernel has work; one end is held, the
other drawn out by a fifth. Materials are chosen so that a feature changes the motion little: what it costs is then not
hidden by other iterations.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from lappet.cutting.epoch import Regions
from lappet.geometry.labeled_surface import FaceOrigin, Surface
from lappet.program.program import Bones, Landmarks, Program
from lappet.program.settings import MaterialParameters
from lappet.reports.box_scenes import BoxScene, grid_box, stretched
from lappet.solve.coarse_program import coarse_program

SIZE, SPACING = (48.0, 12.0, 12.0), 3.0  # mm
MATERIAL = MaterialParameters(model="neoHookean", youngs_modulus=50.0, poissons_ratio=0.45)
BAR = BoxScene(
    "economy bar",
    "a bar of 48 x 12 x 12 mm, one end held, the other drawn out by 9.6 mm",
    SIZE,
    (16, 4, 4),
    fixed=(0,),
    gripped=(1,),
    motion=stretched(9.6),
    material=MATERIAL,
)


PATCH = BoxScene(
    "economy patch",
    "a patch of 192 x 192 x 6 mm on its bed, lifted by a hook in its middle",
    (192.0, 192.0, 6.0),
    (64, 64, 2),
    fixed=(0, 1, 2, 3),
    bedded=(4,),
    material=MATERIAL,
)


@dataclass(frozen=True)
class Feature:
    """A feature that costs are measured of.

    Parameters
    ----------
    name
        Name of the feature.
    what
        What it is, for people.
    put_into
        Puts it into the plain program; None where there is nothing to put in.
    coarse_program
        Makes the program that is solved besides, or None.
    base
        Makes what it is put into instead of the bar.
    """

    name: str
    what: str
    put_into: Callable[[Program], Program] | None
    coarse_program: Callable[[Program], Program] | None = None
    base: Callable[[], Program] | None = None


def plain(spacing: float = SPACING) -> Program:
    """Make the bar with none of the features.

    Parameters
    ----------
    spacing
        Lattice spacing in mm.

    Returns
    -------
    Program
        The program.
    """
    return BAR.program(spacing, strain=False, threads=1)


def patch(spacing: float = SPACING) -> Program:
    """Make a wide patch that one hook lifts by 1.5 mm; all of it is solved.

    Parameters
    ----------
    spacing
        Lattice spacing in mm.

    Returns
    -------
    Program
        The program.
    """
    program = PATCH.program(spacing, strain=False, threads=1, region="whole")
    surface = program.epochs[0].surface
    above = surface.points[surface.triangles].mean(axis=1) - np.array([96.0, 96.0, 6.0])
    triangle = int(np.argmin(np.linalg.norm(above, axis=1)))
    anchor = surface.points[surface.triangles[triangle]].mean(axis=0)
    hook = replace(
        program.frames[0],
        hook_index=np.zeros(1, np.int32),
        hook_anchors=anchor[None],
        hook_triangles=np.array([triangle], np.int32),
        hook_targets=anchor[None] + np.array([0.0, 0.0, 1.5]),
        hook_stiffness=np.array([300.0]),
    )
    return replace(program, frames=(hook,), hooks=("hook",))


def _material(program: Program, **changes: object) -> Program:
    materials = tuple(replace(material, **changes) for material in program.settings.materials)  # type: ignore[arg-type]
    return replace(program, settings=replace(program.settings, materials=materials))


def _contact(program: Program) -> Program:
    """A ledge of bone under the bar's middle, which pushes it up by 0.5 mm."""
    ledge, _ = grid_box((24.0, 30.0, 4.0), (4, 4, 1))
    below = program.epochs[0].surface.points[:, 2].min()
    points = ledge.points + np.array([12.0, -9.0, below + 0.5 - 4.0])
    return replace(program, bones=Bones(points, ledge.triangles))


def _muscle(program: Program) -> Program:
    frame = replace(program.frames[0], activation=np.array([0.2]))
    return replace(_material(program, muscle_stress=5.0), frames=(frame,))


def _heterogeneity(program: Program) -> Program:
    """The upper half of the bar is a second material, a copy of the first: it costs, but moves as before."""
    surface = program.epochs[0].surface
    z = surface.points[surface.triangles][:, :, 2]
    skin = surface.triangles[(z > SIZE[2] - 1e-9).all(axis=1)]
    used, compact = np.unique(skin, return_inverse=True)
    regions = Regions(
        surface.points[used],
        compact.reshape(-1, 3).astype(np.int32),
        np.ones((1, len(skin)), np.bool_),
        np.array([1], np.int32),
        np.array([0.0]),
        np.array([0.5 * SIZE[2]]),
    )
    epochs = (replace(program.epochs[0], regions=regions),)
    materials = 2 * program.settings.materials
    return replace(program, epochs=epochs, settings=replace(program.settings, materials=materials))


def _mesh_cells(program: Program) -> Program:
    """The bar slit along its length by 0.2 mm, beside a lattice plane: a row of cells is there twice."""
    halves = [(0.0, 4.4), (4.6, 12.0)]
    points, triangles, sides = [], [], []
    first = 0
    for low, high in halves:
        half, side = grid_box((SIZE[0], high - low, SIZE[2]), (16, 2, 4))
        points.append(half.points + np.array([0.0, low, 0.0]))
        triangles.append(half.triangles + first)
        sides.append(side)
        first += len(half.points)
    side = np.concatenate(sides)
    corners = np.concatenate(triangles).astype(np.int32)
    none = np.zeros(len(side), np.bool_)
    surface = Surface(
        np.concatenate(points),
        corners,
        np.zeros((len(side), 3, 2), np.float32),
        np.full(len(side), FaceOrigin.SKIN, np.uint8),
        np.isin(side, BAR.fixed),
        none,
    )
    grip = np.where(np.isin(side, BAR.gripped), 0, -1).astype(np.int32)
    epochs = (replace(program.epochs[0], surface=surface, fragments=2),)
    return replace(program, epochs=epochs, grips=(grip,))


def _landmarks(program: Program) -> Program:
    """Sixty-four landmarks, each at the middle of a triangle."""
    surface = program.epochs[0].surface
    triangles = np.linspace(0, len(surface.triangles) - 1, 64).astype(np.int32)
    points = surface.points[surface.triangles[triangles]].mean(axis=1)
    index = np.arange(len(triangles), dtype=np.int32)
    labels = tuple(f"mark {k}" for k in index)
    return replace(program, landmarks=labels, landmarks_at=(Landmarks(index, points, triangles),))


def _error_estimate(program: Program) -> Program:
    return replace(program, settings=replace(program.settings, correction=True))


def _coarse_program(program: Program) -> Program:
    coarse = coarse_program(program)
    return replace(coarse, settings=replace(coarse.settings, threads=1))


FEATURES = (
    Feature("contact", "a ledge of bone that pushes the bar up by 0.5 mm", _contact),
    Feature(
        "self_contact",
        "the bar never comes near itself: what looking for it costs",
        lambda p: replace(p, settings=replace(p.settings, self_contact=True)),
        base=plain,  # no daemon is built without it
    ),
    Feature("fibers", "one family along the bar, k1 2 kPa, k2 1", lambda p: _material(p, fiber_k1=2.0, fiber_k2=1.0)),
    Feature("muscle", "a muscle along the bar, 5 kPa, active by a fifth", _muscle),
    Feature("prestretch", "2 % along and across the bar", lambda p: _material(p, prestretch=(1.02, 1.02))),
    Feature("heterogeneity", "two materials, cell by cell", _heterogeneity),
    Feature("mesh_cells", "the bar slit along its length: 64 more cells, and blocks that are no grid", _mesh_cells),
    Feature("landmarks", "64 of them", _landmarks),
    Feature(
        "error_estimate",
        "the displacement still to come, and a solve at twice the spacing",
        _error_estimate,
        coarse_program=_coarse_program,
    ),
    Feature(
        "strain",
        "strain, stress and tension on the surface",
        lambda p: replace(p, settings=replace(p.settings, strain=True)),
    ),
    Feature(
        "region",
        "what the hook in the middle of a wide patch does not reach stays at rest (absent: all of it is solved)",
        lambda p: replace(p, settings=replace(p.settings, region="auto")),
        base=patch,
    ),
    Feature("followers", "the daemon has no PUB socket: nobody follows a solve, and nothing is published", None),
)
