"""An epoch: the time from one cut to the next, in which the tissue's topology is constant, and its material regions."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.labelled_surface import Surface


def no_entries(shape: tuple[int, ...], kind: type) -> NDArray[Any]:
    """Return an array of zeros, for fields that are empty unless said otherwise."""
    return np.zeros(shape, kind)


@dataclass(frozen=True, eq=False)
class Regions:
    """The parts of the tissue that are of other materials than the first of `SolverSettings.materials`.

    skin_points: (s, 3) float64, mm, and skin_triangles: (t, 3) int32: the outer skin before any cut, there also without
    regions where a material has a direction, which runs along it; else empty. faces: (R, t)
    bool, the skin above each region. material: (R,) int32, index into `SolverSettings.materials`. depth_from, depth_to:
    (R,) float64, mm below the skin; infinite for no end. Of the regions that hold a place the last one counts.
    """

    skin_points: NDArray[np.float64] = field(default_factory=lambda: no_entries((0, 3), np.float64))
    skin_triangles: NDArray[np.int32] = field(default_factory=lambda: no_entries((0, 3), np.int32))
    faces: NDArray[np.bool_] = field(default_factory=lambda: no_entries((0, 0), np.bool_))
    material: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))
    depth_from: NDArray[np.float64] = field(default_factory=lambda: no_entries((0,), np.float64))
    depth_to: NDArray[np.float64] = field(default_factory=lambda: no_entries((0,), np.float64))

    def __len__(self) -> int:
        return len(self.material)


@dataclass(frozen=True, eq=False)
class Epoch:
    """A stretch of the timeline with constant topology and attachments, from `start_time` on.

    regions: the same in every epoch of a program. over_bone: (m,) bool, the resting faces that contact with bone holds
    up; without entries: none.
    """

    index: int
    start_time: float
    surface: Surface
    fragments: int
    regions: Regions = field(default_factory=Regions)
    over_bone: NDArray[np.bool_] = field(default_factory=lambda: no_entries((0,), np.bool_))

    @property
    def support(self) -> NDArray[np.uint8]:
        """What the daemon is told of the bed, (m,): 1 attached to it, 2 resting on it, else 0."""
        surface = self.surface
        resting = surface.resting & ~self.over_bone if len(self.over_bone) else surface.resting
        return np.where(surface.bed, 1, np.where(resting, 2, 0)).astype(np.uint8)
