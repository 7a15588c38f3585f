"""The manifest of a procedure: which frames it has, what their surfaces look like and under which keys they lie."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lappet.anatomy.tissue_layers import TissueLayers
from lappet.anatomy.vessel_pieces import VesselPieces
from lappet.core.problem import Problem
from lappet.cutting.epoch import no_entries
from lappet.procedure import Vessel


@dataclass(frozen=True, eq=False)
class EpochShape:
    """The surface of an epoch, as far as it is shown.

    Parameters
    ----------
    key
        The same for the same surface, 64 hexadecimal digits.
    start_time
        Time code at which the epoch begins.
    rest
        Vertices at rest in mm, shape (n, 3), float32.
    triangles
        Vertex indices, shape (m, 3), int32.
    origin
        `FaceOrigin` of each triangle, shape (m,), uint8: 0 skin, 1 wound wall, 2 underside, 3 rim.
    grid
        Texture coordinates per corner in mm along the skin, shape (m, 3, 2), float32.
    depth
        Depth below the skin before any cut in mm, shape (n,), float32: `lappet.anatomy.tissue_layers.SurfaceLayers`.
    face
        Face of the tissue's mesh that each triangle lies on, -1 for wound walls, shape (m,), int32.
    column
        Column of layers that each triangle lies in (`Manifest.layers`), shape (m,), int32; without entries the first.
    lining
        1 for triangles that are underside with nothing below it, else 0, shape (m,), uint8; without entries none.
    """

    key: str
    start_time: float
    rest: NDArray[np.float32]
    triangles: NDArray[np.int32]
    origin: NDArray[np.uint8]
    grid: NDArray[np.float32]
    depth: NDArray[np.float32]
    face: NDArray[np.int32]
    column: NDArray[np.int32] = field(default_factory=lambda: no_entries((0,), np.int32))
    lining: NDArray[np.uint8] = field(default_factory=lambda: no_entries((0,), np.uint8))


@dataclass(frozen=True)
class ListedFrame:
    """A frame of a manifest.

    Parameters
    ----------
    time
        Time code.
    epoch
        Index of its epoch in `Manifest.epochs`.
    key
        Its key in the store.
    hooks
        Indices in `Manifest.hooks` of those that pull, in the order of the frame's hook arrays.
    sutures
        Indices in `Manifest.sutures` of those placed by now, in the order of the frame's suture arrays.
    """

    time: int
    epoch: int
    key: str
    hooks: tuple[int, ...] = ()
    sutures: tuple[int, ...] = ()


@dataclass(frozen=True, eq=False)
class Manifest:
    """A compiled procedure without what only the solver needs: which frames there are and under which keys they lie.

    Parameters
    ----------
    key
        Key of the procedure and the settings (`manifest_key`).
    epochs
        Surfaces of the epochs.
    frames
        The frames.
    hooks
        Names of the hooks.
    sutures
        Names of the sutures.
    landmarks
        A label per point.
    landmarks_at
        For each epoch the indices in `landmarks` of those that its tissue still holds.
    notes
        Warnings and notes for the user.
    layers
        The layers of the tissue.
    vessels
        The vessels.
    vessels_at
        For each epoch what its tissue holds of them.
    """

    key: str
    epochs: tuple[EpochShape, ...]
    frames: tuple[ListedFrame, ...]
    hooks: tuple[str, ...] = ()
    sutures: tuple[str, ...] = ()
    landmarks: tuple[str, ...] = ()
    landmarks_at: tuple[tuple[int, ...], ...] = ()
    notes: tuple[Problem, ...] = ()
    layers: TissueLayers = field(default_factory=TissueLayers)
    vessels: tuple[Vessel, ...] = ()
    vessels_at: tuple[VesselPieces, ...] = ()
