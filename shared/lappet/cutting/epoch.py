"""An epoch: the time from one cut to the next, in which the tissue's topology is constant, and its material regions."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.labeled_surface import Surface


def no_entries(shape: tuple[int, ...], kind: type) -> NDArray[Any]:
    """Make an array of zeros, for fields that are empty unless said otherwise.

    Parameters
    ----------
    shape
        Shape of the array.
    kind
        Kind of its numbers.

    Returns
    -------
    NDArray[Any]
        The array.
    """
    return np.zeros(shape, kind)


@dataclass(frozen=True, eq=False)
class Regions:
    """The parts of the tissue that are of other materials than the first of `SolverSettings.materials`.

    The skin is there also without regions where a material has a direction, which runs along it; else it is empty. Of
    the regions that hold a place the last one counts.

    Parameters
    ----------
    skin_points
        Vertices of the outer skin before any cut in mm, shape (s, 3), float64.
    skin_triangles
        Its triangles, shape (t, 3), int32.
    faces
        The skin above each region, shape (R, t), bool.
    material
        Index of each region's material in `SolverSettings.materials`, shape (R,), int32.
    depth_from
        Least depth of each region below the skin in mm, shape (R,), float64.
    depth_to
        Greatest depth in mm, infinite for no end, shape (R,), float64.
    skin_directions
        Direction of fibers, muscle and prestretch at each vertex of the skin, shape (s, 3), float64; without entries
        that of the materials.
    skin_stretch
        Prestretch along and across it, shape (s, 2), float64; without entries that of the materials.
    """

    skin_points: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    skin_triangles: NDArray[np.int32] = field(default_factory=lambda: no_entries((0, 3), np.int32))
    faces: NDArray[np.bool_] = field(default_factory=lambda: no_entries((0, 0), np.bool_))
    material: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))
    depth_from: NDArray[np.float64] = field(default_factory=lambda: no_entries((0,), np.float64))
    depth_to: NDArray[np.float64] = field(default_factory=lambda: no_entries((0,), np.float64))
    skin_directions: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    skin_stretch: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 2), np.float64))

    def __len__(self) -> int:
        return len(self.material)


@dataclass(frozen=True, eq=False)
class Strands:
    """The strands of muscles, whose cells are of other materials than what regions say; without entries: none.

    Parameters
    ----------
    start
        Row of the first point of each strand, shape (q,), int32, growing from 0.
    material
        Index of its material in `SolverSettings.materials`, shape (q,), int32.
    points
        Courses in mm, one after another, shape (p, 3), float64.
    radii
        Radius at each point in mm, shape (p,), float64.
    """

    start: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))
    material: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))
    points: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    radii: NDArray[np.float64] = field(default_factory=lambda: no_entries((0,), np.float64))

    def __len__(self) -> int:
        return len(self.start)


@dataclass(frozen=True, eq=False)
class Ground:
    """What undermined tissue lies on: the bed faces of the tissue before any cut; without triangles: none.

    Parameters
    ----------
    points
        Vertices in mm, shape (g, 3), float64.
    triangles
        Vertex indices, shape (k, 3), int32; normals point out of the tissue.
    """

    points: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    triangles: NDArray[np.int32] = field(default_factory=lambda: no_entries((0, 3), np.int32))


@dataclass(frozen=True, eq=False)
class Boundary:
    """What the faces of an epoch are besides held and gripped, and the sections across it; without entries: nothing.

    Parameters
    ----------
    walls
        Which triangles are walls of wounds, shape (m,), bool; without entries: none needs to be known.
    fixed_parts
        Part of the fixed faces that each triangle is of, -1 for none, shape (m,), int32; without entries: they are one.
    rollers
        Roller that each triangle slides on, -1 for none, shape (m,), int32.
    roller_normals
        Direction that each roller holds, zero for that of each face's normal, shape (K, 3), float64.
    loaded_index
        Numbers of the face subsets that loads act on (`Program.loads`), shape (L,), int32.
    loaded_faces
        Which triangles are of each, shape (L, m), bool.
    section_points
        A point of each section at rest in mm, shape (S, 3), float64.
    section_normals
        Its normal, of any length, shape (S, 3), float64.
    """

    walls: NDArray[np.bool_] = field(default_factory=lambda: no_entries((0,), np.bool_))
    fixed_parts: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))
    rollers: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))
    roller_normals: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    loaded_index: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))
    loaded_faces: NDArray[np.bool_] = field(default_factory=lambda: no_entries((0, 0), np.bool_))
    section_points: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    section_normals: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))


@dataclass(frozen=True, eq=False)
class Removed:
    """The deep tissue that a thinning took away.

    Parameters
    ----------
    name
        Name of the event.
    area
        Area of the skin above it in mm².
    volume
        Its volume in mm³.
    points
        Vertices of its surface at rest in mm, shape (n, 3), float64.
    triangles
        Vertex indices, shape (m, 3), int32; normals point out of what was removed.
    """

    name: str
    area: float
    volume: float
    points: NDArray[np.float64]
    triangles: NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Epoch:
    """A stretch of the timeline with constant topology and attachments.

    Parameters
    ----------
    index
        Number of the epoch, from 0.
    start_time
        Time code at which it begins.
    surface
        The cut surface at rest.
    fragments
        Number of parts that do not hang together.
    regions
        Material regions, the same in every epoch of a program.
    over_bone
        Resting faces that contact with bone holds up, shape (m,), bool; without entries: none.
    ground
        What faces rest on; nothing where none does.
    boundary
        Parts of fixed faces, rollers, loaded faces and sections.
    strands
        Strands of muscles, the same in every epoch of a program.
    thinned
        What its own thinnings took away.
    """

    index: int
    start_time: float
    surface: Surface
    fragments: int
    regions: Regions = field(default_factory=Regions)
    over_bone: NDArray[np.bool_] = field(default_factory=lambda: no_entries((0,), np.bool_))
    ground: Ground = field(default_factory=Ground)
    boundary: Boundary = field(default_factory=Boundary)
    strands: Strands = field(default_factory=Strands)
    thinned: tuple[Removed, ...] = ()

    @property
    def support(self) -> NDArray[np.uint8]:
        """What the daemon is told of the bed, shape (m,): 1 attached to it, 2 resting on it, else 0."""
        surface = self.surface
        resting = surface.resting & ~self.over_bone if len(self.over_bone) else surface.resting
        return np.where(surface.bed, 1, np.where(resting, 2, 0)).astype(np.uint8)
