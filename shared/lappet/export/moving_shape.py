"""A shape that moves and keeps its triangles: what formats with morph targets or one mesh a frame are made of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.drawing.surface_look import SurfaceLook


@dataclass(frozen=True, eq=False)
class MovingShape:
    """A shape in all frames in which it is shown.

    Parameters
    ----------
    name
        Its name.
    parts
        Its triangles by what they look like: vertex indices, shape (m, 3), int32, outward.
    frames
        The time codes, ascending, at least one.
    positions
        Vertices in mm at each of them, shape (f, n, 3), float32.
    normals
        Unit normals at each of them, shape (f, n, 3), float32.
    grid
        Texture coordinates of the printed grid, one unit a square, shape (n, 2), float32; None where none is printed.
    vertex
        For each vertex the one of the solved surface that it is, shape (n,); None where it is none of them.
    """

    name: str
    parts: tuple[tuple[SurfaceLook, NDArray[np.int32]], ...]
    frames: tuple[float, ...]
    positions: NDArray[np.float32]
    normals: NDArray[np.float32]
    grid: NDArray[np.float32] | None = None
    vertex: NDArray[np.int64] | None = None

    def __post_init__(self) -> None:
        assert len(self.frames) == len(self.positions) == len(self.normals)
