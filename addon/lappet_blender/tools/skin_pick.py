"""What lies under the mouse: a point of the shown skin, and which material point that is at rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import bpy
import numpy as np
from bpy_extras import view3d_utils
from mathutils import Vector

from lappet.geometry.labeled_surface import FaceOrigin

from .shown_surface import Located, shown_surface


@dataclass(frozen=True)
class SkinHit:
    """A point of the shown surface. rest: mm. world, normal: where it is now; the normal is unit and points outward.

    origin: `FaceOrigin` of its triangle. triangle: index into the shown mesh's triangles. face: of the tissue's mesh,
    -1 on wound walls.
    """

    rest: tuple[float, float, float]
    world: Vector
    normal: Vector
    origin: int
    triangle: int
    face: int


def pick_along_ray(
    scene: bpy.types.Scene,
    origin: Sequence[float],
    direction: Sequence[float],
    any_face: bool = False,
    viewport: bpy.types.SpaceView3D | None = None,
) -> SkinHit | None:
    """The first point of the shown surface along a ray of the world, None where it meets none.

    What lies in front hides what is behind: a ray that first meets a wound wall, the rim or the underside picks
    nothing, unless `any_face`. viewport: the one whose visible objects count (local view).
    """
    surface = shown_surface(scene, viewport)
    found = surface.ray.first(origin, direction) if surface is not None else None
    if surface is None or found is None:
        return None
    triangle, weights, _ = found
    kind = int(surface.rest.origin[triangle])
    if kind != FaceOrigin.SKIN and not any_face:
        return None
    located = Located(np.array([triangle]), weights[None])
    x, y, z = (float(v) for v in surface.rest.at(located)[0])
    return SkinHit(
        rest=(x, y, z),
        world=Vector(surface.carry(located)[0].tolist()),
        normal=Vector(surface.normals(located.triangle)[0].tolist()),
        origin=kind,
        triangle=triangle,
        face=int(surface.rest.face[triangle]),
    )


def mouse_ray(region: bpy.types.Region, view: bpy.types.RegionView3D, mouse: Sequence[float]) -> tuple[Vector, Vector]:
    """Origin and direction in the world of the ray under a place (pixels) of a 3D view's region."""
    direction = view3d_utils.region_2d_to_vector_3d(region, view, mouse)
    return view3d_utils.region_2d_to_origin_3d(region, view, mouse), direction
