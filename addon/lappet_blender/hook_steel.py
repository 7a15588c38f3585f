"""Draws the active hooks of a frame as steel skin hooks that lean along their pull."""

from __future__ import annotations

import bpy
import numpy as np
from numpy.typing import NDArray

from .hook_path import hook_path, pull_direction
from .skin_read import SkinCache
from .tube import add_tubes, remove_tubes


class HookSteel:
    """The hooks in the scene; each keeps one direction for its whole life."""

    def __init__(
        self, cache: SkinCache, material: bpy.types.Material, normal: NDArray[np.float64], centre: NDArray[np.float64]
    ) -> None:
        """normal: (3,) unit, out of the surgical region. centre: (3,) mm, its middle, from which hooks lean away."""
        self._cache, self._material, self._normal, self._centre = cache, material, normal, centre
        self._direction: dict[int, NDArray[np.float64]] = {}
        self._object: bpy.types.Object | None = None

    def show(self, time: float) -> None:
        """Draw the hooks that are active at a frame and no others."""
        remove_tubes(self._object)
        self._object = None
        hooks = self._cache.hooks(time)
        lines, radii = [], []
        for index in np.flatnonzero(hooks.active):
            path = hook_path(hooks.ends[index, 0].astype(np.float64), self._lean(int(index)), self._normal)
            lines.append(path[0])
            radii.append(path[1])
        if lines:
            self._object = add_tubes("Hooks", lines, radii, self._material, resolution=6)

    def _lean(self, index: int) -> NDArray[np.float64]:
        if index not in self._direction:
            course = []
            for time in self._cache.frames:
                hooks = self._cache.hooks(time)
                if hooks.active[index]:
                    course.append(hooks.ends[index].astype(np.float64))
            ends = np.array(course)
            path = np.vstack([ends[:1, 0], ends[:, 1]])
            self._direction[index] = pull_direction(path, self._normal, path[0] - self._centre)
        return self._direction[index]
