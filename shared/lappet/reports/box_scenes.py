"""Scenes whose tissue is a box or a tapered plate, told to a session directly: no cut, one frame from rest.

The surface is a fixed grid whatever the lattice, so that displacements at its vertices compare between spacings.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.cutting.epoch import Epoch
from lappet.geometry.labeled_surface import Surface
from lappet.program.program import FrameConstraints, Landmarks, Program
from lappet.program.settings import MaterialParameters, SolverSettings
from lappet.reports.clamped_edge import edge_exponent

SKIN = MaterialParameters(model="neoHookean", youngs_modulus=50.0, poissons_ratio=0.45)


@dataclass(frozen=True)
class BoxScene:
    """A scene whose tissue is a box or a tapered plate.

    Parameters
    ----------
    name
        Name of the scene.
    what
        What it is, for people.
    size
        Extent in mm.
    divisions
        Divisions of the surface grid along each axis.
    fixed
        Sides that are held, 2 axis + (0 low, 1 high).
    bedded
        Sides that are on a bed.
    bed_stiffness
        Stiffness of the bed in kPa/mm, in all directions.
    gripped
        Sides that are gripped.
    motion
        Motion of the gripped side, shape (4, 4), column vectors.
    gravity
        Gravity in m/s².
    material
        The material.
    shape
        Moves grid points of the box, shape (n, 3), to the tissue; None leaves them.
    spacings
        Lattice spacings of the report in mm.
    reference
        Three spacings in mm, see `lappet.reports.error_time.measurement.Scene`.
    widest_edge
        Widest angle between a clamped side and a free one in degrees.
    is_box
        Whether the tissue is a box.
    smooth
        Whether nothing lowers its order.
    every_combination
        Whether settings are not only varied alone.
    """

    name: str
    what: str
    size: tuple[float, float, float]
    divisions: tuple[int, int, int]
    fixed: tuple[int, ...]
    bedded: tuple[int, ...] = ()
    bed_stiffness: float = 10.0
    gripped: tuple[int, ...] = ()
    motion: NDArray[np.float64] | None = None
    gravity: float = 0.0
    material: MaterialParameters = SKIN
    shape: Callable[[NDArray[np.float64]], NDArray[np.float64]] | None = None
    spacings: tuple[float, ...] = (4.0, 2.0, 1.0)
    reference: tuple[float, float, float] = (1.0, 0.5, 0.25)
    widest_edge: float = 90.0
    is_box: bool = True
    smooth: bool = False
    every_combination: bool = True

    @property
    def edge_exponent(self) -> float | None:
        """Exponent of the displacement where a clamped side meets a free one; None where nothing is clamped."""
        if not self.fixed and not self.gripped:
            return None
        return edge_exponent(self.material.poissons_ratio, self.widest_edge)

    def away(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Find points that are a quarter of the length or more away from every held, bedded or gripped side.

        Parameters
        ----------
        points
            Points in mm, shape (n, 3).

        Returns
        -------
        NDArray[np.bool_]
            Which are, shape (n,).
        """
        far = np.ones(len(points), np.bool_)
        for side in (*self.fixed, *self.bedded, *self.gripped):
            length = self.size[side // 2]
            from_side = points[:, side // 2] if side % 2 == 0 else length - points[:, side // 2]
            far &= from_side > length / 4.0 - 1e-9
        return far

    def program(self, spacing: float, **settings: Any) -> Program:
        """Make the scene at a spacing.

        Parameters
        ----------
        spacing
            Lattice spacing in mm.
        **settings
            Other fields of `SolverSettings`.

        Returns
        -------
        Program
            The program.
        """
        surface, side = grid_box(self.size, self.divisions)
        points = surface.points if self.shape is None else self.shape(surface.points)
        surface = replace(surface, points=points, fixed=np.isin(side, self.fixed), bed=np.isin(side, self.bedded))
        grip = np.where(np.isin(side, self.gripped), 0, -1).astype(np.int32)
        frame = FrameConstraints(1.0, 0)
        if self.motion is not None:
            frame = replace(frame, retractor_index=np.zeros(1, np.int32), retractor_motion=self.motion[None])
        chosen = SolverSettings(
            spacing=spacing,
            origin=(float(points[:, 0].min()), float(points[:, 1].min()), float(points[:, 2].min())),
            gravity=(0.0, 0.0, -self.gravity),
            bed_stiffness=self.bed_stiffness,
            bed_shear=self.bed_stiffness,
            retractors=int(self.motion is not None),
            materials=(self.material,),
            **settings,
        )
        return Program(
            epochs=(Epoch(0, 1.0, surface, 1),),
            frames=(frame,),
            settings=chosen,
            retractors=("grip",) if self.motion is not None else (),
            grips=(grip,),
            landmarks_at=(Landmarks(),),
        )


def grid_box(size: Sequence[float], divisions: Sequence[int]) -> tuple[Surface, NDArray[np.int64]]:
    """Make a closed box with a corner at the origin whose sides are grids of triangles.

    Parameters
    ----------
    size
        Extent in mm.
    divisions
        Divisions along each axis.

    Returns
    -------
    tuple[Surface, NDArray[np.int64]]
        The surface, and each triangle's side.
    """
    index: dict[tuple[int, int, int], int] = {}

    def vertex(i: int, j: int, k: int) -> int:
        return index.setdefault((i, j, k), len(index))

    triangles, side = [], []
    for axis in range(3):
        along, across = (axis + 1) % 3, (axis + 2) % 3
        for high in (0, 1):
            for p in range(divisions[along]):
                for q in range(divisions[across]):
                    corners = []
                    for dp, dq in ((0, 0), (1, 0), (1, 1), (0, 1)):
                        place = [0, 0, 0]
                        place[axis], place[along], place[across] = high * divisions[axis], p + dp, q + dq
                        corners.append(vertex(place[0], place[1], place[2]))
                    a, b, c, d = corners if high else corners[::-1]
                    triangles += [(a, b, c), (a, c, d)]
                    side += 2 * [2 * axis + high]
    points = np.array(list(index), float) / divisions * size
    m = len(triangles)
    none = np.zeros(m, np.bool_)
    surface = Surface(
        points, np.array(triangles, np.int32), np.zeros((m, 3, 2), np.float32), np.zeros(m, np.uint8), none, none
    )
    return surface, np.array(side)


def stretched(by: float) -> NDArray[np.float64]:
    """Make the motion of an end drawn along x.

    Parameters
    ----------
    by
        Distance in mm.

    Returns
    -------
    NDArray[np.float64]
        Motion, shape (4, 4), column vectors.
    """
    return _motion((by, 0.0, 0.0))


def _motion(shift: Sequence[float], turn: float = 0.0, center: Sequence[float] = (0.0, 0.0, 0.0)) -> NDArray[Any]:
    """Turn about the x axis through `center` by `turn` degrees, then shift by mm."""
    angle = math.radians(turn)
    motion = np.eye(4)
    motion[1:3, 1:3] = [[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]
    middle = np.asarray(center, float)
    motion[:3, 3] = middle - motion[:3, :3] @ middle + shift
    return motion


def _cook(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Cook's tapered panel: from a height of 44 mm at x = 0 to 16 mm at x = 48 mm, its foot rising to 44 mm."""
    x, t = points[:, 0], points[:, 2] / 44.0
    foot, head = 44.0 * x / 48.0, 44.0 + 16.0 * x / 48.0
    return np.column_stack([x, points[:, 1], foot + t * (head - foot)])


BAR = BoxScene(
    "bar",
    "a bar of 48 x 12 x 12 mm, one end held, the other pulled by 30 % and turned by 45°",
    (48.0, 12.0, 12.0),
    (16, 4, 4),
    fixed=(0,),
    gripped=(1,),
    motion=_motion((14.4, 0.0, 0.0), 45.0, (0.0, 6.0, 6.0)),
    spacings=(3.0, 2.0, 1.5, 1.0),
    reference=(1.5, 0.75, 0.375),
)
CANTILEVER = BoxScene(
    "cantilever",
    "a beam of 48 x 12 x 12 mm, held at one end, under half its own weight",
    (48.0, 12.0, 12.0),
    (16, 4, 4),
    fixed=(0,),
    gravity=9.81 / 2.0,
    spacings=(3.0, 2.0, 1.5, 1.0),
    reference=(1.5, 0.75, 0.375),
)
COOK = BoxScene(
    "cook",
    "Cook's panel, 48 mm long, 44 to 16 mm high and 8 mm thick, one end held, the other lifted by 8 mm",
    (48.0, 8.0, 44.0),
    (12, 2, 11),
    fixed=(0,),
    gripped=(1,),
    motion=_motion((0.0, 0.0, 8.0)),
    shape=_cook,
    widest_edge=132.5,  # at the lifted end, below
)
BLOCK = BoxScene(
    "block",
    "a block of 16 mm, held below, its upper side pressed down by 20 %",
    (16.0, 16.0, 16.0),
    (8, 8, 8),
    fixed=(4,),
    gripped=(5,),
    motion=_motion((0.0, 0.0, -3.2)),
)
SHELF = BoxScene(
    "shelf",
    "a beam of 48 x 12 x 12 mm, one end on a stiff bed instead of held, under a tenth of its weight",
    (48.0, 12.0, 12.0),
    (16, 4, 4),
    fixed=(),
    bedded=(0,),
    bed_stiffness=5.0,
    gravity=9.81 / 10.0,
    spacings=(3.0, 2.0, 1.5, 1.0),
    reference=(1.5, 0.75, 0.375),
    smooth=True,
)

# The same without lateral contraction: then held edges are not singular, and what else lowers the order is left. A
# twist against held ends stays singular in the warping of the section, so the bar is bent instead, and pressing a block
# is an affine motion, so it is sheared. Spacings are those whose nodes the grid's points lie on: between nodes there is
# the error of interpolation besides.
_SLACK = replace(SKIN, poissons_ratio=0.0)
BAR_SLACK = replace(
    BAR,
    name="bar-nu0",
    what="the bar at a Poisson's ratio of 0, pulled by 15 % and lifted by 7.2 mm",
    material=_SLACK,
    motion=_motion((7.2, 0.0, 7.2)),
    spacings=(1.5, 1.0, 0.75),  # four cells across are too few to see the order
    smooth=True,
    every_combination=False,
)
CANTILEVER_SLACK = replace(
    CANTILEVER,
    name="cantilever-nu0",
    what="the cantilever at a Poisson's ratio of 0",
    material=_SLACK,
    spacings=(3.0, 1.5, 0.75),
    smooth=True,
    every_combination=False,
)
COOK_SLACK = replace(
    COOK,
    name="cook-nu0",
    what="Cook's panel at a Poisson's ratio of 0: its partial cells remain",
    material=_SLACK,
    every_combination=False,
)
BLOCK_SLACK = replace(
    BLOCK,
    name="block-nu0",
    what="the block at a Poisson's ratio of 0, its upper side pressed and sheared by 2 %",
    material=_SLACK,
    motion=_motion((0.32, 0.0, -0.32)),
    smooth=True,
    every_combination=False,
)
BOXES = (BAR, CANTILEVER, COOK, BLOCK, SHELF, BAR_SLACK, CANTILEVER_SLACK, COOK_SLACK, BLOCK_SLACK)
