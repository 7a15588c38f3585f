"""Draws the active skin sutures of a frame as simple interrupted stitches that ride on the skin; buried ones hide."""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np
from numpy.typing import NDArray

from .skin_fields import SKIN, depth_below_skin, vertex_normals
from .skin_read import SkinCache
from .suture_bites import BITE, CLOSED_GAP, Bite, buried, find_bites, find_lip
from .suture_path import THREAD_RADIUS, stitch_path
from .tube import add_tubes, remove_tubes

# Stitches stand no closer: two sutures that hold one corner are its one corner stitch, and a dense row is thinned.
NEAREST = 1.7 * BITE


@dataclass(frozen=True, eq=False)
class Stitch:
    """A suture as it is drawn in one epoch: its bites and where it crosses the closed wound (3,), mm.

    turned: whether the first bite belongs to the suture's second end.
    """

    bites: tuple[Bite, Bite]
    crossing: NDArray[np.float64]
    turned: bool


def buried_sutures(cache: SkinCache) -> frozenset[int]:
    """The indices of the sutures that lie in the depth, judged where each is first active."""
    found, seen, depths = set(), set(), {}
    for time in cache.frames:
        sutures = cache.sutures(time)
        fresh = [int(i) for i in np.flatnonzero(sutures.active) if int(i) not in seen]
        if not fresh:
            continue
        epoch = cache.epoch_at(time)
        if epoch.name not in depths:
            first = cache.positions(epoch, epoch.frames[0])
            depths[epoch.name] = depth_below_skin(first, epoch.triangles, epoch.origin)
        for index in fresh:
            apart, anchors = cache.sutures_told_apart(epoch, index)
            if buried(cache.positions(epoch, apart), epoch.triangles, depths[epoch.name], anchors):
                found.add(index)
        seen.update(fresh)
    return frozenset(found)


class SutureThread:
    """The stitches in the scene."""

    def __init__(
        self,
        cache: SkinCache,
        material: bpy.types.Material,
        hidden: frozenset[int],
        facing: NDArray[np.float64],
        scale: float,
    ) -> None:
        """hidden: sutures not to draw. facing: (3,), the side on which knots are tied. scale: of bites and thread."""
        self._cache, self._material, self._hidden, self._facing, self._scale = cache, material, hidden, facing, scale
        self._stitches: dict[tuple[str, int], Stitch] = {}
        self._object: bpy.types.Object | None = None

    def show(self, time: float) -> None:
        """Draw the sutures that are active at a frame and no others."""
        remove_tubes(self._object)
        self._object = None
        sutures = self._cache.sutures(time)
        active = [int(i) for i in np.flatnonzero(sutures.active) if int(i) not in self._hidden]
        if not active:
            return
        epoch = self._cache.epoch_at(time)
        points = self._cache.positions(epoch, time)
        normals = vertex_normals(points, epoch.triangles, epoch.origin, SKIN)
        lines, crossings = [], np.zeros((0, 3))
        for index in active:
            stitch = self._find(time, index)
            if (np.linalg.norm(crossings - stitch.crossing, axis=1) < NEAREST * self._scale).any():
                continue
            crossings = np.vstack([crossings, stitch.crossing])
            bites = np.stack([b.carried(points) for b in stitch.bites])
            up = np.stack([b.carried(normals) for b in stitch.bites])
            up /= np.maximum(np.linalg.norm(up, axis=1, keepdims=True), 1e-9)
            ends = sutures.ends[index][:: -1 if stitch.turned else 1].astype(np.float64)
            tied = bool(np.linalg.norm(ends[1] - ends[0]) <= CLOSED_GAP)
            path = stitch_path(bites, ends, up, tied, self._scale)
            lines += [path.thread, *path.knot]
        self._object = add_tubes("Sutures", lines, [THREAD_RADIUS * self._scale] * len(lines), self._material, 2)

    def _find(self, time: float, index: int) -> Stitch:
        epoch = self._cache.epoch_at(time)
        if (epoch.name, index) not in self._stitches:
            frames = [t for t in epoch.frames if self._cache.sutures(t).active[index]]
            apart, anchors = self._cache.sutures_told_apart(epoch, index)
            points = self._cache.positions(epoch, apart)
            a, b = (find_lip(points, epoch.triangles, epoch.origin, end, 2.0 * BITE * self._scale) for end in anchors)
            closed = self._cache.positions(epoch, frames[-1])
            ends = self._cache.sutures(frames[-1]).ends[index]
            across = find_bites(closed, (a, b), ends, BITE * self._scale)
            way = across[1].carried(closed) - across[0].carried(closed)
            turned = bool(way @ self._facing > 0.0)
            bites = (across[1], across[0]) if turned else across
            self._stitches[epoch.name, index] = Stitch(bites, ends.astype(np.float64).mean(axis=0), turned)
        return self._stitches[epoch.name, index]
