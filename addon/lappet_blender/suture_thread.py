"""Draws the active sutures of a frame as stitches of thread with knots that ride on the skin."""

from __future__ import annotations

import bpy
import numpy as np

from .skin_fields import SKIN, vertex_normals
from .skin_read import SkinCache
from .suture_path import Bite, find_bite, stitch_path
from .tube import add_tubes, remove_tubes

RADIUS = 0.17


class SutureThread:
    """The stitches in the scene. Bites are found once an epoch, where the suture is first active in it."""

    def __init__(self, cache: SkinCache, material: bpy.types.Material) -> None:
        self._cache, self._material = cache, material
        self._bites: dict[tuple[str, int], tuple[Bite, Bite]] = {}
        self._object: bpy.types.Object | None = None

    def show(self, time: float) -> None:
        """Draw the sutures that are active at a frame and no others."""
        remove_tubes(self._object)
        self._object = None
        active = np.flatnonzero(self._cache.sutures(time).active)
        if not len(active):
            return
        epoch = self._cache.epoch_at(time)
        points = self._cache.positions(epoch, time)
        normals = vertex_normals(points, epoch.triangles, epoch.origin, SKIN)
        lines = []
        for index in active:
            bites = self._find(time, int(index))
            ends = np.stack([b.carried(points) for b in bites])
            up = np.stack([b.carried(normals) for b in bites])
            up /= np.maximum(np.linalg.norm(up, axis=1, keepdims=True), 1e-9)
            stitch = stitch_path(ends, up, RADIUS)
            lines += [stitch.thread, stitch.knot, *stitch.tails]
        self._object = add_tubes("Sutures", lines, [RADIUS] * len(lines), self._material)

    def _find(self, time: float, index: int) -> tuple[Bite, Bite]:
        epoch = self._cache.epoch_at(time)
        if (epoch.name, index) not in self._bites:
            first = next(t for t in epoch.frames if self._cache.sutures(t).active[index])
            points = self._cache.positions(epoch, first)
            ends = self._cache.sutures(first).ends[index]
            a, b = (find_bite(points, epoch.triangles, epoch.origin, end) for end in ends)
            self._bites[epoch.name, index] = (a, b)
        return self._bites[epoch.name, index]
