"""Which view of the 3D viewport the mouse is over, and where places of the world are in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import bpy
import numpy as np
from bpy_extras.view3d_utils import region_2d_to_location_3d
from mathutils import Vector
from numpy.typing import ArrayLike, NDArray

from .skin_pick import SkinHit, mouse_ray, pick_along_ray


def project(matrix: ArrayLike, width: float, height: float, places: ArrayLike) -> NDArray[np.float64]:
    """Pixels (k, 2) of places (k, 3) of the world under a view's perspective matrix (4, 4); NaN behind the viewer."""
    points = np.asarray(places, np.float64).reshape(-1, 3)
    clip = np.column_stack([points, np.ones(len(points))]) @ np.asarray(matrix, np.float64).T
    w = np.where(clip[:, 3] > 1e-9, clip[:, 3], np.nan)
    return (0.5 + 0.5 * clip[:, :2] / w[:, None]) * [width, height]


@dataclass(frozen=True)
class View:
    """A view: one region of a 3D viewport (there are four in a quad view), its camera, and the mouse in its pixels."""

    space: bpy.types.SpaceView3D
    region: bpy.types.Region
    data: bpy.types.RegionView3D
    mouse: tuple[float, float]

    def project(self, places: ArrayLike) -> NDArray[np.float64]:
        """Pixels (k, 2) of places (k, 3); NaN behind the viewer."""
        return project(self.data.perspective_matrix, self.region.width, self.region.height, places)

    def pick(self, scene: bpy.types.Scene, any_face: bool = False) -> SkinHit | None:
        """The skin under the mouse."""
        origin, direction = mouse_ray(self.region, self.data, self.mouse)
        return pick_along_ray(scene, origin, direction, any_face, self.space)

    @property
    def viewer(self) -> tuple[Vector, bool]:
        """The viewer's place, or in an orthographic view the direction towards the viewer; and whether it is one."""
        return viewer_of(self.data)

    def on_plane_through(self, place: Vector) -> Vector:
        """The place under the mouse at the depth of another, in the plane that faces the viewer."""
        return region_2d_to_location_3d(self.region, self.data, self.mouse, place)

    def along(self, place: Vector, axis: Vector) -> Vector:
        """The place on a line through a place nearest to the mouse's ray."""
        origin, direction = mouse_ray(self.region, self.data, self.mouse)
        return nearest_on_line(place, axis, origin, direction)


def viewer_of(data: bpy.types.RegionView3D) -> tuple[Vector, bool]:
    """The viewer's place, or in an orthographic view the direction towards the viewer; and whether it is one."""
    inverse = data.view_matrix.inverted()
    flat = data.window_matrix[3][3] == 1.0
    return (inverse.col[2].xyz if flat else inverse.translation), flat


def nearest_on_line(place: Vector, axis: Vector, origin: Vector, direction: Vector) -> Vector:
    """The point of the line through `place` along `axis` that is nearest to another line.

    `place` itself where they are parallel.
    """
    u, v = axis.normalized(), direction.normalized()
    between, cosine = origin - place, u.dot(v)
    slope = 1.0 - cosine * cosine
    if slope < 1e-8:
        return place.copy()
    return place + u * ((u.dot(between) - cosine * v.dot(between)) / slope)


def view_under(context: bpy.types.Context, window_mouse: Sequence[float]) -> View | None:
    """The view of the context's 3D viewport at a place of the window; None over panels, bars and other editors."""
    area = context.area
    if area is None or area.type != "VIEW_3D":
        return None
    x, y = window_mouse[0], window_mouse[1]
    space = area.spaces.active
    windows = [region for region in area.regions if region.type == "WINDOW"]
    for region in area.regions:
        if region.type not in ("WINDOW", "HEADER_ASSET") and _holds(region, x, y) and region.alignment != "NONE":
            return None
    for index, region in enumerate(windows):
        if _holds(region, x, y):
            quad = space.region_quadviews
            data = quad[index] if len(quad) == len(windows) > 1 else space.region_3d
            return View(space, region, data, (x - region.x, y - region.y))
    return None


def _holds(region: bpy.types.Region, x: float, y: float) -> bool:
    inside = 0 <= x - region.x < region.width and 0 <= y - region.y < region.height
    return inside and region.width > 1 and region.height > 1
