"""Draws the active hooks of a frame as steel skin hooks that reach in from both sides of the field."""

from __future__ import annotations

import bpy
import numpy as np
from numpy.typing import NDArray

from .hook_path import hook_directions, hook_path
from .skin_fields import SKIN, WOUND_WALL, vertex_normals
from .skin_read import SkinCache, SkinEpoch
from .tube import add_tubes, remove_tubes


class HookSteel:
    """The hooks in the scene; each keeps one direction for its whole life."""

    def __init__(
        self,
        cache: SkinCache,
        material: bpy.types.Material,
        axes: NDArray[np.float64],
        centre: NDArray[np.float64],
        scale: float,
    ) -> None:
        """axes: (3, 3), rows right, up along the skin and normal, as the picture is seen. centre: (3,) mm, of it."""
        self._cache, self._material, self._normal, self._scale = cache, material, axes[2], scale
        courses: dict[int, list[NDArray[np.float64]]] = {}
        for time in cache.frames:
            hooks = cache.hooks(time)
            for index in np.flatnonzero(hooks.active):
                courses.setdefault(int(index), []).append(hooks.ends[index, 0].astype(np.float64))
        found = hook_directions([np.array(c) for c in courses.values()], centre, axes)
        self._directions = dict(zip(courses, found, strict=True))
        self._edges = {
            e.name: np.intersect1d(e.triangles[e.origin == SKIN], e.triangles[e.origin == WOUND_WALL])
            for e in cache.epochs
        }
        self._object: bpy.types.Object | None = None

    def show(self, time: float) -> None:
        """Draw the hooks that are active at a frame and no others."""
        remove_tubes(self._object)
        self._object = None
        hooks = self._cache.hooks(time)
        active = np.flatnonzero(hooks.active)
        if not len(active):
            return
        epoch = self._cache.epoch_at(time)
        points = self._cache.positions(epoch, time)
        normals = vertex_normals(points, epoch.triangles, epoch.origin, SKIN)
        lines, radii = [], []
        for index in active:
            anchor = hooks.ends[index, 0].astype(np.float64)
            direction = self._directions[int(index)]
            normal, edge = self._hold(epoch, points, normals, anchor, direction)
            line, radius = hook_path(anchor, direction, normal, edge, self._scale)
            lines.append(line)
            radii.append(radius)
        self._object = add_tubes("Hooks", lines, radii, self._material, resolution=4)

    def _hold(
        self,
        epoch: SkinEpoch,
        points: NDArray[np.float32],
        normals: NDArray[np.float32],
        anchor: NDArray[np.float64],
        direction: NDArray[np.float64],
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The skin's normal at an anchor and the direction to the nearest edge, both (3,) unit."""
        used = np.flatnonzero(np.abs(normals).any(axis=1))
        nearest = used[np.argsort(np.linalg.norm(points[used] - anchor, axis=1))[:4]]
        normal = normals[nearest].sum(axis=0).astype(np.float64)
        length = float(np.linalg.norm(normal))
        normal = normal / length if length > 1e-6 else self._normal
        rim = points[self._edges[epoch.name]]
        away = np.linalg.norm(rim - anchor, axis=1)
        near = rim[away < 4.0 * self._scale]
        if len(near):
            # The edge that lies most in the direction of the handle, so that the shank does not cross the flap.
            way = near - anchor
            way /= np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-9)
            return normal, way[int((way @ direction).argmax())].astype(np.float64)
        return normal, direction
